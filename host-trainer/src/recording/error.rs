//! Errors of reading recordings, each with its place.

use std::{
    io,
    path::{Path, PathBuf},
};

/// Failure to read a recording.
///
/// Every message reads `place: found X, expected Y`. Rows count from 1 and are lines of a text
/// file (comments and the header included), samples of a binary one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// Error of the operating system.
    #[error("{path}: found `{source}`, expected a readable file")]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
    /// Path that does not exist.
    #[error("{path}: found nothing there, expected a recording or a folder of recordings")]
    NotFound {
        /// Path as given.
        path: PathBuf,
    },
    /// Folder without a readable file.
    #[error(
        "{path}: found no recordings, expected recordings.toml, acc_*.csv, or other .csv, .mat, .npy, .parquet files"
    )]
    NoRecordings {
        /// Path of the folder.
        path: PathBuf,
    },
    /// File name with an unknown ending.
    #[error("{path}: found ending `{found}`, expected .csv, .mat, .npy, .parquet or .toml")]
    UnknownFormat {
        /// Path of the file.
        path: PathBuf,
        /// Ending found.
        found: String,
    },
    /// A file without a sample.
    #[error("{path}: found no samples, expected at least one row")]
    Empty {
        /// Path of the file.
        path: PathBuf,
    },
    /// A row that is ragged or cut short.
    #[error("{path}, row {row}: found {found} columns, expected {expected}")]
    RowWidth {
        /// Path of the file.
        path: PathBuf,
        /// Line, from 1.
        row: usize,
        /// Columns in this row.
        found: usize,
        /// Columns in the format or the header.
        expected: usize,
    },
    /// A field that is not a number.
    #[error("{path}, row {row}, column `{column}`: found `{found}`, expected a number")]
    NotANumber {
        /// Path of the file.
        path: PathBuf,
        /// Line, from 1.
        row: usize,
        /// Column name.
        column: String,
        /// Text found.
        found: String,
    },
    /// NaN, an infinity, or a number beyond the range of `f64`.
    #[error("{path}, row {row}, column `{column}`: found {found}, expected a finite number")]
    NotFinite {
        /// Path of the file.
        path: PathBuf,
        /// Row, from 1.
        row: usize,
        /// Column name.
        column: String,
        /// Value or text found.
        found: String,
    },
    /// A number beyond any sample.
    #[error("{path}, row {row}, column `{column}`: found {found}, expected a number within ±1e30")]
    TooLarge {
        /// Path of the file.
        path: PathBuf,
        /// Row, from 1.
        row: usize,
        /// Column name.
        column: String,
        /// Value or text found.
        found: String,
    },
    /// A file of more samples than can be held.
    #[error("{path}: found more than {most} samples in all channels, expected a file that is cut into shorter ones")]
    TooMany {
        /// Path of the file.
        path: PathBuf,
        /// Most samples.
        most: usize,
    },
    /// A table that begins with numbers where its column names should be.
    #[error("{path}, row {row}: found `{found}`, expected a header with column names")]
    MissingHeader {
        /// Path of the file.
        path: PathBuf,
        /// Line, from 1.
        row: usize,
        /// Line found.
        found: String,
    },
    /// Two columns of one name.
    #[error("{path}, row {row}: found column `{column}` twice, expected each name once")]
    DuplicateColumn {
        /// Path of the file.
        path: PathBuf,
        /// Line of the header, from 1.
        row: usize,
        /// Column name.
        column: String,
    },
    /// Requested channel that the file does not have.
    #[error("{path}: found channels {available}, expected `{channel}` among them")]
    UnknownChannel {
        /// Path of the file.
        path: PathBuf,
        /// Channel requested.
        channel: String,
        /// Channels of the file.
        available: String,
    },
    /// Requested variable that the `.mat` file does not have.
    #[error("{path}: found variables {available}, expected `{variable}` among them")]
    UnknownVariable {
        /// Path of the file.
        path: PathBuf,
        /// Variable requested.
        variable: String,
        /// Numeric variables of the file.
        available: String,
    },
    /// Sample rate neither stated nor found in a time column.
    #[error("{path}, sample_rate_hz: found none stated and no time column, expected a sample rate in Hz")]
    MissingRate {
        /// Path of the file.
        path: PathBuf,
    },
    /// A sample rate, or one to resample to, out of range.
    #[error("{path}, {key}: found {found} Hz, expected {expected}")]
    BadRate {
        /// Path of the file.
        path: PathBuf,
        /// `sample_rate_hz` or `resample_hz`.
        key: &'static str,
        /// Rate, Hz.
        found: f64,
        /// Rates expected.
        expected: String,
    },
    /// A time column that does not increase.
    #[error("{path}, row {row}, column `{column}`: found {found} s after {before} s, expected time to increase")]
    TimeNotIncreasing {
        /// Path of the file.
        path: PathBuf,
        /// Row, from 1.
        row: usize,
        /// Name of the time column.
        column: String,
        /// Time in this row, s.
        found: f64,
        /// Time in the row before, s.
        before: f64,
    },
    /// A `.mat` file that breaks its format or uses an unsupported part of it.
    #[error("{path}, byte {offset}: found {found}, expected {expected}")]
    BadMat {
        /// Path of the file.
        path: PathBuf,
        /// Offset into the file, or into the unpacked data of a compressed element.
        offset: usize,
        /// Contents found.
        found: String,
        /// Contents expected.
        expected: &'static str,
    },
    /// A `.npy` file that breaks its format or holds an unsupported type.
    #[error("{path}, {part}: found {found}, expected {expected}")]
    BadNpy {
        /// Path of the file.
        path: PathBuf,
        /// `magic`, `header`, or a key of the header.
        part: &'static str,
        /// Contents found.
        found: String,
        /// Contents expected.
        expected: &'static str,
    },
    /// A Parquet file that cannot be decoded.
    #[error("{path}, {part}: found {found}, expected {expected}")]
    BadParquet {
        /// Path of the file.
        path: PathBuf,
        /// `footer`, `row group N`, or a column.
        part: String,
        /// Contents found.
        found: String,
        /// Contents expected.
        expected: &'static str,
    },
    /// A manifest that is not TOML.
    #[error("{path}, row {row}: found {found}, expected TOML")]
    ManifestSyntax {
        /// Path of the manifest.
        path: PathBuf,
        /// Line, from 1.
        row: usize,
        /// Message of the parser.
        found: String,
    },
    /// Unknown key of a manifest.
    #[error("{path}, {key}: found an unknown key, expected one of {expected}")]
    UnknownKey {
        /// Path of the manifest.
        path: PathBuf,
        /// The key with its table, such as `recording[2].rpm`.
        key: String,
        /// Known keys.
        expected: &'static str,
    },
    /// Missing key of a manifest.
    #[error("{path}, {key}: found nothing, expected {expected}")]
    MissingKey {
        /// Path of the manifest.
        path: PathBuf,
        /// The key with its table.
        key: String,
        /// Value expected.
        expected: &'static str,
    },
    /// A value of a wrong type or out of range.
    #[error("{path}, {key}: found {found}, expected {expected}")]
    BadValue {
        /// Path of the manifest.
        path: PathBuf,
        /// The key with its table, such as `recording[2].sample_rate_hz`.
        key: String,
        /// Value found.
        found: String,
        /// Value expected.
        expected: &'static str,
    },
    /// An option of [`LoadOptions`](super::LoadOptions) out of range.
    #[error("{option}: found {found}, expected {expected}")]
    BadOption {
        /// Field of the options.
        option: &'static str,
        /// Value found.
        found: String,
        /// Value expected.
        expected: String,
    },
}

