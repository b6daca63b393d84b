//! Commands `ballrace simulate` and `ballrace predict`.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::output::{Force, Outputs};
use super::{Failure, json, line};
use crate::recording::manifest::Manifest;
use crate::recording::write::{self, WriteError};
use crate::recording::{Recording, load_all};
use crate::rig::batch;
use crate::rig::config::{Machine, Rig};

/// Simulate a rig under the operating conditions of a manifest
///
/// A bearing rig needs `shaft_hz`, `load_n` and `sample_rate_hz` of each entry; the files need not
/// exist. The input of an sdof rig is channel `u` of the files.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Example:\n  ballrace simulate --rig rig.toml --manifest recordings.toml --out simulated --seconds 2\n  \
    writes simulated/r01.csv, … and simulated/recordings.toml"
)]
pub struct SimulateArgs {
    /// Rig
    #[arg(long, value_name = "rig.toml")]
    rig: PathBuf,
    /// Operating conditions
    #[arg(long, value_name = "recordings.toml")]
    manifest: PathBuf,
    /// Folder to write to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Length of each recording of a bearing rig, s
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
    /// Seed of initial angles, process force and sensor noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    force: Force,
    /// Print what was written as one JSON document
    #[arg(long)]
    json: bool,
}

/// Simulate each recording of a folder with a rig
///
/// Speed, load, sample rate and length are the recording's; initial angles and noise are drawn from
/// the seed. The input of an sdof rig is channel `u` of the recording.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  ballrace predict --rig rig.corrected.toml --recordings data --out predicted")]
pub struct PredictArgs {
    /// Rig, corrected or not
    #[arg(long, value_name = "rig.toml")]
    rig: PathBuf,
    /// Recordings to predict
    #[arg(long, value_name = "DIR")]
    recordings: PathBuf,
    /// Folder to write to
    #[arg(long, value_name = "OUT")]
    out: PathBuf,
    /// Seed of initial angles, process force and sensor noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    force: Force,
    /// Print what was written as one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs `simulate`.
pub fn simulate(args: &SimulateArgs) -> Result<(), Failure> {
    if !(args.seconds.is_finite() && args.seconds > 0.0) {
        return Err(Failure::option("seconds", args.seconds, "a positive number"));
    }
    let rig = Rig::read(&args.rig).map_err(Failure::input)?;
    let outputs = Outputs::new(args.force, [&args.rig]).beside(std::slice::from_ref(&args.manifest));
    let made = if matches!(rig.model, Machine::Sdof(_)) {
        let recordings = load_all(&args.manifest).map_err(Failure::input)?;
        outputs.recordings("out", &args.out, &write::files(&args.out, recordings.len()))?;
        batch::recordings(&rig, &recordings, args.seed)
    } else {
        let manifest = Manifest::read(&args.manifest).map_err(Failure::input)?;
        outputs.recordings("out", &args.out, &write::files(&args.out, manifest.entries.len()))?;
        batch::entries(&rig, &manifest.entries, args.seconds, args.seed)
    };
    store(&made.map_err(Failure::input)?, &args.out, args.json)
}

/// Runs `predict`.
pub fn predict(args: &PredictArgs) -> Result<(), Failure> {
    let rig = Rig::read(&args.rig).map_err(Failure::input)?;
    let outputs = Outputs::new(args.force, [&args.rig]).beside(std::slice::from_ref(&args.recordings));
    outputs.folder("out", &args.out, &[])?;
    let recordings = load_all(&args.recordings).map_err(Failure::input)?;
    outputs.recordings("out", &args.out, &write::files(&args.out, recordings.len()))?;
    if matches!(rig.model, Machine::Sdof(_)) {
        for recording in recordings.iter().filter(|recording| recording.channel("u").is_none()) {
            eprintln!("note: {}: found no channel u; the input is taken to be 0", recording.source);
        }
    }
    let made = batch::recordings(&rig, &recordings, args.seed).map_err(Failure::input)?;
    store(&made, &args.out, args.json)
}

#[derive(Serialize)]
struct Written {
    manifest: PathBuf,
    recordings: usize,
    seconds: f64,
}

fn store(recordings: &[Recording], out: &Path, as_json: bool) -> Result<(), Failure> {
    let manifest = write::folder(out, recordings).map_err(|error| match error {
        WriteError::Foreign { .. } => Failure::input(error),
        _ => Failure::other(error),
    })?;
    let seconds = recordings.iter().map(Recording::duration_s).sum();
    let written = Written { manifest, recordings: recordings.len(), seconds };
    if as_json {
        return json(&written);
    }
    line(format_args!("wrote {} recordings ({seconds:.2} s) and {}", written.recordings, written.manifest.display()))
}
