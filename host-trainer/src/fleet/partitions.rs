//! Messages as Parquet, partitioned by machine and day of their arrival: `DIR/machine=NAME/day=DATE/COLLECTOR.parquet`.
//!
//! A file is all that the SQLite file has of its machine and day. It is written anew, to another name first, when messages
//! have come, and never changes once its day is over. Nothing else is remembered: what is not yet in the folder is found by
//! comparing counts of rows, so that a collector killed at any moment leaves nothing out and nothing twice.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use rusqlite::params;

use super::store::{Store, StoreError};
use crate::recording::atomic_write::write_atomically;
use crate::recording::parquet_table::{self, Values};

const DAY_MS: i64 = 24 * 3600 * 1000;
/// Order of the messages by machine and arrival, which the key of the table is not.
const INDEX: &str = "CREATE INDEX IF NOT EXISTS messages_by_day ON messages (machine, received_ms)";
const COUNTS: &str = "SELECT machine, received_ms / 86400000 AS day, count(*) FROM messages GROUP BY machine, day";

/// Failure of the folder.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PartitionError {
    /// Error of the operating system.
    #[error("{}: {error}", path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Error.
        error: io::Error,
    },
    /// Error of the Parquet library.
    #[error("{}: {error}", path.display())]
    Parquet {
        /// File.
        path: PathBuf,
        /// Error.
        error: ParquetError,
    },
    /// Error of the SQLite file.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// Machine, and days since 1970-01-01 UTC.
type Key = (String, i64);

/// Folder of the partitions, and which of them lack messages.
#[derive(Debug)]
pub struct Partitions {
    folder: PathBuf,
    /// Name of this collector's file in each partition.
    file: String,
    stale: BTreeSet<Key>,
}

impl Partitions {
    /// Opens the folder, or makes it; finds what of the SQLite file it lacks.
    ///
    /// # Errors
    /// Errors of the operating system and of SQLite.
    pub fn open(folder: &Path, store: &Store) -> Result<Self, PartitionError> {
        fs::create_dir_all(folder).map_err(|error| PartitionError::Io { path: folder.to_owned(), error })?;
        let failed = |error| store.failed(error);
        store.connection.execute_batch(INDEX).map_err(failed)?;
        let file = format!("{}.parquet", store.client_id()?);
        let mut partitions = Self { folder: folder.to_owned(), file, stale: BTreeSet::new() };
        let mut query = store.connection.prepare(COUNTS).map_err(failed)?;
        let counts = query.query_map([], |row| Ok(((row.get(0)?, row.get(1)?), row.get(2)?))).map_err(failed)?;
        for counted in counts {
            let (key, count): (Key, i64) = counted.map_err(failed)?;
            if rows(&partitions.path(store, &key)?) != Some(count) {
                partitions.stale.insert(key);
            }
        }
        Ok(partitions)
    }

    /// Notes that a machine has sent something that was stored at this time.
    pub fn note(&mut self, machine: &str, received_ms: i64) {
        self.stale.insert((machine.to_owned(), received_ms.div_euclid(DAY_MS)));
    }

    /// Whether nothing is lacking.
    pub fn is_current(&self) -> bool {
        self.stale.is_empty()
    }

    /// Writes the partitions that lack messages, at most `most` of them.
    ///
    /// # Errors
    /// Errors of the operating system, of SQLite and of the Parquet library; what was not written stays noted.
    pub fn write(&mut self, store: &Store, most: usize) -> Result<(), PartitionError> {
        for _ in 0..most {
            let Some(key) = self.stale.first() else { break };
            self.write_one(store, key)?;
            self.stale.pop_first();
        }
        Ok(())
    }

    fn write_one(&self, store: &Store, key: &Key) -> Result<(), PartitionError> {
        let columns = read(store, key).map_err(|error| store.failed(error))?;
        if matches!(columns.first(), Some((_, Values::Count(values))) if values.is_empty()) {
            // What it sent on this day was there already.
            return Ok(());
        }
        let path = self.path(store, key)?;
        let bytes = parquet_table::encode("messages", columns)
            .map_err(|error| PartitionError::Parquet { path: path.clone(), error })?;
        let made = path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| write_atomically(&path, &bytes));
        made.map_err(|error| PartitionError::Io { path, error })
    }

    fn path(&self, store: &Store, (machine, day): &Key) -> Result<PathBuf, PartitionError> {
        let date = "SELECT date(?1 * 86400, 'unixepoch')";
        let date = store.connection.prepare_cached(date).and_then(|mut q| q.query_row([day], |row| row.get(0)));
        let date: String = date.map_err(|error| store.failed(error))?;
        let (machine, day) = (format!("machine={}", encoded(machine)), format!("day={date}"));
        Ok(self.folder.join(machine).join(day).join(&self.file))
    }
}

/// Rows of a Parquet file; `None` if there is none that can be read.
fn rows(path: &Path) -> Option<i64> {
    let reader = SerializedFileReader::new(File::open(path).ok()?).ok()?;
    Some(reader.metadata().file_metadata().num_rows())
}

/// Messages of a machine and day as columns, without these two: the names of the folders have them.
fn read(store: &Store, (machine, day): &Key) -> rusqlite::Result<Vec<(&'static str, Values)>> {
    let count = |name| (name, Values::Count(Vec::new()));
    let text = |name| (name, Values::Text(Vec::new()));
    let number = |name| (name, Values::Number(Vec::new()));
    let mut columns = vec![
        count("session"),
        count("sequence"),
        text("kind"),
        text("status"),
        text("was"),
        count("model_crc"),
        count("unix_ms"),
        count("received_ms"),
        count("recording"),
        number("time_s"),
        count("block"),
        number("level"),
        number("deviation"),
        number("ewma"),
        number("ewma_limit"),
        text("fault"),
        number("value_m_per_s2"),
        count("non_finite"),
        count("saturated"),
        count("stuck"),
        count("missing"),
        count("alarms"),
    ];
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let select = format!(
        "SELECT {} FROM messages WHERE machine = ?1 AND received_ms >= ?2 AND received_ms < ?3 ORDER BY session, sequence",
        names.join(", ")
    );
    let mut query = store.connection.prepare_cached(&select)?;
    let mut rows = query.query(params![machine, day * DAY_MS, (day + 1) * DAY_MS])?;
    while let Some(row) = rows.next()? {
        for (index, (_, values)) in columns.iter_mut().enumerate() {
            match values {
                Values::Text(values) => values.push(row.get(index)?),
                Values::Count(values) => values.push(row.get(index)?),
                Values::Number(values) => values.push(row.get(index)?),
            }
        }
    }
    Ok(columns)
}

/// Name as Hive's readers decode it: what is not unreserved in a URL is percent-encoded.
fn encoded(name: &str) -> String {
    let byte = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' => char::from(byte).to_string(),
        _ => format!("%{byte:02X}"),
    };
    name.bytes().map(byte).collect()
}

#[cfg(test)]
#[path = "partitions_tests.rs"]
mod tests;
