//! Accuracy of the diagnosis: cases with hidden causes, diagnosed from their folders, scored against the truth.
//!
//! OUT holds, case by case, `cases/NAME` (rig and recordings), `diagnoses/NAME` (the diagnosis) and, once every
//! case has been diagnosed and not before, `truth/NAME.json`. The truth of a case follows from the seed, so that nothing
//! of it need be kept during the diagnoses. Finished cases are not diagnosed again.
//!
//! | module | holds |
//! |---|---|
//! | `cases` | rigs, recordings and hidden causes |
//! | [`independent`] | simulator of its own, which shares nothing with the one that the diagnosis searches with |
//! | [`score`] | one case: diagnosis against truth |
//! | [`calibration`] | stated probabilities and held-out signals: Brier score, reliability, distance |
//! | [`settings`] | seeds for choosing and for scoring |
//! | `table` | all cases: confusion matrix, severities, intervals, times |

pub mod calibration;
pub(crate) mod cases;
pub mod independent;
pub mod score;
pub mod settings;
pub(crate) mod table;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use rayon::ThreadPoolBuilder;
use serde::{Deserialize, Serialize};

use crate::diagnose::write::DOCUMENT;
use crate::diagnose::{Task, diagnose};
use crate::evaluate::cases::case_spec::{CaseSpec, Hidden, Kind, round};
use crate::evaluate::cases::simulator::Simulator;
use crate::evaluate::cases::{Case, CaseError};
use crate::recording::atomic_write::write_atomically;
use crate::recording::load_all;
use crate::report;
use crate::rig::Rig;
use score::{Outcome, Score};

/// Selection of the cases.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Config {
    /// Seed of all draws.
    pub seed: u64,
    /// Rounds of the list of cases.
    pub rounds: usize,
    /// Simulator of the cases.
    #[serde(default)]
    pub simulator: Simulator,
    /// Length of a recording, s.
    pub seconds: f64,
    /// Kinds of cases; empty for all.
    pub kinds: Vec<String>,
    /// Severities of single effects; empty for all.
    pub severities: Vec<String>,
    /// Effects, of the vocabulary or outside it, by name; empty for all.
    pub effects: Vec<String>,
    /// Step through the selected cases: 1 takes all.
    pub every: usize,
}

impl Config {
    /// Selected cases with their numbers in the whole list, by which a part of the list has the same cases.
    pub fn specs(&self) -> Vec<(usize, CaseSpec)> {
        let all = (0..self.rounds).flat_map(|n| round(n, self.simulator)).enumerate();
        all.filter(|(_, spec)| self.wants(spec)).step_by(self.every.max(1)).collect()
    }

    fn wants(&self, spec: &CaseSpec) -> bool {
        let among = |list: &[String], name: &str| list.is_empty() || list.iter().any(|l| l == name);
        let severity = match &spec.hidden {
            Hidden::Effects(effects) if spec.kind() == Kind::Single => {
                effects.first().map(|(_, severity)| severity.name())
            }
            _ => None,
        };
        among(&self.kinds, spec.kind().name())
            && severity.is_none_or(|name| among(&self.severities, name))
            && (self.effects.is_empty() || spec.names().iter().any(|name| among(&self.effects, name)))
    }

    /// Names of all effects that a case of a simulator can have, of the vocabulary and outside it.
    pub fn effect_names(simulator: Simulator) -> Vec<&'static str> {
        let mut names: Vec<&str> = round(0, simulator).iter().flat_map(CaseSpec::names).collect();
        let mut seen = std::collections::HashSet::new();
        names.retain(|name| seen.insert(*name));
        names
    }

    fn case(&self, number: usize, spec: &CaseSpec) -> Result<Case, EvaluateError> {
        let seed = self.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(number as u64);
        Case::draw(spec, self.simulator, self.seconds, seed).map_err(|e| EvaluateError::Case(name(number), e.into()))
    }
}

fn name(number: usize) -> String {
    format!("case{number:03}")
}

/// Errors of an evaluation.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvaluateError {
    /// Case that could not be made.
    #[error("{0}: {1}")]
    Case(String, CaseError),
    /// File that cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// Document that cannot be read.
    #[error("{path}: {source}")]
    Json {
        /// The document.
        path: PathBuf,
        /// Error of the parser, with its place.
        source: serde_json::Error,
    },
    /// Folder of another evaluation.
    #[error(
        "{path}: found the cases of another evaluation, expected a new folder or the same simulator, seed, rounds and seconds"
    )]
    Another {
        /// Settings of that evaluation.
        path: PathBuf,
    },
    /// Selection without a case.
    #[error("--kind, --severity and --effect: found no case that all of them select, expected at least one")]
    Nothing,
    /// Threads that cannot be started.
    #[error("threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// Run of a diagnosis: time and error.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Ran {
    /// Wall time, s.
    pub seconds: f64,
    /// Error of a run without a diagnosis.
    pub error: Option<String>,
}

/// Progress: a finished case's name, the number finished, and the number of cases.
pub type Progress<'a> = &'a (dyn Fn(&str, usize, usize) + Sync);

/// Makes, diagnoses and scores the cases, `jobs` at a time.
///
/// # Errors
/// The first error of the files; a diagnosis that ends with an error counts as wrong and does not end the evaluation.
pub fn evaluate(config: &Config, out: &Path, jobs: usize, progress: Progress) -> Result<Vec<Score>, EvaluateError> {
    let specs = each(config, out, jobs, progress, &|number, spec| one(config, number, spec, out))?;
    specs.iter().map(|(number, spec)| open(config, *number, spec, out)).collect()
}