impl ReadError {
    /// Error of the operating system at a path.
    pub(super) fn of(path: &Path, source: io::Error) -> Self {
        match source.kind() {
            io::ErrorKind::NotFound => Self::NotFound { path: path.into() },
            _ => Self::Io { path: path.into(), source },
        }
    }

    /// Error of a number that cannot be a sample; `found` is its text.
    pub(super) fn not_a_sample(path: &Path, row: usize, column: String, value: f64, found: String) -> Self {
        let path = path.into();
        if value.is_finite() {
            Self::TooLarge { path, row, column, found }
        } else {
            Self::NotFinite { path, row, column, found }
        }
    }

    /// Whether the contents of one recording are at fault, so that the others can still be read; not the caller's
    /// request or the operating system.
    pub(super) fn is_content(&self) -> bool {
        match self {
            Self::Empty { .. }
            | Self::RowWidth { .. }
            | Self::NotANumber { .. }
            | Self::NotFinite { .. }
            | Self::TooLarge { .. }
            | Self::TooMany { .. }
            | Self::MissingHeader { .. }
            | Self::DuplicateColumn { .. }
            | Self::TimeNotIncreasing { .. }
            | Self::BadMat { .. }
            | Self::BadNpy { .. }
            | Self::BadParquet { .. } => true,
            Self::Io { .. }
            | Self::NotFound { .. }
            | Self::NoRecordings { .. }
            | Self::UnknownFormat { .. }
            | Self::UnknownChannel { .. }
            | Self::UnknownVariable { .. }
            | Self::MissingRate { .. }
            | Self::BadRate { .. }
            | Self::ManifestSyntax { .. }
            | Self::UnknownKey { .. }
            | Self::MissingKey { .. }
            | Self::BadValue { .. }
            | Self::BadOption { .. } => false,
        }
    }
}

/// Text for a message: one line, at most 40 characters.
pub(super) fn shown(text: &[u8]) -> String {
    const LIMIT: usize = 40;
    // Four bytes hold any character, so this prefix is enough however long the line is.
    let head = &text[..text.len().min(4 * (LIMIT + 1))];
    let text = String::from_utf8_lossy(head);
    let mut short: String = text.chars().take(LIMIT).flat_map(char::escape_debug).collect();
    if text.chars().nth(LIMIT).is_some() {
        short.push('…');
    }
    short
}

/// List of names for a message.
pub(super) fn listed<S: AsRef<str>>(names: impl IntoIterator<Item = S>) -> String {
    let names: Vec<String> = names.into_iter().map(|n| format!("`{}`", n.as_ref())).collect();
    if names.is_empty() { "(none)".into() } else { names.join(", ") }
}
