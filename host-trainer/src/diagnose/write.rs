//! Folder of a diagnosis.
//!
//! All files are written in a temporary folder and then renamed, `diagnosis.json` last: a folder that has it is complete.
//! Files of an earlier diagnosis in `heldout`, as its `diagnosis.json` lists them, are removed; nothing else is touched.

use std::collections::BTreeSet;
use std::fs;
use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::result::{Diagnosis, DiagnosisResult, HeldOut, Test};
use crate::recording::write::{self, WriteError};
use crate::recording::{Channel, Recording, atomic_write};

/// Name of the document.
pub const DOCUMENT: &str = "diagnosis.json";
/// Name of the corrected rig.
pub const RIG: &str = "rig.corrected.toml";
/// Name of the report.
pub const REPORT: &str = "report.html";
/// Folder of the held-out recordings.
pub const HELD_OUT: &str = "heldout";
/// Columns of their files.
const COLUMNS: [&str; 4] = ["time_s", "measured", "before", "after"];

/// Error of writing a diagnosis.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// File or folder that cannot be written.
    #[error("{path}: cannot be written: {source}")]
    Io {
        /// Path of the file or folder.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// Error of writing a recording.
    #[error(transparent)]
    Csv(#[from] WriteError),
    /// Error of serialising the document.
    #[error("{DOCUMENT}: {0}")]
    Json(#[from] serde_json::Error),
}

/// Complete `diagnosis.json`, with tests, caveats and files.
#[derive(Debug, Serialize)]
pub struct Document<'a> {
    #[serde(flatten)]
    diagnosis: &'a Diagnosis,
    /// Unknown parameters of the rig, fitted.
    fitted: Vec<Fitted<'a>>,
    /// Tests of the residual of the rig without causes.
    tests: &'a [Test],
    /// Caveats.
    caveats: &'a [String],
    /// Settings of each stage.
    settings: &'a serde_json::Value,
    /// Files in the folder of the document.
    files: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Fitted<'a> {
    name: &'a str,
    value: f64,
    /// 95 % interval; infinite, in JSON null, if the data do not bound it.
    interval95: [f64; 2],
}

impl<'a> Document<'a> {
    /// Document of a result.
    pub fn from_result(outcome: &'a DiagnosisResult) -> Self {
        let fitted = outcome.fitted.iter();
        let held_out = names(&outcome.held_out).into_iter().map(|name| format!("{HELD_OUT}/{name}"));
        Self {
            diagnosis: &outcome.diagnosis,
            fitted: fitted
                .map(|(name, value, interval95)| Fitted { name, value: *value, interval95: *interval95 })
                .collect(),
            tests: &outcome.tests,
            caveats: &outcome.caveats,
            settings: &outcome.settings,
            files: [RIG, REPORT].map(String::from).into_iter().chain(held_out).collect(),
        }
    }
}

/// Unique file names of held-out recordings, after their own names.
pub fn names(held_out: &[HeldOut]) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let plain = |c: char| if c.is_alphanumeric() || "-_.+ ".contains(c) { c } else { '-' };
    let name = |held: &HeldOut| {
        let stem: String = held.name.chars().map(plain).collect();
        let stem = if stem.trim_matches(['.', ' ']).is_empty() { "recording".into() } else { stem };
        let mut candidates = std::iter::once(stem.clone())
            .chain((2..).map(|n: usize| format!("{stem}-{n}")))
            .map(|s| format!("{s}.csv"));
        // There is no end to the candidates.
        let free = candidates.find(|c| !taken.contains(&c.to_lowercase())).unwrap_or_default();
        taken.insert(free.to_lowercase());
        free
    };
    held_out.iter().map(name).collect()
}

