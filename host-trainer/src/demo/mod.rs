//! The main job on an embedded default: recordings, fit, export, the device, a report.
//!
//! [`run`] makes the recordings and writes them; everything after that knows only their folder and
//! how many of them are healthy, as of a machine that was just commissioned. What was put in
//! ([`generator::Truth`]) meets what was found only in the [`Outcome`].

pub mod generator;
mod outcome;
mod page;

use std::path::{Path, PathBuf};

use ballrace_core::states::{Alignment, Orders, StateSpec};

use crate::export::{self, BreaksLimit, Format, Limits, Sizes};
use crate::fit::{self, FitConfig, FitError, Fitted, Solver, fit};
use crate::input::{Input, InputError};
use crate::model_file;
use crate::recording::{self, LoadOptions, ReadError, write::WriteError};
use crate::sindy_nn::train::TrainConfig;
use crate::watch::{self, WatchError, Watched, watch};
use generator::Plan;
pub use outcome::Outcome;

/// What to make and how to fit it.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// The recordings.
    pub plan: Plan,
    /// How many from the start are taken for healthy: the machine was commissioned with them.
    pub healthy: usize,
    /// The fit.
    pub fit: FitConfig,
}

impl Config {
    /// The demo of a seed: small enough for well under a minute on two cores.
    pub fn new(seed: u64) -> Self {
        let train = TrainConfig { max_steps: 1500, batch: 512, ..TrainConfig::default() };
        Self {
            plan: Plan { recordings: 60, seconds: 0.25, sample_rate_hz: 25_600.0, depth_m: 3e-6, seed },
            healthy: 20,
            fit: FitConfig {
                spec: StateSpec { dimension: 8, orders: Orders::Even, alignment: Alignment::Half },
                degree: 2,
                harmonics: 1,
                latent: None,
                solver: Solver::SindyNn { hidden: vec![64], train },
                hold_out_every: 5,
                null_fits: 5,
                seed,
                block: None,
                full_scale: 0.0,
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
    Write(#[from] WriteError),
    /// The recordings, on the way back.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The recordings, together.
    #[error(transparent)]
    Input(#[from] InputError),
    /// More healthy recordings than recordings, or none.
    #[error("healthy recordings: found {found}, expected 1 to {total}")]
    Healthy {
        /// As asked for.
        found: usize,
        /// Recordings there are.
        total: usize,
    },
    /// The fit.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The model file.
    #[error(transparent)]
    File(#[from] model_file::FileError),
    /// The device.
    #[error(transparent)]
    Limit(#[from] BreaksLimit),
    /// The device's form of the model.
    #[error(transparent)]
    Model(#[from] ballrace_core::model::ModelError),
    /// The device on the recordings.
    #[error(transparent)]
    Watch(#[from] WatchError),
    /// The report.
    #[error(transparent)]
    Draw(#[from] crate::plot::DrawError),
}

/// What the tools found in a folder of recordings.
struct Found {
    input: Input,
    fitted: Fitted,
    sizes: Sizes,
    watched: Watched,
}

/// Runs the whole of it into a folder, which is made where there is none. `progress` gets what is
/// being done and which share of the whole is done.
///
/// # Errors
/// The first thing that goes wrong.
pub fn run(config: &Config, out: &Path, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<Outcome, DemoError> {
    progress("making recordings", 0.0);
    let folder = out.join("recordings");
    let made = generator::make(&config.plan)?;
    recording::write::folder(&folder, &made.recordings)?;
    let found = job(&folder, config.healthy, &config.fit, out, progress)?;
    let outcome = Outcome::of(config, &made, &found);
    progress("report", 0.95);
    let page = page::document(&outcome, &found)?;
    write(&out.join("report.html"), page.html().as_bytes())?;
    progress("done", 1.0);
    Ok(outcome)
}

/// From a folder of recordings to a model and what the device makes of them: as any user would.
fn job(
    folder: &Path,
    healthy: usize,
    config: &FitConfig,
    out: &Path,
    progress: &(dyn Fn(&str, f64) + Sync),
) -> Result<Found, DemoError> {
    progress("reading", 0.02);
    let loaded = recording::load(&[folder.to_owned()], &LoadOptions::default())?;
    let input = Input::of(&loaded.recordings, None)?;
    let total = input.series.len();
    let commissioning = input.series.get(..healthy).filter(|s| !s.is_empty());
    let commissioning = commissioning.ok_or(DemoError::Healthy { found: healthy, total })?;
    let mut fitted = fit(commissioning, input.sample_rate_hz, config, &|stage: fit::Stage| {
        progress(&stage.name, 0.05 + 0.85 * stage.done);
    })?;
    fitted.report.training.channel = Some(input.channel.clone());
    model_file::write(&out.join("model.json"), &fitted.model, &fitted.report)?;

    progress("export", 0.9);
    let sizes = export::sizes(&fitted.model.view());
    Limits::default().check(&sizes)?;
    for (name, format) in [("model.bin", Format::Bin), ("model.h", Format::C), ("model.rs", Format::Rust)] {
        write(&out.join(name), &export::export(&fitted.model, format)?)?;
    }

    progress("the device on all recordings", 0.92);
    let watched = watch(&fitted.model, &input, &watch::Options::default(), &mut |_, _| ())?;
    let lines: String = watched.events.iter().map(|event| format!("{event}\n")).collect();
    write(&out.join("events.jsonl"), lines.as_bytes())?;
    Ok(Found { input, fitted, sizes, watched })
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), DemoError> {
    crate::files::write_atomically(path, bytes).map_err(|source| DemoError::Io { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests;
