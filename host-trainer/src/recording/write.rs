//! Writer of recordings: CSV with a header, and a manifest.
//!
//! Numbers have the digits that read the same `f64` back. Writes are atomic.

use std::{
    io::{self, Write},
    path::{Path, PathBuf},
};

use toml::{Table, Value};

use super::{Recording, assemble::is_sample, manifest, owned, unit::default_location};
use crate::recording::atomic_write;

/// Failure to write a recording.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// Error of the operating system.
    #[error("{path}: cannot be written: {source}")]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
    /// Channels of unequal length.
    #[error("{path}, channel `{channel}`: found {found} samples, expected {expected}")]
    UnequalLengths {
        /// Path of the file.
        path: PathBuf,
        /// Channel that differs from the first.
        channel: String,
        /// Length of the channel.
        found: usize,
        /// Length of the first channel.
        expected: usize,
    },
    /// A sample that is not finite or too large.
    #[error("{path}, row {row}, channel `{channel}`: found {found}, expected a finite number within ±1e30")]
    NotASample {
        /// Path of the file.
        path: PathBuf,
        /// Line, from 1.
        row: usize,
        /// Name of the channel.
        channel: String,
        /// Value of the sample.
        found: f64,
    },
    /// A file in the place of one to write that is not ballrace's own.
    #[error(
        "{path}: found a file that ballrace did not write or that was changed since, expected none; another folder keeps it"
    )]
    Foreign {
        /// Path of the file.
        path: PathBuf,
    },
    /// A channel name that is empty, a duplicate, or not possible in a header.
    #[error("{path}: found channel name `{name}`, expected one of its own without `,;\"#` or line ends")]
    BadName {
        /// Path of the file.
        path: PathBuf,
        /// Name of the channel.
        name: String,
    },
}

/// Writes one recording as CSV: a line with the channel names, then a line for each sample.
///
/// Rate, speed, load and locations are not in the CSV; [`folder`] writes them too.
///
/// # Errors
///
/// A recording that [`load`](super::load()) would not read back, or the operating system's error.
pub fn csv(path: &Path, recording: &Recording) -> Result<(), WriteError> {
    check(path, recording)?;
    persist(path, |out| {
        let names: Vec<&str> = recording.channels.iter().map(|c| c.name.as_str()).collect();
        writeln!(out, "{}", names.join(","))?;
        for row in 0..recording.len() {
            for (index, channel) in recording.channels.iter().enumerate() {
                let separator = if index == 0 { "" } else { "," };
                // Debug has the shortest digits that read back, and an exponent instead of many zeros.
                write!(out, "{separator}{:?}", channel.samples[row])?;
            }
            writeln!(out)?;
        }
        Ok(())
    })
}

/// Writes recordings into a folder, created if missing, as `r01.csv`, `r02.csv`, … with `recordings.toml` last: a
/// folder with a manifest is complete. Files that ballrace did not write are never replaced. Returns the path of the
/// manifest.
///
/// # Errors
///
/// Errors of [`csv`], and a file in the place of one to write; nothing is then replaced.
pub fn folder(folder: &Path, recordings: &[Recording]) -> Result<PathBuf, WriteError> {
    let io = |path: &Path| {
        let path = path.to_owned();
        move |source| WriteError::Io { path, source }
    };
    std::fs::create_dir_all(folder).map_err(io(folder))?;
    // Within the folder, so that renaming does not copy.
    let made = tempfile::Builder::new().prefix(".making-").tempdir_in(folder).map_err(io(folder))?;
    let names = names(recordings.len());
    let mut list = Vec::with_capacity(recordings.len());
    let mut written = Vec::with_capacity(recordings.len());
    for (file, recording) in names.iter().zip(recordings) {
        let path = made.path().join(file);
        csv(&path, recording)?;
        written.push((file.clone(), owned::file_crc(&path).unwrap_or_default()));
        list.push(Value::Table(entry(file.clone(), recording)));
    }
    let mut defaults = Table::new();
    defaults.insert("unit".into(), "m/s^2".into());
    let mut table = Table::new();
    table.insert("defaults".into(), Value::Table(defaults));
    table.insert("recording".into(), Value::Array(list));
    let text = owned::marked(&table.to_string(), &written);
    persist(&made.path().join(manifest::FILE_NAME), |out| out.write_all(text.as_bytes()))?;

    // Of a run that was killed while renaming, the same files are there without the manifest that lists them.
    let same = |(name, crc): &(String, u32)| owned::file_crc(&folder.join(name)) == Some(*crc);
    let changed: Vec<&str> = written.iter().filter(|file| !same(file)).map(|(name, _)| name.as_str()).collect();
    check_replaceable(folder, changed.into_iter().chain([manifest::FILE_NAME]))?;
    for file in names.iter().map(String::as_str).chain([manifest::FILE_NAME]) {
        let path = folder.join(file);
        atomic_write::install(&made.path().join(file), &path).map_err(io(&path))?;
    }
    Ok(folder.join(manifest::FILE_NAME))
}