/// Writes the cases and their truth without a diagnosis, `jobs` at a time, and returns their number. An evaluation of the
/// same cases in the same folder goes on from there.
///
/// # Errors
/// The first error of the files.
pub fn write_cases(config: &Config, out: &Path, jobs: usize, progress: Progress) -> Result<usize, EvaluateError> {
    make(&out.join("truth"))?;
    let specs = each(config, out, jobs, progress, &|number, spec| {
        let name = name(number);
        let truth = out.join("truth").join(format!("{name}.json"));
        if truth.exists() {
            return Ok(());
        }
        let (folder, case) = (out.join("cases").join(&name), config.case(number, spec)?);
        make(&folder)?;
        case.write(&folder).map_err(|e| EvaluateError::Case(name, e))?;
        store(&truth, &case.truth)
    })?;
    Ok(specs.len())
}

/// Does the same to all cases, and returns them.
fn each(
    config: &Config,
    out: &Path,
    jobs: usize,
    progress: Progress,
    act: &(dyn Fn(usize, &CaseSpec) -> Result<(), EvaluateError> + Sync),
) -> Result<Vec<(usize, CaseSpec)>, EvaluateError> {
    let specs = config.specs();
    if specs.is_empty() {
        return Err(EvaluateError::Nothing);
    }
    claim(config, out)?;
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let failed = Mutex::new(None);
    let threads = std::thread::available_parallelism().map_or(1, usize::from).div_ceil(jobs.max(1));
    let pools = (0..jobs.max(1)).map(|_| ThreadPoolBuilder::new().num_threads(threads).build());
    let pools = pools.collect::<Result<Vec<_>, _>>()?;
    std::thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| {
                while let Some((number, spec)) = specs.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let result = pool.install(|| act(*number, spec));
                    if let (Err(error), Ok(mut failed)) = (result, failed.lock()) {
                        next.store(specs.len(), Ordering::Relaxed);
                        failed.get_or_insert(error);
                    }
                    progress(&name(*number), done.fetch_add(1, Ordering::Relaxed) + 1, specs.len());
                }
            });
        }
    });
    if let Ok(Some(error)) = failed.into_inner() {
        return Err(error);
    }
    Ok(specs)
}

/// Writes the settings that fix the cases, or checks that the folder has the same ones.
fn claim(config: &Config, out: &Path) -> Result<(), EvaluateError> {
    let path = out.join("evaluation.json");
    let all = Config { kinds: Vec::new(), severities: Vec::new(), effects: Vec::new(), every: 1, ..config.clone() };
    if path.exists() {
        return if read::<Config>(&path)? == all { Ok(()) } else { Err(EvaluateError::Another { path }) };
    }
    make(out)?;
    store(&path, &all)
}

/// Makes and diagnoses a case, unless it has been diagnosed.
fn one(config: &Config, number: usize, spec: &CaseSpec, out: &Path) -> Result<(), EvaluateError> {
    let name = name(number);
    let (case, diagnosis) = (out.join("cases").join(&name), out.join("diagnoses").join(&name));
    let ran = diagnosis.join("run.json");
    if ran.exists() {
        return Ok(());
    }
    if !out.join("truth").join(format!("{name}.json")).exists() {
        make(&case)?;
        config.case(number, spec)?.write(&case).map_err(|e| EvaluateError::Case(name, e))?;
    }
    make(&diagnosis)?;
    let start = Instant::now();
    let error = diagnosed(&case, &diagnosis).err();
    store(&ran, &Ran { seconds: start.elapsed().as_secs_f64(), error })
}

/// Diagnoses a folder as the command `diagnose` does.
fn diagnosed(case: &Path, out: &Path) -> Result<(), String> {
    let text = |e: &dyn std::fmt::Display| e.to_string();
    let read = |path: &Path| load_all(path).map_err(|e| text(&e));
    let rig = Rig::read(&case.join("rig.toml")).map_err(|e| text(&e))?;
    let recordings = read(case)?;
    let baseline = case.join("baseline");
    let baseline = if baseline.exists() { Some(read(&baseline)?) } else { None };
    let task = Task { rig: &rig, baseline: baseline.as_deref(), recordings: &recordings, seed: 1 };
    let outcome = diagnose(&task, &|_| ()).map_err(|e| text(&e))?;
    report::diagnosis::folder(out, &task, &outcome).map_err(|e| text(&e))
}

/// Writes the truth of a case, and scores its diagnosis.
fn open(config: &Config, number: usize, spec: &CaseSpec, out: &Path) -> Result<Score, EvaluateError> {
    let name = name(number);
    let truth = config.case(number, spec)?.truth;
    make(&out.join("truth"))?;
    store(&out.join("truth").join(format!("{name}.json")), &truth)?;
    let diagnosis = out.join("diagnoses").join(&name);
    let ran: Ran = read(&diagnosis.join("run.json"))?;
    let said = if ran.error.is_none() { Some(read(&diagnosis.join(DOCUMENT))?) } else { None };
    let distance = calibration::distance(&diagnosis);
    Ok(Score::new(name, spec, truth, &Outcome { said: said.as_ref(), distance, ran: &ran }))
}

fn make(folder: &Path) -> Result<(), EvaluateError> {
    std::fs::create_dir_all(folder).map_err(|source| EvaluateError::Io { path: folder.into(), source })
}

fn store(path: &Path, value: &impl Serialize) -> Result<(), EvaluateError> {
    let json = |source| EvaluateError::Json { path: path.into(), source };
    let text = serde_json::to_vec_pretty(value).map_err(json)?;
    write_atomically(path, &text).map_err(|source| EvaluateError::Io { path: path.into(), source })
}

fn read<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T, EvaluateError> {
    let text = std::fs::read(path).map_err(|source| EvaluateError::Io { path: path.into(), source })?;
    serde_json::from_slice(&text).map_err(|source| EvaluateError::Json { path: path.into(), source })
}
