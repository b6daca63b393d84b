//! The model and the samples, chosen when the image is built (see `build.rs`).

use ballrace_core::Floats;

include!(concat!(env!("OUT_DIR"), "/scratch_len.rs"));

/// Bytes at a word's boundary. The model may lie anywhere, but whole words load faster.
#[repr(C, align(4))]
struct Aligned<T: ?Sized>(T);

static MODEL: &Aligned<[u8]> = &Aligned(*include_bytes!(concat!(env!("OUT_DIR"), "/model.bin")));
static SAMPLES: &Aligned<[u8]> = &Aligned(*include_bytes!(concat!(env!("OUT_DIR"), "/samples.f32")));

/// The binary form of the model, where it lies in flash.
pub fn model() -> &'static [u8] {
    // Opaque, or the compiler would fold this one model's sizes into the code that is measured.
    core::hint::black_box(&MODEL.0)
}

/// The samples, m/s².
pub fn samples() -> Floats<'static> {
    Floats(core::hint::black_box(&SAMPLES.0).as_chunks().0)
}
