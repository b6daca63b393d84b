//! Cortex-M: the crates cortex-m and cortex-m-rt.

use core::ptr;

pub use cortex_m_rt::entry;

/// Lowest word of the stack's memory, and its end.
pub fn stack() -> (*mut u32, *mut u32) {
    unsafe extern "C" {
        static mut _stack_start: u32;
        static mut _stack_end: u32;
    }
    (ptr::addr_of_mut!(_stack_end), ptr::addr_of_mut!(_stack_start))
}

/// Waits for an interrupt.
pub fn wait() {
    ::cortex_m::asm::wfi();
}

/// Sends hard faults to a `fn(address: u32) -> !`; they would else hang until the emulator's timeout.
#[macro_export]
macro_rules! on_fault {
    ($handler:path) => {
        #[::cortex_m_rt::exception]
        unsafe fn HardFault(frame: &::cortex_m_rt::ExceptionFrame) -> ! {
            $handler(frame.pc())
        }
    };
}
