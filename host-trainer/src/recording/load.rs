//! Loading of recordings, files in parallel.

use std::{
    path::{Path, PathBuf},
    sync::atomic::{AtomicUsize, Ordering},
};

use rayon::prelude::*;

use super::{
    LoadOptions, Progress, ReadError, Recording,
    assemble::{self, Selection},
    bounded, find,
    formats::{csv, femto, mat, npy, parquet},
    job::{Format, Job},
    table,
};

/// Result of a [`load`].
#[derive(Debug, Default)]
pub struct Loaded {
    /// Recordings, in the order of the paths and of the files in them.
    pub recordings: Vec<Recording>,
    /// Errors of the unreadable recordings left out (only with [`LoadOptions::skip_bad`]).
    pub skipped: Vec<ReadError>,
}

/// All recordings of a file, a manifest or a folder, with default options.
///
/// # Errors
///
/// Errors of [`load`].
pub fn load_all(path: &Path) -> Result<Vec<Recording>, ReadError> {
    Ok(load(&[path.to_owned()], &LoadOptions::default())?.recordings)
}

/// Reads files and folders.
///
/// A folder with `recordings.toml` is read by it; without one, FEMTO `acc_*.csv` are taken, else
/// all `.csv`, else all files of a known format. A file is read by its ending; `.toml` is a manifest.
///
/// # Errors
///
/// The first error in the order of the recordings. With [`LoadOptions::skip_bad`] bad contents are counted instead,
/// unless no recording is readable.
///
/// # Examples
///
/// ```
/// use ballrace::recording::{LoadOptions, Unit, load};
///
/// let folder = tempfile::tempdir()?;
/// let file = folder.path().join("r01.csv");
/// std::fs::write(&file, "ay\n0.1\n-0.2\n0.3\n")?;
/// let options = LoadOptions { sample_rate_hz: Some(25_600.0), unit: Unit::parse("g"), ..LoadOptions::default() };
/// let loaded = load(&[file], &options)?;
/// assert_eq!(loaded.recordings[0].channels[0].samples[0], 0.1 * 9.806_65);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn load(paths: &[PathBuf], options: &LoadOptions) -> Result<Loaded, ReadError> {
    options.check()?;
    let mut jobs = find::jobs(paths, options)?;
    if let Some(range) = &options.recordings {
        let total = jobs.len();
        let range = range.start..range.end.min(total);
        if range.is_empty() {
            return Err(ReadError::BadOption {
                option: "recordings",
                found: format!("{:?}", options.recordings.clone().unwrap_or_default()),
                expected: format!("a range within 0..{total}"),
            });
        }
        jobs = jobs.drain(range).collect();
    }

    let done = AtomicUsize::new(0);
    let results: Vec<Result<Recording, ReadError>> = jobs
        .par_iter()
        .map(|job| {
            let result = read(job, options);
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            if let Some(progress) = &options.progress {
                progress(Progress { done, total: jobs.len() });
            }
            result
        })
        .collect();

    let mut loaded = Loaded::default();
    let mut days = Days::default();
    for (result, job) in results.into_iter().zip(&jobs) {
        match result {
            Ok(mut recording) => {
                recording.start_s = recording.start_s.map(|start| days.count(start, job.group));
                loaded.recordings.push(recording);
            }
            Err(error) if options.skip_bad && error.is_content() => loaded.skipped.push(error),
            Err(error) => return Err(error),
        }
    }
    match loaded.skipped.is_empty() || !loaded.recordings.is_empty() {
        true => Ok(loaded),
        false => Err(loaded.skipped.swap_remove(0)),
    }
}

fn read(job: &Job, options: &LoadOptions) -> Result<Recording, ReadError> {
    let path = &job.entry.file;
    let selection = Selection::new(job, options);
    let skip_bad = options.skip_bad;
    let raw = match job.format {
        Format::Csv => {
            let bytes = contents(path)?;
            if femto::is_named(path) || femto::is_row(table::first_line(&bytes).0) {
                femto::read(&bytes, path, &selection, skip_bad)?
            } else {
                let stated = options.sample_rate_hz.or(job.entry.sample_rate_hz);
                csv::read(&bytes, path, &selection, stated.is_none(), skip_bad)?
            }
        }
        Format::Mat => mat::read(&contents(path)?, path, job.variable.as_deref(), &selection, skip_bad)?,
        Format::Npy => npy::read(&contents(path)?, path, &selection, skip_bad)?,
        Format::Parquet => parquet::read(path, &selection, skip_bad)?,
    };
    assemble::assemble(raw, job, &selection, options)
}

fn contents(path: &Path) -> Result<Vec<u8>, ReadError> {
    bounded::samples(path).map_err(|source| ReadError::of(path, source))
}

/// Count of the midnights between recordings: FEMTO states only the time of day.
#[derive(Default)]
struct Days {
    group: usize,
    days: f64,
    last: Option<f64>,
}

impl Days {
    const DAY_S: f64 = 86_400.0;

    /// Start time plus the days since the first recording of the group, s.
    fn count(&mut self, start: f64, group: usize) -> f64 {
        if group != self.group {
            *self = Self { group, ..Self::default() };
        }
        // A step back by more than half a day is a midnight; a smaller one is a file out of order.
        if self.last.is_some_and(|last| last - start > 0.5 * Self::DAY_S) {
            self.days += 1.0;
        }
        self.last = Some(start);
        start + self.days * Self::DAY_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn midnights_count_within_a_path() {
        let mut days = Days::default();
        let starts = [(86_000.0, 0), (10.0, 0), (5.0, 0), (80_000.0, 0), (20.0, 0), (30.0, 1)];
        let counted = starts.map(|(start, group)| days.count(start, group));
        assert_eq!(counted, [86_000.0, 86_410.0, 86_405.0, 166_400.0, 172_820.0, 30.0]);
    }
}
