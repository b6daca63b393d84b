//! SiFive HiFive1 rev B: an FE310-G002, RV32IMAC without a unit for floating point. Registers: SiFive FE310-G002 Manual,
//! chapter 9.

/// `mtime` of the core-local interruptor, which QEMU runs at 10 MHz, counting instructions.
///
/// Under `-icount shift=10` an instruction takes 1024 ns and a tick 100 ns, so that one instruction is 10.24 ticks: exact
/// to one reading, and the same in every run.
#[derive(Debug)]
pub struct InstructionCounter {
    last: u32,
}

/// Low word of `mtime`.
const TIME: *const u32 = 0x0200_bff8 as *const u32;

impl InstructionCounter {
    /// Begins to count; the timer always runs.
    pub fn start() -> Self {
        let mut counter = Self { last: 0 };
        counter.lap();
        counter
    }

    /// Ticks since the last lap; the low word wraps every 419 million instructions.
    pub fn lap(&mut self) -> u32 {
        // SAFETY: reading the register has no effect.
        let now = unsafe { TIME.read_volatile() };
        let ticks = now.wrapping_sub(self.last);
        self.last = now;
        ticks
    }

    /// Instructions that a number of ticks stands for.
    pub const fn instructions(ticks: u64) -> u64 {
        // 1 / 10.24 = 25 / 256.
        (ticks * 25 + 128) / 256
    }
}
