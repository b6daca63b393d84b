//! `ballrace calibrate`.

use std::path::PathBuf;

use clap::ValueEnum;

use super::{Failure, json, line, write};
use crate::calibrate::bearing::{Calibration, Options, PathChoice};
use crate::calibrate::calibrate;
use crate::recording::{LoadOptions, load};
use crate::report;
use crate::rig::Rig;

/// Fit a rig's uncertain parameters to recordings of the healthy machine
///
/// Fits what the rig's file calls `unknown`, the noise levels, and the angles at which each recording
/// began; says what the recordings do not determine. The last quarter of the recordings takes no part
/// and judges the fit. Where the rig alone does not come near the recordings, the transmission path
/// from rig to sensor is identified.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Example:\n  ballrace calibrate --rig rig.toml --recordings healthy --out rig.calibrated.toml --report calibration.html"
)]
pub struct Args {
    /// The rig, with `unknown = [...]`
    #[arg(long, value_name = "rig.toml")]
    rig: PathBuf,
    /// Recordings of the healthy machine
    #[arg(long, value_name = "DIR")]
    recordings: PathBuf,
    /// Where to write the calibrated rig
    #[arg(long, value_name = "rig.toml")]
    out: PathBuf,
    /// The structure between rig and sensor
    #[arg(long, value_enum, default_value_t = Path::Auto)]
    path: Path,
    /// Write a report with pictures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Seed of the simulations that spectra are compared by
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Print the result as one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Path {
    /// Where the rig alone does not come near the recordings
    Auto,
    /// Never
    None,
    /// Always
    AllPole,
}

/// Runs `calibrate`.
pub fn run(args: &Args) -> Result<(), Failure> {
    let rig = Rig::read(&args.rig).map_err(Failure::input)?;
    let recordings =
        load(std::slice::from_ref(&args.recordings), &LoadOptions::default()).map_err(Failure::input)?.recordings;
    let path = match args.path {
        Path::Auto => PathChoice::Auto,
        Path::None => PathChoice::None,
        Path::AllPole => PathChoice::AllPole,
    };
    let spinner = super::input::spinner();
    let options = Options { path, seed: args.seed };
    let calibration = calibrate(&rig, &recordings, &options, &|what| spinner.set_message(what.to_owned()));
    spinner.finish_and_clear();
    let calibration = calibration.map_err(Failure::input)?;
    calibration.rig.write(&args.out).map_err(Failure::other)?;
    if let Some(path) = &args.report {
        let document =
            report::calibrate::document(&rig, &calibration, &recordings, args.seed).map_err(Failure::other)?;
        write(path, document.html().as_bytes())?;
    }
    if args.json {
        return json(&calibration);
    }
    for text in lines(&calibration) {
        line(text)?;
    }
    line(format_args!("wrote {}", args.out.display()))
}

fn lines(calibration: &Calibration) -> Vec<String> {
    let mut out = Vec::new();
    if !calibration.parameters.is_empty() {
        out.push(format!("{:<42} {:>12} {:>12}   95 % interval", "parameter", "before", "calibrated"));
    }
    for p in &calibration.parameters {
        let told = if p.determined { "" } else { "   not determined" };
        out.push(format!(
            "{:<42} {:>12.5e} {:>12.5e}   {:.5e} to {:.5e}{told}",
            p.key, p.before, p.value, p.interval95[0], p.interval95[1]
        ));
    }
    for (channel, poles) in &calibration.path_poles {
        out.push(format!("{channel}: transmission path of {poles} poles"));
    }
    for free in &calibration.undetermined {
        out.push(format!("the recordings do not determine {}", free.free));
    }
    for e in &calibration.explained {
        out.push(format!(
            "{}: {:.1} % of the power is the rig's own turning; the rest is within {:.2} dB of its noise",
            e.channel,
            100.0 * e.deterministic,
            e.residual_db
        ));
    }
    if !calibration.converged {
        out.push("the search ended before there was no more to gain".into());
    }
    out.push(format!("held out: {}; log-spectral distance, dB", calibration.held_out_recordings));
    for h in &calibration.held_out {
        out.push(format!(
            "  {} {}: before {:.2}, after {:.2}, two runs of the rig are {:.2} apart",
            h.recording, h.channel, h.before_db, h.after_db, h.floor_db
        ));
    }
    out
}
