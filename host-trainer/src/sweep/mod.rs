//! Studies of libraries and dimensions: a grid of fits, all cores, resumable.
//!
//! | module | holds |
//! |---|---|
//! | [`config`] | `sweep.toml`, and the jobs of its grid |
//! | [`construct`] | a library in three steps, under a limit of time |
//! | [`preset`] | the tables and figures of the paper, and their jobs |
//! | [`method`] | what a fit is made by: a solver, or a rival of Table 4 |
//! | [`life`] | bearings run to failure, for the presets |
//! | [`job`] | one fit: what it is, and its row |
//! | [`journal`] | rows that are done, on disk |
//! | [`table`] | rows as CSV and Parquet |

pub mod config;
pub mod construct;
pub mod job;
pub mod journal;
pub mod life;
pub mod method;
pub mod preset;
pub mod table;

use std::collections::HashMap;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use self::job::{Job, Material, Row};
use self::journal::{Journal, JournalError};

/// Rows of all jobs, in their order; equal jobs are fitted once. Those that the journal in `folder` has are not fitted again;
/// the others are written to it as soon as they are done. `progress` gets the number of jobs done and of all.
///
/// # Errors
/// A journal that cannot be read or written. A fit that fails has a row that says why.
pub fn run(
    jobs: &[Job],
    material: &Material,
    folder: &Path,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Vec<Row>, JournalError> {
    let jobs: Vec<Job> = jobs.iter().map(|job| job.identified(material)).collect();
    let mut distinct: Vec<&Job> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    let place: Vec<usize> = jobs
        .iter()
        .map(|job| {
            *places.entry(journal::key(job)).or_insert_with(|| {
                distinct.push(job);
                distinct.len() - 1
            })
        })
        .collect();
    let journal = Journal::open(folder)?;
    let known: Vec<Option<Row>> = distinct.iter().map(|job| journal.row(job).cloned()).collect();
    let done = AtomicUsize::new(known.iter().flatten().count());
    let all = distinct.len();
    progress(done.load(Ordering::Relaxed), all);
    let journal = Mutex::new(journal);
    let made = distinct.par_iter().zip(known).map(|(job, known): (&&Job, Option<Row>)| match known {
        Some(row) => Ok(row),
        None => {
            let row = job.fit(material);
            // A thread that panicked while it held the lock has written nothing or a whole line.
            journal.lock().unwrap_or_else(std::sync::PoisonError::into_inner).add(&row)?;
            progress(1 + done.fetch_add(1, Ordering::Relaxed), all);
            Ok(row)
        }
    });
    let rows: Vec<Row> = made.collect::<Result<_, JournalError>>()?;
    Ok(place.into_iter().map(|at| rows[at].clone()).collect())
}
