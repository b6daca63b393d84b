//! Shared parts of the images: the embedded model and samples, and the board, a folder of `boards` that `BALLRACE_BOARD` names.
//! All of the images' `unsafe` is in [`arch`], [`board`], [`scratch`] and [`stack`].
#![no_std]

// Linked for its logger.
#[cfg(feature = "defmt")]
use defmt_semihosting as _;

include!(concat!(env!("OUT_DIR"), "/board_module.rs"));

pub mod arch;
pub mod embedded;
pub mod scratch;
pub mod semihosted;
pub mod stack;
