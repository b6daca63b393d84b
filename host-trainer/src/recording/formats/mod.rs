//! Readers of recordings, one module for each format.

pub mod csv;
pub mod femto;
pub mod mat;
pub mod npy;
pub mod parquet;
