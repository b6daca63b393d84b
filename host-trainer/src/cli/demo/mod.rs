//! The main job on an embedded default: a machine and its digital twin, a model, the device, a diagnosis, and back.
//!
//! | module | holds |
//! |---|---|
//! | [`generator`] | a machine that from some recording on is not as drawn |
//! | [`job`] | from recordings and drawing to a corrected model on the device |
//! | [`outcome`] | what was put in beside what was found |
//! | [`page`] | the report |
//!
//! [`run`] makes the recordings and writes them and the machine's drawing; everything after that knows only this
//! folder. What was put in ([`generator::Truth`]) meets what was found only in the [`DemoResult`].

pub(super) mod command;
pub mod generator;
pub mod job;
pub mod outcome;
mod page;

use std::path::{Path, PathBuf};

use ballrace_core::states::{Alignment, Orders, StateSpec};

use crate::model::fit::{FitConfig, FitError, Solver};
use crate::model::sindy_nn::train::TrainConfig;
use generator::Scenario;
use job::Job;
pub use outcome::DemoResult;

/// What to make and what to do with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// The recordings.
    pub plan: Scenario,
    /// The job.
    pub job: Job,
}

impl Config {
    /// The demo of a seed: small enough for well under a minute on two cores.
    ///
    /// States of the past only, so that the prediction is one of the next sample. Four of them: more make the model of
    /// the machine as drawn no better.
    pub fn new(seed: u64) -> Self {
        let train = TrainConfig { max_steps: 2500, batch: 1024, learning_rate: 3e-3, ..TrainConfig::default() };
        Self {
            plan: Scenario { recordings: 60, seconds: 0.25, sample_rate_hz: 25_600.0, gain: 4.0, seed },
            job: Job {
                diagnosed: 4,
                fit: FitConfig {
                    spec: StateSpec { dimension: 4, orders: Orders::Consecutive, alignment: Alignment::Causal },
                    degree: 2,
                    harmonics: 1,
                    latent: None,
                    solver: Solver::SindyNn { hidden: vec![32], train },
                    hold_out_every: 5,
                    null_fits: 3,
                    seed,
                    block: None,
                    full_scale: 0.0,
                },
            },
        }
    }
}

/// Why a demo ends early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DemoError {
    /// A file or folder.
    #[error("{path}: {source}")]
    Io {
        /// Which.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The rig.
    #[error(transparent)]
    Rig(#[from] crate::rig::RigError),
    /// The recordings, on the way out.
    #[error(transparent)]
    Write(#[from] crate::recording::write::WriteError),
    /// The recordings, on the way back.
    #[error(transparent)]
    Read(#[from] crate::recording::ReadError),
    /// The recordings, together.
    #[error(transparent)]
    Input(#[from] crate::recording::input::InputError),
    /// Not enough to diagnose some and judge by others.
    #[error("recordings: found {found}, expected at least {expected}")]
    Few {
        /// Recordings there are.
        found: usize,
        /// Recordings needed.
        expected: usize,
    },
    /// A fit.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// A model file.
    #[error(transparent)]
    File(#[from] crate::model::file::FileError),
    /// The device.
    #[error(transparent)]
    Limit(#[from] crate::model::export::BreaksLimit),
    /// The device's form of the model.
    #[error(transparent)]
    Model(#[from] ballrace_core::model::ModelError),
    /// The device on the recordings.
    #[error(transparent)]
    Watch(#[from] crate::model::replay::ReplayError),
    /// The diagnosis.
    #[error(transparent)]
    Diagnose(#[from] crate::diagnose::DiagnoseError),
    /// The diagnosis, on the way out.
    #[error(transparent)]
    Store(#[from] crate::report::diagnosis::FolderError),
    /// The diagnosis, on the way back.
    #[error(transparent)]
    Causes(#[from] crate::diagnose::causes::CausesError),
    /// The causes' terms.
    #[error(transparent)]
    Terms(#[from] crate::model::fit::terms::NoRoom),
    /// The report.
    #[error(transparent)]
    Draw(#[from] crate::report::plot::DrawError),
}

/// Runs the whole of it into a folder, which is made where there is none. `progress` gets what is
/// being done and which share of the whole is done.
///
/// # Errors
/// The first thing that goes wrong.
pub fn run(config: &Config, out: &Path, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<DemoResult, DemoError> {
    progress("making recordings", 0.0);
    let made = generator::make(&config.plan)?;
    crate::recording::write::folder(&out.join("recordings"), &made.recordings)?;
    write(&out.join(job::RIG), generator::RIG.as_bytes())?;
    let found = job::run(&config.job, out, progress)?;
    let outcome = DemoResult::new(config, &made, &found);
    progress("report", 0.95);
    let page = page::document(&outcome, &found)?;
    write(&out.join("report.html"), page.html().as_bytes())?;
    progress("done", 1.0);
    Ok(outcome)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), DemoError> {
    crate::recording::atomic_write::write_atomically(path, bytes)
        .map_err(|source| DemoError::Io { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests;