/// Names of the files of that many recordings.
fn names(count: usize) -> Vec<String> {
    let digits = count.to_string().len().max(2);
    (1..=count).map(|number| format!("r{number:0digits$}.csv")).collect()
}

/// Files that [`folder()`] writes for that many recordings.
pub fn files(folder: &Path, count: usize) -> Vec<PathBuf> {
    names(count).iter().map(String::as_str).chain([manifest::FILE_NAME]).map(|name| folder.join(name)).collect()
}

fn check_replaceable<'a>(folder: &Path, mut names: impl Iterator<Item = &'a str>) -> Result<(), WriteError> {
    let foreign = |name: &&str| {
        let path = folder.join(name);
        path.exists() && !owned::is_own(&path)
    };
    names.find(foreign).map_or(Ok(()), |name| Err(WriteError::Foreign { path: folder.join(name) }))
}

fn entry(file: String, recording: &Recording) -> Table {
    let mut entry = Table::new();
    entry.insert("file".into(), file.into());
    entry.insert("sample_rate_hz".into(), recording.sample_rate_hz.into());
    if let Some(shaft_hz) = recording.shaft_hz {
        entry.insert("shaft_hz".into(), shaft_hz.into());
    }
    if let Some(deviation) = recording.shaft_hz_std {
        entry.insert("shaft_hz_std".into(), deviation.into());
    }
    if let Some(load_n) = recording.load_n {
        entry.insert("load_n".into(), load_n.into());
    }
    let stated = recording.channels.iter().filter_map(|channel| {
        let location = channel.location.as_deref()?;
        let is_default = default_location(&channel.name) == Some(location);
        (!is_default).then(|| (channel.name.clone(), Value::from(location)))
    });
    let channels: Table = stated.collect();
    if !channels.is_empty() {
        entry.insert("channels".into(), Value::Table(channels));
    }
    entry
}

fn check(path: &Path, recording: &Recording) -> Result<(), WriteError> {
    for (index, channel) in recording.channels.iter().enumerate() {
        let name = &channel.name;
        let is_taken = recording.channels[..index].iter().any(|c| c.name == *name);
        let is_plain = name.trim() == name && !name.contains([',', ';', '"', '#', '\t', '\n', '\r']);
        // A header of numbers would be taken for samples.
        if name.is_empty() || is_taken || !is_plain || name.parse::<f64>().is_ok() {
            return Err(WriteError::BadName { path: path.into(), name: name.clone() });
        }
        let (found, expected) = (channel.samples.len(), recording.len());
        if found != expected {
            let (path, channel) = (path.into(), name.clone());
            return Err(WriteError::UnequalLengths { path, channel, found, expected });
        }
        if let Some(at) = channel.samples.iter().position(|sample| !is_sample(*sample)) {
            let (row, found) = (at + 2, channel.samples[at]);
            return Err(WriteError::NotASample { path: path.into(), row, channel: name.clone(), found });
        }
    }
    Ok(())
}

fn persist(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), WriteError> {
    atomic_write::write_with(path, write).map_err(|source| WriteError::Io { path: path.into(), source })
}
