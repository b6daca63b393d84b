//! The device's memory, taken once.

use core::cell::{Cell, UnsafeCell};

use crate::embedded::SCRATCH_LEN;

struct Scratch {
    floats: UnsafeCell<[f32; SCRATCH_LEN]>,
    taken: Cell<bool>,
}

// SAFETY: the images have one core, and no interrupt handler takes the scratch.
unsafe impl Sync for Scratch {}

static SCRATCH: Scratch = Scratch { floats: UnsafeCell::new([0.0; SCRATCH_LEN]), taken: Cell::new(false) };

/// Floats that the embedded model needs; none when taken before.
pub fn take() -> &'static mut [f32] {
    if SCRATCH.taken.replace(true) {
        return &mut [];
    }
    // SAFETY: the flag lets one reference out.
    unsafe { &mut *SCRATCH.floats.get() }
}
