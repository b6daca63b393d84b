//! BBC micro:bit: a Nordic nRF51822 with a Cortex-M0, and no unit for floating point. Registers: Nordic nRF51 Series
//! Reference Manual 3.0, section 18.

/// Timer 0 at 16 MHz, counting instructions.
///
/// Under `-icount shift=10` an instruction takes 1024 ns and a tick 62.5 ns, so that one instruction is 16.384 ticks:
/// exact to one reading, and the same in every run.
#[derive(Debug)]
pub struct InstructionCounter {
    last: u32,
}

const TASK_START: *mut u32 = 0x4000_8000 as *mut u32;
const TASK_CAPTURE: *mut u32 = 0x4000_8040 as *mut u32;
const BITMODE: *mut u32 = 0x4000_8508 as *mut u32;
const PRESCALER: *mut u32 = 0x4000_8510 as *mut u32;
const CAPTURED: *const u32 = 0x4000_8540 as *const u32;
/// 32 bits in register `BITMODE`.
const BITS_32: u32 = 3;

impl InstructionCounter {
    /// Starts the timer.
    pub fn start() -> Self {
        // SAFETY: registers of a timer that nothing else uses.
        unsafe {
            BITMODE.write_volatile(BITS_32);
            PRESCALER.write_volatile(0);
            TASK_START.write_volatile(1);
        }
        let mut counter = Self { last: 0 };
        counter.lap();
        counter
    }

    /// Ticks since the last lap; the timer wraps every 262 million instructions.
    pub fn lap(&mut self) -> u32 {
        // SAFETY: registers of a timer that nothing else uses.
        let now = unsafe {
            TASK_CAPTURE.write_volatile(1);
            CAPTURED.read_volatile()
        };
        let ticks = now.wrapping_sub(self.last);
        self.last = now;
        ticks
    }

    /// Instructions that a number of ticks stands for.
    pub const fn instructions(ticks: u64) -> u64 {
        // 1 / 16.384 = 125 / 2048.
        (ticks * 125 + 1024) / 2048
    }
}
