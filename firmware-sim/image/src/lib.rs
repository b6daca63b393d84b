//! What the images share: the embedded model and samples, and the board.
#![no_std]

// Only its logger is wanted.
#[cfg(feature = "defmt")]
use defmt_semihosting as _;

pub mod board;
pub mod embedded;
