//! RISC-V of 32 bits: the crates riscv and riscv-rt.

use core::ptr;

pub use riscv_rt::entry;

/// Lowest word of the stack's memory, and its end.
pub fn stack() -> (*mut u32, *mut u32) {
    unsafe extern "C" {
        static mut _stack_start: u32;
        static mut __estack: u32;
    }
    (ptr::addr_of_mut!(__estack), ptr::addr_of_mut!(_stack_start))
}

/// Waits for an interrupt.
pub fn wait() {
    ::riscv::asm::wfi();
}

/// Sends exceptions to a `fn(address: u32) -> !`; they would else hang until the emulator's timeout.
#[macro_export]
macro_rules! on_fault {
    ($handler:path) => {
        #[unsafe(export_name = "ExceptionHandler")]
        extern "C" fn exception(_: &::riscv_rt::TrapFrame) -> ! {
            $handler(::riscv::register::mepc::read() as u32)
        }
    };
}
