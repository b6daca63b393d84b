//! What the images share: the embedded model and samples, and the board, a folder of `boards` that `BALLRACE_BOARD` names.
//! All of the images' `unsafe` is in [`board`] and [`semihosted`].
#![no_std]

// Only its logger is wanted.
#[cfg(feature = "defmt")]
use defmt_semihosting as _;

include!(concat!(env!("OUT_DIR"), "/board_module.rs"));
pub mod embedded;
pub mod semihosted;
