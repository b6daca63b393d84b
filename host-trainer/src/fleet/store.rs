//! SQLite file of a fleet: every message once, and the counts of what was dropped.

use std::path::{Path, PathBuf};

use ballrace_core::input_check::Quality;
use ballrace_core::monitor::Status;
use ballrace_core::telemetry::{Kind, Message};
use rusqlite::{Connection, OpenFlags, params};
use serde::Serialize;

/// `BRFL`, the application number of the file.
const APPLICATION: i32 = i32::from_be_bytes(*b"BRFL");
/// Version of the schema.
pub const SCHEMA_VERSION: i32 = 1;
const SCHEMA: &str = "
CREATE TABLE messages (
  machine TEXT NOT NULL, session INTEGER NOT NULL, sequence INTEGER NOT NULL, kind TEXT NOT NULL, status TEXT NOT NULL,
  was TEXT, model_crc INTEGER NOT NULL, unix_ms INTEGER NOT NULL, received_ms INTEGER NOT NULL, recording INTEGER NOT NULL,
  time_s REAL NOT NULL, block INTEGER NOT NULL, level REAL, deviation REAL, ewma REAL NOT NULL, ewma_limit REAL NOT NULL,
  fault TEXT, value_m_per_s2 REAL, non_finite INTEGER, saturated INTEGER, stuck INTEGER, missing INTEGER, alarms INTEGER,
  PRIMARY KEY (machine, session, sequence)) STRICT, WITHOUT ROWID;
CREATE TABLE counts (
  accepted INTEGER NOT NULL, duplicates INTEGER NOT NULL, too_long INTEGER NOT NULL, malformed INTEGER NOT NULL,
  unknown_machine INTEGER NOT NULL) STRICT;
CREATE TABLE session (client_id TEXT NOT NULL) STRICT;
INSERT INTO counts VALUES (0, 0, 0, 0, 0);
INSERT INTO session VALUES ('ballrace-collect-' || lower(hex(randomblob(4))));";
const INSERT: &str = "INSERT OR IGNORE INTO messages VALUES
  (?1,?2,?3,?4,?5,?6,?7,?8,?9,?10,?11,?12,?13,?14,?15,?16,?17,?18,?19,?20,?21,?22,?23)";

/// Failure of the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// File that is no fleet of this version.
    #[error("{}: found {found}, expected a file of `ballrace collect` of version {SCHEMA_VERSION}", path.display())]
    Foreign {
        /// File.
        path: PathBuf,
        /// What was found.
        found: String,
    },
    /// Error of SQLite.
    #[error("{}: {error}", path.display())]
    Sqlite {
        /// File.
        path: PathBuf,
        /// Error.
        error: rusqlite::Error,
    },
}

/// Messages since the file was made. What was dropped may count twice if the collector was killed before its acknowledgement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Messages stored.
    pub accepted: u64,
    /// Messages that were stored already.
    pub duplicates: u64,
    /// Messages longer than the layout.
    pub too_long: u64,
    /// Messages that are otherwise none: length, checksum, codes, another machine than the topic's.
    pub malformed: u64,
    /// Messages of machines that are not in the list.
    pub unknown_machine: u64,
}

impl Counts {
    /// Sum with other counts.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        Self {
            accepted: self.accepted + other.accepted,
            duplicates: self.duplicates + other.duplicates,
            too_long: self.too_long + other.too_long,
            malformed: self.malformed + other.malformed,
            unknown_machine: self.unknown_machine + other.unknown_machine,
        }
    }
}

/// What a received message is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Received<'a> {
    /// Message of a machine.
    Message(Message<'a>),
    /// Too long.
    TooLong,
    /// No message otherwise.
    Malformed,
    /// Machine that is not in the list.
    UnknownMachine,
}

/// SQLite file of a fleet.
#[derive(Debug)]
pub struct Store {
    path: PathBuf,
    pub(super) connection: Connection,
}

