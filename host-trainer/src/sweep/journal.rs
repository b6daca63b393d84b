//! Rows of a sweep that are done: one JSON object a line, so that a kill loses at most the line that was being written.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use super::job::{Job, Row};

/// Name of the file in the folder of a sweep.
pub const FILE_NAME: &str = "rows.jsonl";

/// Rows that are done.
#[derive(Debug)]
pub struct Journal {
    file: File,
    path: PathBuf,
    rows: HashMap<String, Row>,
}

/// A journal that cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {source}")]
pub struct JournalError {
    path: PathBuf,
    source: std::io::Error,
}

impl Journal {
    /// Journal in a folder, which is made if it is missing. A last line without its end is cut off; a line that is not a row
    /// stays and counts for nothing.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn open(folder: &Path) -> Result<Self, JournalError> {
        let path = folder.join(FILE_NAME);
        let failed = |source| JournalError { path: path.clone(), source };
        std::fs::create_dir_all(folder).map_err(failed)?;
        let mut file = OpenOptions::new().create(true).read(true).append(true).open(&path).map_err(failed)?;
        let bytes = std::fs::read(&path).map_err(failed)?;
        let whole = bytes.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
        file.set_len(whole as u64).and_then(|()| file.flush()).map_err(failed)?;
        let lines = bytes[..whole].split(|b| *b == b'\n').filter_map(|line| serde_json::from_slice::<Row>(line).ok());
        let rows = lines.map(|row| (key(&row.job), row)).collect();
        Ok(Self { file, path, rows })
    }

    /// Row of a job, if it is done.
    pub fn row(&self, job: &Job) -> Option<&Row> {
        self.rows.get(&key(job))
    }

    /// Adds a row.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn add(&mut self, row: &Row) -> Result<(), JournalError> {
        let line = serde_json::to_string(row).map_err(std::io::Error::from);
        let written = line.and_then(|line| self.file.write_all((line + "\n").as_bytes()));
        written.map_err(|source| JournalError { path: self.path.clone(), source })
    }
}

/// Text that is equal for equal jobs.
pub(super) fn key(job: &Job) -> String {
    serde_json::to_string(job).unwrap_or_default()
}
