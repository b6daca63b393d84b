//! What every Cortex-M under an emulator has: its stack, its output, its way out.

use core::ptr;

use cortex_m_semihosting::debug;

/// Most bytes of stack that were in use so far: what is left of the paint that the start-up put there.
pub fn stack_high_water() -> usize {
    unsafe extern "C" {
        static _stack_start: u32;
        static _stack_end: u32;
    }
    let (top, mut at) = (&raw const _stack_start, &raw const _stack_end);
    // SAFETY: both symbols are the linker's and word-aligned, and all between them is RAM.
    while at < top && unsafe { ptr::read_volatile(at) } == cortex_m_rt::STACK_PAINT_VALUE {
        at = at.wrapping_add(1);
    }
    top as usize - at as usize
}

/// Says a line of text.
#[cfg(not(feature = "defmt"))]
pub fn say(line: &str) {
    if let Ok(mut out) = cortex_m_semihosting::hio::hstdout() {
        // Nowhere to report an error of the only output to.
        let _ = out.write_all(line.as_bytes());
        let _ = out.write_all(b"\n");
    }
}

/// Says a line of text, through defmt.
#[cfg(feature = "defmt")]
pub fn say(line: &str) {
    defmt::println!("{=str}", line);
}

/// Ends the emulator.
pub fn exit(success: bool) -> ! {
    debug::exit(if success { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    // A debugger may go on; there is nothing to go on with.
    loop {
        cortex_m::asm::wfi();
    }
}
