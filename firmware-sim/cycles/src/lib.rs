//! A plugin of QEMU that times the executed instructions of an image as a Cortex-M4F would, and says to which stage of
//! the evaluator each belongs.
//!
//! | module | holds |
//! |---|---|
//! | [`registers`] | sets of core and floating-point registers |
//! | [`instruction`] | an instruction as its disassembly says: kind, registers, address |
//! | [`timing`] | the Cortex-M4's times, and its flash |
//! | [`stage`] | stages, by the inlined frames of the debug information |
//! | [`trace`] | the executed instructions, sample by sample |
//! | [`report`] | table and JSON |
//! | `plugin` | QEMU's side |

pub mod instruction;
#[cfg(not(test))]
mod plugin;
pub mod registers;
pub mod report;
pub mod stage;
pub mod timing;
pub mod trace;
