//! The ways in which a recording can be unreadable, each with its place.

use std::{io, path::PathBuf};

/// Why a recording could not be read.
///
/// Every message reads `place: found X, expected Y`. Rows count from 1 and are lines of a text
/// file (comments and the header included), samples of a binary one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The operating system refused.
    #[error("{path}: found `{source}`, expected a readable file")]
    Io {
        /// File or folder.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// There is nothing at this path.
    #[error("{path}: found nothing there, expected a recording or a folder of recordings")]
    NotFound {
        /// The path as given.
        path: PathBuf,
    },
    /// A folder without anything readable.
    #[error(
        "{path}: found no recordings, expected recordings.toml, acc_*.csv, or other .csv, .mat, .npy, .parquet files"
    )]
    NoRecordings {
        /// The folder.
        path: PathBuf,
    },
    /// The ending of a file name is not one of the formats.
    #[error("{path}: found ending `{found}`, expected .csv, .mat, .npy, .parquet or .toml")]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// Its ending.
        found: String,
    },
    /// A file without a sample.
    #[error("{path}: found no samples, expected at least one row")]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// A row that is ragged or cut short.
    #[error("{path}, row {row}: found {found} columns, expected {expected}")]
    RowWidth {
        /// The file.
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
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        row: usize,
        /// Column name.
        column: String,
        /// The text found.
        found: String,
    },
    /// NaN, an infinity, or a number beyond the range of `f64`.
    #[error("{path}, row {row}, column `{column}`: found {found}, expected a finite number")]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// Row, from 1.
        row: usize,
        /// Column name.
        column: String,
        /// The value or text found.
        found: String,
    },
    /// A table that begins with numbers where its column names should be.
    #[error("{path}, row {row}: found `{found}`, expected a header with column names")]
    MissingHeader {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        row: usize,
        /// The line found.
        found: String,
    },
    /// Two columns of one name.
    #[error("{path}, row {row}: found column `{column}` twice, expected each name once")]
    DuplicateColumn {
        /// The file.
        path: PathBuf,
        /// Line of the header, from 1.
        row: usize,
        /// The name.
        column: String,
    },
    /// A channel that was asked for is not there.
    #[error("{path}: found channels {available}, expected `{channel}` among them")]
    UnknownChannel {
        /// The file.
        path: PathBuf,
        /// The channel asked for.
        channel: String,
        /// The channels of the file.
        available: String,
    },
    /// A variable of a `.mat` file that was asked for is not there.
    #[error("{path}: found variables {available}, expected `{variable}` among them")]
    UnknownVariable {
        /// The file.
        path: PathBuf,
        /// The variable asked for.
        variable: String,
        /// The numeric variables of the file.
        available: String,
    },
    /// Nobody states the sample rate.
    #[error("{path}, sample_rate_hz: found none stated and no time column, expected a sample rate in Hz")]
    MissingRate {
        /// The file.
        path: PathBuf,
    },
    /// A time column that does not increase.
    #[error("{path}, row {row}, column `{column}`: found {found} s after {before} s, expected time to increase")]
    TimeNotIncreasing {
        /// The file.
        path: PathBuf,
        /// Row, from 1.
        row: usize,
        /// The time column.
        column: String,
        /// Time in this row, s.
        found: f64,
        /// Time in the row before, s.
        before: f64,
    },
    /// A `.mat` file that breaks its format or uses a part of it that is not read.
    #[error("{path}, byte {offset}: found {found}, expected {expected}")]
    BadMat {
        /// The file.
        path: PathBuf,
        /// Offset into the file, or into the unpacked data of a compressed element.
        offset: usize,
        /// What is there.
        found: String,
        /// What should be.
        expected: &'static str,
    },
    /// A `.npy` file that breaks its format or holds a type that is not read.
    #[error("{path}, {part}: found {found}, expected {expected}")]
    BadNpy {
        /// The file.
        path: PathBuf,
        /// `magic`, `header`, or a key of the header.
        part: &'static str,
        /// What is there.
        found: String,
        /// What should be.
        expected: &'static str,
    },
    /// A Parquet file that cannot be decoded.
    #[error("{path}, {part}: found {found}, expected {expected}")]
    BadParquet {
        /// The file.
        path: PathBuf,
        /// `footer`, `row group N`, or a column.
        part: String,
        /// What is there.
        found: String,
        /// What should be.
        expected: &'static str,
    },
    /// A manifest that is not TOML.
    #[error("{path}, row {row}: found {found}, expected TOML")]
    ManifestSyntax {
        /// The manifest.
        path: PathBuf,
        /// Line, from 1.
        row: usize,
        /// What the parser said.
        found: String,
    },
    /// A key that the manifest does not have.
    #[error("{path}, {key}: found an unknown key, expected one of {expected}")]
    UnknownKey {
        /// The manifest.
        path: PathBuf,
        /// The key with its table, such as `recording[2].rpm`.
        key: String,
        /// The keys there are.
        expected: &'static str,
    },
    /// A key that the manifest must have.
    #[error("{path}, {key}: found nothing, expected {expected}")]
    MissingKey {
        /// The manifest.
        path: PathBuf,
        /// The key with its table.
        key: String,
        /// What should be there.
        expected: &'static str,
    },
    /// A value of a wrong type or out of range.
    #[error("{path}, {key}: found {found}, expected {expected}")]
    BadValue {
        /// The manifest.
        path: PathBuf,
        /// The key with its table, such as `recording[2].sample_rate_hz`.
        key: String,
        /// The value.
        found: String,
        /// What should be there.
        expected: &'static str,
    },
    /// An option of [`LoadOptions`](super::LoadOptions) that cannot be.
    #[error("{option}: found {found}, expected {expected}")]
    BadOption {
        /// The field of the options.
        option: &'static str,
        /// Its value.
        found: String,
        /// What it can be.
        expected: String,
    },
}

impl ReadError {
    /// True where the contents of one recording are at fault, so that the others can still be
    /// read; false for what the caller asked for and for the operating system.
    pub(super) fn is_content(&self) -> bool {
        matches!(
            self,
            Self::Empty { .. }
                | Self::RowWidth { .. }
                | Self::NotANumber { .. }
                | Self::NotFinite { .. }
                | Self::MissingHeader { .. }
                | Self::DuplicateColumn { .. }
                | Self::TimeNotIncreasing { .. }
                | Self::BadMat { .. }
                | Self::BadNpy { .. }
                | Self::BadParquet { .. }
        )
    }
}

/// Text as a message shows it: one line, at most 40 characters.
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

/// Names as a message lists them.
pub(super) fn listed<S: AsRef<str>>(names: impl IntoIterator<Item = S>) -> String {
    let names: Vec<String> = names.into_iter().map(|n| format!("`{}`", n.as_ref())).collect();
    if names.is_empty() { "(none)".into() } else { names.join(", ") }
}
