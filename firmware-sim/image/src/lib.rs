//! What the images share: the embedded model and samples, and the board.
#![no_std]

pub mod board;
pub mod embedded;
