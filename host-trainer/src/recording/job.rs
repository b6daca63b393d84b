//! Job of reading one recording: the file, its format, and what is stated about it.

use std::path::Path;

use super::{ReadError, manifest::Entry};

/// One recording to read.
#[derive(Clone, Debug)]
pub(super) struct Job {
    pub entry: Entry,
    pub format: Format,
    pub variable: Option<String>,
    /// Index of the path that the recording comes from; days are counted within a path.
    pub group: usize,
}

/// Format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    /// FEMTO or with a header, depending on the contents.
    Csv,
    Mat,
    Npy,
    Parquet,
}

impl Format {
    /// Format by the file's ending.
    pub fn from_path(path: &Path) -> Result<Self, ReadError> {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        match ending.as_str() {
            "csv" => Ok(Self::Csv),
            "mat" => Ok(Self::Mat),
            "npy" => Ok(Self::Npy),
            "parquet" => Ok(Self::Parquet),
            _ => Err(ReadError::UnknownFormat { path: path.into(), found: ending }),
        }
    }
}
