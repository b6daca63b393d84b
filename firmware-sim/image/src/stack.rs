//! Stack use of a run, by paint.

use core::ptr;

use crate::arch;

/// Word that unused stack holds.
const PAINT: u32 = 0xcccc_cccc;
/// Bytes below [`paint`]'s own frame that are left alone.
const MARGIN: usize = 64;

/// Paints the unused stack.
#[inline(never)]
pub fn paint() {
    let here = 0_u32;
    let end = ptr::from_ref(core::hint::black_box(&here)) as usize - MARGIN;
    let (mut at, _) = arch::stack();
    while (at as usize) < end {
        // SAFETY: RAM between the statics and this frame, which nothing uses yet.
        unsafe { at.write_volatile(PAINT) };
        at = at.wrapping_add(1);
    }
}

/// Most bytes of stack that were in use since the paint: what is left of it.
pub fn high_water() -> usize {
    let (mut at, end) = arch::stack();
    // SAFETY: both are the linker's and word-aligned, and all between them is RAM.
    while at < end && unsafe { at.read_volatile() } == PAINT {
        at = at.wrapping_add(1);
    }
    end as usize - at as usize
}
