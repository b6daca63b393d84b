//! Run-to-failure folders of `sweep --preset` and `features`: which ones, and which of them age.

use std::path::{Path, PathBuf};

use super::Failure;
use crate::recording::reference_data;

/// Bearing whose channel ages.
pub struct Aging<T> {
    /// Name of its folder.
    pub name: String,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// What the command makes of it.
    pub value: T,
}

/// What `load` makes of each folder whose channel ages, without folders of all in `femto` of the reference data; those that do
/// not age are named on stderr.
///
/// # Errors
/// Those of `load`; two folders of one name, or of different sample rates.
pub fn aging<T>(
    folders: &[PathBuf],
    channel: &str,
    load: impl Fn(&Path, String) -> Result<Option<Aging<T>>, Failure>,
) -> Result<Vec<Aging<T>>, Failure> {
    let mut folders = folders.to_vec();
    if folders.is_empty() {
        let femto = reference_data::folder("femto");
        let entries = femto.and_then(|femto| std::fs::read_dir(femto).ok()).into_iter().flatten();
        folders = entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| path.is_dir()).collect();
        folders.sort();
    }
    let mut all: Vec<Aging<T>> = Vec::new();
    for folder in &folders {
        let name = folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned();
        let Some(found) = load(folder, name)? else {
            eprintln!("{}: channel {channel} shows no aging; left out", folder.display());
            continue;
        };
        let Aging { name, sample_rate_hz, .. } = &found;
        if all.iter().any(|other| other.name == *name) {
            return Err(Failure::Input(format!("found two folders {name}, expected folders of different names")));
        }
        if let Some(first) = all.first().map(|first| first.sample_rate_hz).filter(|first| first != sample_rate_hz) {
            return Err(Failure::Input(format!("{name}: found {sample_rate_hz} Hz, expected {first} Hz as the first")));
        }
        all.push(found);
    }
    Ok(all)
}
