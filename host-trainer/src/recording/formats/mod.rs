//! Formats of recordings, a file each.

pub mod csv;
pub mod femto;
pub mod mat;
pub mod npy;
pub mod parquet;
