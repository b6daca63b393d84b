//! Shared parts of the images: the embedded model and samples, and the board, a folder of `boards` that `BALLRACE_BOARD` names.
//! All of the images' `unsafe` is in [`board`] and [`semihosted`].
#![no_std]

// Linked for its logger.
#[cfg(feature = "defmt")]
use defmt_semihosting as _;

include!(concat!(env!("OUT_DIR"), "/board_module.rs"));
pub mod embedded;
pub mod semihosted;
