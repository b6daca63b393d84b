//! What differs between architectures: start-up, the stack's place, waiting, and the handler of faults.
//!
//! Each has `entry`, `stack`, `wait`, and a macro `on_fault!` that sends faults to a function of an address.

#[cfg(target_arch = "arm")]
mod cortex_m;
#[cfg(target_arch = "arm")]
pub use cortex_m::*;

#[cfg(target_arch = "riscv32")]
mod riscv;
#[cfg(target_arch = "riscv32")]
pub use riscv::*;
