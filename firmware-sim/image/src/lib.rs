//! Shared parts of the images: the embedded model and samples, and the board.
#![no_std]

// Linked for its logger.
#[cfg(feature = "defmt")]
use defmt_semihosting as _;

pub mod board;
pub mod embedded;
