//! Image of all calls of `ballrace-core`'s device, and nothing else, to measure an application's flash and RAM and to
//! find any `core::panicking` that the device can reach. `compare.sh` checks both; run, the image prints nothing.
#![no_std]
#![no_main]

use core::hint::black_box;
use core::panic::PanicInfo;

use ballrace_core::device::Device;
use ballrace_core::model::Model;
use ballrace_image::arch::{self, entry};
use ballrace_image::{embedded, scratch};

#[entry]
fn main() -> ! {
    if let Ok(model) = Model::from_bytes(embedded::model()) {
        // Opaque lengths, or the compiler proves that they fit.
        let (scratch, samples) = (black_box(scratch::take()), embedded::samples());
        if let Ok(mut device) = Device::new(&model, scratch) {
            for sample in samples.iter() {
                black_box(device.push(sample));
                black_box(device.missing(black_box(0)));
                black_box(device.summary());
            }
            black_box(device.end_of_recording());
        }
    }
    halt()
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    halt()
}

/// Halts without semihosting, whose code may panic.
fn halt() -> ! {
    loop {
        arch::wait();
    }
}