/// Writes the folder, which is created if needed.
///
/// # Errors
/// Errors of the operating system; the folder is then unchanged, unless the renaming of a finished file failed.
pub fn folder(out: &Path, outcome: &DiagnosisResult, report: &str) -> Result<(), StoreError> {
    let io = |path: &Path| {
        let path = path.to_owned();
        move |source| StoreError::Io { path, source }
    };
    let held_out = out.join(HELD_OUT);
    fs::create_dir_all(out).map_err(io(out))?;
    // Within the folder, so that renaming does not copy.
    let made = tempfile::Builder::new().prefix(".making-").tempdir_in(out).map_err(io(out))?;
    let file = |name: &str| made.path().join(name);
    let document = serde_json::to_string_pretty(&Document::from_result(outcome))? + "\n";
    let files = names(&outcome.held_out);
    fs::write(file(DOCUMENT), document).map_err(io(&file(DOCUMENT)))?;
    fs::write(file(RIG), outcome.rig.to_toml()).map_err(io(&file(RIG)))?;
    fs::write(file(REPORT), report).map_err(io(&file(REPORT)))?;
    fs::create_dir(file(HELD_OUT)).map_err(io(&file(HELD_OUT)))?;
    for (held, name) in outcome.held_out.iter().zip(&files) {
        write::csv(&file(HELD_OUT).join(name), &recording(held))?;
    }

    if let Some(name) = files.iter().find(|name| is_foreign(&held_out.join(name))) {
        return Err(WriteError::Foreign { path: held_out.join(name) }.into());
    }
    let old = earlier(out);
    fs::create_dir_all(&held_out).map_err(io(&held_out))?;
    let stale = std::iter::once(out.join(DOCUMENT)).chain(old.iter().map(|name| held_out.join(name)));
    for path in stale {
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(io(&path)(error)),
            _ => {}
        }
    }
    let moved = files.iter().map(|name| format!("{HELD_OUT}/{name}"));
    for name in moved.chain([RIG, REPORT, DOCUMENT].map(String::from)) {
        let path = out.join(&name);
        atomic_write::install(&file(&name), &path).map_err(io(&path))?;
    }
    Ok(())
}

/// Held-out files that the folder's `diagnosis.json` lists and that have its columns.
fn earlier(out: &Path) -> Vec<String> {
    let document = fs::read(out.join(DOCUMENT)).ok();
    let document: Option<serde_json::Value> = document.and_then(|bytes| serde_json::from_slice(&bytes).ok());
    let files = document.as_ref().and_then(|d| d.get("files")?.as_array());
    let names = files.into_iter().flatten().filter_map(|f| f.as_str()?.strip_prefix("heldout/"));
    let ours = |name: &&str| {
        let path = out.join(HELD_OUT).join(name);
        !name.contains(['/', '\\']) && name.ends_with(".csv") && path.exists() && !is_foreign(&path)
    };
    names.filter(ours).map(String::from).collect()
}

/// Files of a diagnosis in its folder, without those of the held-out recordings.
pub fn files(out: &Path) -> Vec<PathBuf> {
    [DOCUMENT, RIG, REPORT].map(|name| out.join(name)).to_vec()
}

/// Files in the folder that the held-out ones of these recordings could replace.
pub fn held_out_files(out: &Path, recordings: &[Recording]) -> Vec<PathBuf> {
    let there = fs::read_dir(out.join(HELD_OUT)).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    // A channel can follow the recording's name.
    let could = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        recordings.iter().any(|recording| name.starts_with(&recording.name().to_lowercase()))
    };
    there.filter(could).collect()
}

/// Whether a file is there that no diagnosis wrote.
pub fn is_foreign(path: &Path) -> bool {
    let header = COLUMNS.join(",");
    let first = || {
        let mut line = String::new();
        io::BufReader::new(fs::File::open(path).ok()?).take(1000).read_line(&mut line).ok()?;
        Some(line.trim_end() == header)
    };
    path.exists() && first() != Some(true)
}

fn recording(held: &HeldOut) -> Recording {
    let time = (0..held.measured.len()).map(|k| k as f64 / held.sample_rate_hz).collect();
    let signals = [time, held.measured.clone(), held.before.clone(), held.after.clone()];
    let channels = COLUMNS.into_iter().zip(signals);
    Recording {
        channels: channels.map(|(name, samples)| Channel { name: name.into(), location: None, samples }).collect(),
        sample_rate_hz: held.sample_rate_hz,
        ..Recording::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_recording_has_a_file_of_its_own() {
        let held = |name: &str| HeldOut {
            name: name.into(),
            sample_rate_hz: 1.0,
            measured: vec![],
            before: vec![],
            after: vec![],
        };
        let given = ["r01", "r01", "R01", "../up", "..", "r01-2"].map(held);
        assert_eq!(names(&given), ["r01.csv", "r01-2.csv", "R01-3.csv", "..-up.csv", "recording.csv", "r01-2-2.csv"]);
    }
}