impl Store {
    /// Opens the file, or makes it.
    ///
    /// # Errors
    /// A file of another kind or version, errors of SQLite.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        let found = Self::with(path, OpenFlags::default())?;
        let failed = |error| StoreError::Sqlite { path: path.to_owned(), error };
        // A commit must outlast a power cut: the acknowledgement that follows makes the broker forget the message.
        let pragmas = "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;";
        if found.is_new()? {
            let schema = format!(
                "{pragmas} BEGIN; {SCHEMA} PRAGMA application_id = {APPLICATION}; PRAGMA user_version = {SCHEMA_VERSION}; COMMIT;"
            );
            found.connection.execute_batch(&schema).map_err(failed)?;
        } else {
            found.check()?;
            found.connection.execute_batch(pragmas).map_err(failed)?;
        }
        Ok(found)
    }

    /// Opens a file that exists, to read.
    ///
    /// # Errors
    /// No file, a file of another kind or version, errors of SQLite.
    pub fn read(path: &Path) -> Result<Self, StoreError> {
        if !path.is_file() {
            return Err(StoreError::Foreign { path: path.to_owned(), found: "no file".into() });
        }
        // Not read-only: a collector that was killed leaves a journal that is to be played back.
        let store = Self::with(path, OpenFlags::SQLITE_OPEN_READ_WRITE)?;
        store.check()?;
        Ok(store)
    }

    fn with(path: &Path, flags: OpenFlags) -> Result<Self, StoreError> {
        let failed = |error| StoreError::Sqlite { path: path.to_owned(), error };
        let connection = Connection::open_with_flags(path, flags).map_err(failed)?;
        connection.busy_timeout(std::time::Duration::from_secs(10)).map_err(failed)?;
        Ok(Self { path: path.to_owned(), connection })
    }

    pub(super) fn failed(&self, error: rusqlite::Error) -> StoreError {
        StoreError::Sqlite { path: self.path.clone(), error }
    }

    fn pragma(&self, name: &str) -> Result<i32, StoreError> {
        self.connection.pragma_query_value(None, name, |row| row.get(0)).map_err(|error| {
            match error.sqlite_error_code() {
                Some(rusqlite::ErrorCode::NotADatabase) => {
                    StoreError::Foreign { path: self.path.clone(), found: "no SQLite file".into() }
                }
                _ => self.failed(error),
            }
        })
    }

    fn is_new(&self) -> Result<bool, StoreError> {
        let tables = self.connection.query_row("SELECT count(*) FROM sqlite_schema", [], |row| row.get::<_, i64>(0));
        Ok(self.pragma("application_id")? == 0 && tables.map_err(|error| self.failed(error))? == 0)
    }

    fn check(&self) -> Result<(), StoreError> {
        let found = match (self.pragma("application_id")?, self.pragma("user_version")?) {
            (APPLICATION, SCHEMA_VERSION) => return Ok(()),
            (APPLICATION, version) => format!("version {version}"),
            (application, _) => format!("another SQLite file (application {application:#x})"),
        };
        Err(StoreError::Foreign { path: self.path.clone(), found })
    }

    /// Name of the collector at the broker, which keeps its session under it.
    ///
    /// # Errors
    /// Errors of SQLite.
    pub fn client_id(&self) -> Result<String, StoreError> {
        let id = self.connection.query_row("SELECT client_id FROM session", [], |row| row.get(0));
        id.map_err(|error| self.failed(error))
    }

    /// Counts since the file was made.
    ///
    /// # Errors
    /// Errors of SQLite.
    pub fn counts(&self) -> Result<Counts, StoreError> {
        let counts = self.connection.query_row("SELECT * FROM counts", [], |row| {
            Ok(Counts {
                accepted: row.get(0)?,
                duplicates: row.get(1)?,
                too_long: row.get(2)?,
                malformed: row.get(3)?,
                unknown_machine: row.get(4)?,
            })
        });
        counts.map_err(|error| self.failed(error))
    }

    /// Stores a batch that came at `received_ms`, ms since 1970-01-01 UTC, in one transaction, on the disk when it returns;
    /// what it added to the counts.
    ///
    /// # Errors
    /// Errors of SQLite; then nothing of the batch is stored.
    pub fn take(&mut self, batch: &[Received<'_>], received_ms: i64) -> Result<Counts, StoreError> {
        let path = self.path.clone();
        self.store(batch, received_ms).map_err(|error| StoreError::Sqlite { path, error })
    }

    fn store(&mut self, batch: &[Received<'_>], received_ms: i64) -> rusqlite::Result<Counts> {
        let transaction = self.connection.transaction()?;
        let mut added = Counts::default();
        {
            let mut insert = transaction.prepare_cached(INSERT)?;
            for received in batch {
                let count = match received {
                    Received::Message(message) => match insert_message(&mut insert, message, received_ms)? {
                        Some(1) => &mut added.accepted,
                        Some(_) => &mut added.duplicates,
                        None => &mut added.malformed,
                    },
                    Received::TooLong => &mut added.too_long,
                    Received::Malformed => &mut added.malformed,
                    Received::UnknownMachine => &mut added.unknown_machine,
                };
                *count += 1;
            }
            let sum = "UPDATE counts SET accepted = accepted + ?1, duplicates = duplicates + ?2, too_long = too_long + ?3, \
                       malformed = malformed + ?4, unknown_machine = unknown_machine + ?5";
            let a = added;
            transaction.prepare_cached(sum)?.execute(params![
                a.accepted,
                a.duplicates,
                a.too_long,
                a.malformed,
                a.unknown_machine
            ])?;
        }
        transaction.commit()?;
        Ok(added)
    }
}

/// Rows inserted: 0 where it is there already; `None` for numbers beyond SQLite's.
fn insert_message(
    insert: &mut rusqlite::CachedStatement<'_>,
    message: &Message<'_>,
    received_ms: i64,
) -> rusqlite::Result<Option<usize>> {
    let (Ok(session), Ok(unix_ms)) = (i64::try_from(message.session), i64::try_from(message.unix_ms)) else {
        return Ok(None);
    };
    let known = |value: f32| (!value.is_nan()).then_some(f64::from(value));
    let (kind, was, fault, totals) = match message.kind {
        Kind::Status { was } => ("status", was.map(status_name), None, None),
        Kind::Block => ("block", None, None, None),
        Kind::Fault { quality, value } => ("fault", None, Some((quality_name(quality), known(value))), None),
        Kind::Summary { faults, alarms } => ("summary", None, None, Some((faults, alarms))),
    };
    insert
        .execute(params![
            message.machine,
            session,
            message.sequence,
            kind,
            status_name(message.status),
            was,
            message.model_crc,
            unix_ms,
            received_ms,
            message.recording,
            message.time_s,
            message.block,
            known(message.level),
            known(message.deviation),
            f64::from(message.ewma),
            f64::from(message.limit),
            fault.map(|(name, _)| name),
            fault.and_then(|(_, value)| value),
            totals.map(|(faults, _)| faults.non_finite),
            totals.map(|(faults, _)| faults.saturated),
            totals.map(|(faults, _)| faults.stuck),
            totals.map(|(faults, _)| faults.missing),
            totals.map(|(_, alarms)| alarms),
        ])
        .map(Some)
}

/// Name of a status, as in the events of `monitor`.
pub const fn status_name(status: Status) -> &'static str {
    match status {
        Status::Starting => "starting",
        Status::Healthy => "healthy",
        Status::Anomalous => "anomalous",
        Status::Blind => "blind",
    }
}

const fn quality_name(quality: Quality) -> &'static str {
    match quality {
        Quality::Good => "good",
        Quality::NonFinite => "non-finite",
        Quality::Saturated => "saturated",
        Quality::Stuck => "stuck",
        Quality::Missing => "missing",
    }
}
