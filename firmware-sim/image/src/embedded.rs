//! Embedded model and samples, chosen when the image is built (see `build.rs`).

use ballrace_core::Floats;

include!(concat!(env!("OUT_DIR"), "/scratch_len.rs"));

/// Bytes at a word's boundary: not needed by the model, but aligned words load faster.
#[repr(C, align(4))]
struct Aligned<T: ?Sized>(T);

static MODEL: &Aligned<[u8]> = &Aligned(*include_bytes!(concat!(env!("OUT_DIR"), "/model.bin")));
static SAMPLES: &Aligned<[u8]> = &Aligned(*include_bytes!(concat!(env!("OUT_DIR"), "/samples.f32")));

/// Binary form of the model, in flash.
pub fn model() -> &'static [u8] {
    // Opaque, or the compiler folds this model's sizes into the measured code.
    core::hint::black_box(&MODEL.0)
}

/// Samples, m/s².
pub fn samples() -> Floats<'static> {
    Floats(core::hint::black_box(&SAMPLES.0).as_chunks().0)
}
