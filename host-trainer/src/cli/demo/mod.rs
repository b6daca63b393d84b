//! Demonstration of the whole loop: nominal rig, model, device, diagnosis, corrected model.
//!
//! | module | holds |
//! |---|---|
//! | [`generator`] | recordings of a machine that at some time departs from its nominal rig |
//! | [`job`] | from recordings and nominal rig to a corrected model on the device |
//! | [`outcome`] | truth and result |
//! | [`page`] | the report |
//! | [`settings`] | operating conditions and ranges of the hidden mode |
//!
//! [`run`] simulates the recordings and writes them and the nominal rig; the job knows only this folder. The truth
//! ([`generator::Truth`]) is compared with the result only in the [`DemoResult`].

pub(super) mod command;
pub(crate) mod generator;
pub(crate) mod job;
pub mod outcome;
mod page;
pub(crate) mod settings;

use std::path::{Path, PathBuf};

use ballrace_core::network::Arithmetic;
use ballrace_core::states::{Alignment, Estimator, Orders, StateSpec};

use crate::model::fit::{FitConfig, FitError, Solver};
use crate::model::sindy_nn::config::TrainConfig;
use crate::signal::surrogate::SurrogateKind;
use generator::Scenario;
use job::Job;
pub use outcome::DemoResult;

/// Options of the demo.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Recordings to simulate.
    pub scenario: Scenario,
    /// Options of the job.
    pub job: Job,
}

impl Config {
    /// Options of a seed, for a run of well under a minute on two cores.
    ///
    /// Causal states, so that the prediction is one of the next sample; more than four do not improve the model of the
    /// nominal rig.
    pub fn new(seed: u64) -> Self {
        let train = TrainConfig { max_steps: Some(2500), ..TrainConfig::default() };
        Self {
            scenario: Scenario { recordings: 60, seconds: 0.25, sample_rate_hz: 25_600.0, gain: 4.0, seed },
            job: Job {
                diagnosed: 4,
                fit: FitConfig {
                    spec: StateSpec {
                        dimension: 4,
                        orders: Orders::Consecutive,
                        alignment: Alignment::Causal,
                        estimator: Estimator::Differences,
                    },
                    degree: 2,
                    harmonics: 1,
                    powers: false,
                    latent: None,
                    solver: Solver::SindyNn { hidden: vec![32], train },
                    arithmetic: Arithmetic::Float,
                    hold_out_every: 5,
                    null_fits: 3,
                    null_kind: SurrogateKind::default(),
                    causal: true,
                    trainings: 1,
                    seed,
                    ..FitConfig::default()
                },
            },
        }
    }
}

/// Error of the demo.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DemoError {
    /// File or folder that cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// Path of the file or folder.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// Error of the rig or its simulation.
    #[error(transparent)]
    Rig(#[from] crate::rig::RigError),
    /// Error of writing the recordings.
    #[error(transparent)]
    Write(#[from] crate::recording::write::WriteError),
    /// Error of reading the recordings.
    #[error(transparent)]
    Read(#[from] crate::recording::ReadError),
    /// Recordings that cannot be combined.
    #[error(transparent)]
    Input(#[from] crate::recording::input::InputError),
    /// Too few recordings to diagnose some and hold out others.
    #[error("recordings: found {found}, expected at least {expected}")]
    Few {
        /// Recordings found.
        found: usize,
        /// Recordings needed.
        expected: usize,
    },
    /// Error of a fit.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// Error of a model file.
    #[error(transparent)]
    File(#[from] crate::model::file::FileError),
    /// Model beyond a limit of the device.
    #[error(transparent)]
    Limit(#[from] crate::model::export::BreaksLimit),
    /// Error of the device's form of the model.
    #[error(transparent)]
    Model(#[from] ballrace_core::model::ModelError),
    /// Error of a replay on the device.
    #[error(transparent)]
    Watch(#[from] crate::model::replay::ReplayError),
    /// Error of the diagnosis.
    #[error(transparent)]
    Diagnose(#[from] crate::diagnose::DiagnoseError),
    /// Error of writing the diagnosis.
    #[error(transparent)]
    Store(#[from] crate::report::diagnosis::FolderError),
    /// Error of reading the diagnosis.
    #[error(transparent)]
    Causes(#[from] crate::diagnose::causes::CausesError),
    /// Library too large for the causes' terms.
    #[error(transparent)]
    Terms(#[from] crate::model::fit::terms::NoRoom),
    /// Error of drawing the report.
    #[error(transparent)]
    Draw(#[from] crate::report::plot::DrawError),
}

/// Runs the demo in a folder, which is created if needed. `progress` gets the current step and the
/// share done.
///
/// # Errors
/// The first error of any step.
pub fn run(config: &Config, out: &Path, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<DemoResult, DemoError> {
    progress("simulating recordings", 0.0);
    let made = generator::make(&config.scenario)?;
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
