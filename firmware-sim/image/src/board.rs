//! Emulated board: timer, stack, output, exit. All of the images' `unsafe` is here.

use core::ptr;

use cortex_m_semihosting::debug;

/// Instruction counter by the board's 25 MHz CMSDK timer.
///
/// Under `-icount shift=10` an instruction takes 1024 ns and a tick 40 ns, so that one instruction is
/// 25.6 ticks: exact to one reading, and reproducible.
#[derive(Debug)]
pub struct InstructionCounter {
    last: u32,
}

const TIMER_CONTROL: *mut u32 = 0x4000_0000 as *mut u32;
const TIMER_VALUE: *mut u32 = 0x4000_0004 as *mut u32;
const TIMER_RELOAD: *mut u32 = 0x4000_0008 as *mut u32;

impl InstructionCounter {
    /// Starts the timer.
    pub fn start() -> Self {
        // SAFETY: registers of a timer that nothing else uses.
        unsafe {
            TIMER_RELOAD.write_volatile(u32::MAX);
            TIMER_VALUE.write_volatile(u32::MAX);
            TIMER_CONTROL.write_volatile(1);
        }
        let mut counter = Self { last: 0 };
        counter.lap();
        counter
    }

    /// Ticks since the last lap; the timer counts down and wraps every 167 million instructions.
    pub fn lap(&mut self) -> u32 {
        // SAFETY: reading the register has no effect.
        let now = unsafe { TIMER_VALUE.read_volatile() };
        let ticks = self.last.wrapping_sub(now);
        self.last = now;
        ticks
    }

    /// Number of instructions of a number of ticks.
    pub const fn instructions(ticks: u64) -> u64 {
        // 1 / 25.6 = 5 / 128.
        (ticks * 5 + 64) / 128
    }
}

/// Greatest stack use so far, bytes, by the rest of the start-up's paint.
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

/// Prints a line of text.
#[cfg(not(feature = "defmt"))]
pub fn say(line: &str) {
    if let Ok(mut out) = cortex_m_semihosting::hio::hstdout() {
        // An error of the only output cannot be reported.
        let _ = out.write_all(line.as_bytes());
        let _ = out.write_all(b"\n");
    }
}

/// Prints a line of text, through defmt.
#[cfg(feature = "defmt")]
pub fn say(line: &str) {
    defmt::println!("{=str}", line);
}

/// Ends the emulator.
pub fn exit(success: bool) -> ! {
    debug::exit(if success { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    // A debugger may continue from here.
    loop {
        cortex_m::asm::wfi();
    }
}
