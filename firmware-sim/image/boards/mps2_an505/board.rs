//! Arm MPS2 with the AN505 image: a Cortex-M33 with its single-precision unit, and a CMSDK timer. Registers: Arm DAI 0505,
//! section 3, at their secure addresses.

/// The board's 20 MHz CMSDK timer, counting instructions.
///
/// Under `-icount shift=10` an instruction takes 1024 ns and a tick 50 ns, so that one instruction is
/// 20.48 ticks: exact to one reading, and the same in every run.
#[derive(Debug)]
pub struct InstructionCounter {
    last: u32,
}

const TIMER_CONTROL: *mut u32 = 0x5000_0000 as *mut u32;
const TIMER_VALUE: *mut u32 = 0x5000_0004 as *mut u32;
const TIMER_RELOAD: *mut u32 = 0x5000_0008 as *mut u32;

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

    /// Ticks since the last lap; the timer counts down and wraps every 209 million instructions.
    pub fn lap(&mut self) -> u32 {
        // SAFETY: reading the register has no effect.
        let now = unsafe { TIMER_VALUE.read_volatile() };
        let ticks = self.last.wrapping_sub(now);
        self.last = now;
        ticks
    }

    /// Instructions that a number of ticks stands for.
    pub const fn instructions(ticks: u64) -> u64 {
        // 1 / 20.48 = 25 / 512.
        (ticks * 25 + 256) / 512
    }
}
