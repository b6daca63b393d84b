//! Command `ballrace calibrate`.

use std::path::PathBuf;

use clap::ValueEnum;
use serde::Serialize;

use super::output::{Force, Outputs};
use super::{Failure, json, line, write};
use crate::identify::calibrate::bearing::{Calibration, Options, PathChoice};
use crate::identify::calibrate::calibrate;
use crate::identify::force_balance::{self, calibrate_sdof};
use crate::identify::input_check;
use crate::recording::{Recording, load_all};
use crate::report;
use crate::report::Document;
use crate::rig::{Machine, Rig};
use crate::stats::format::{share, significant};
use crate::stats::units::NamedUnit;

/// Fit a rig's uncertain parameters to recordings of the healthy machine
///
/// Fits what the rig's file calls `unknown`, and of a bearing rig the noise levels and the initial
/// angles of each recording; lists parameters that the recordings do not determine. The last quarter
/// of the recordings is held out for validation. If a bearing rig alone does not fit the recordings,
/// the transfer path from rig to sensor is identified. Recordings for an sdof rig have channels `u`
/// and `q` (or `qdd`).
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Example:\n  ballrace calibrate --rig rig.toml --recordings healthy --out rig.calibrated.toml --report calibration.html"
)]
pub struct Args {
    /// Rig, with `unknown = [...]`
    #[arg(long, value_name = "rig.toml")]
    rig: PathBuf,
    /// Recordings of the healthy machine
    #[arg(long, value_name = "DIR")]
    recordings: PathBuf,
    /// File for the calibrated rig
    #[arg(long, value_name = "rig.toml")]
    out: PathBuf,
    /// Transfer path between a bearing rig and its sensor
    #[arg(long, value_enum, default_value_t = Path::Auto)]
    path: Path,
    /// Write a report with pictures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Seed of the simulations whose spectra are compared
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Print the result as one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Path {
    /// If the rig alone does not fit the recordings
    Auto,
    /// Never
    None,
    /// Always
    AllPole,
}

/// Runs `calibrate`.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut outputs = Outputs::new(args.force, [&args.rig]).beside(std::slice::from_ref(&args.recordings));
    outputs.rig("out", &args.out, &args.rig)?;
    args.report.iter().try_for_each(|path| outputs.file("report", path))?;
    let rig = Rig::read(&args.rig).map_err(Failure::input)?;
    let recordings = load_all(&args.recordings).map_err(Failure::input)?;
    for note in input_check::check(&rig, &recordings).map_err(Failure::input)? {
        eprintln!("note: {note}");
    }
    if matches!(rig.model, Machine::Sdof(_)) {
        return sdof(args, &rig, &recordings);
    }
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
    let document = || report::calibrate::document(&rig, &calibration, &recordings, args.seed).map_err(Failure::other);
    tell(args, &calibration.rig, &calibration, &lines(&calibration), document)
}

fn sdof(args: &Args, rig: &Rig, recordings: &[Recording]) -> Result<(), Failure> {
    if args.path == Path::AllPole {
        return Err(Failure::option("path", "all-pole", "auto or none for a rig of kind \"sdof\""));
    }
    let spinner = super::input::spinner();
    spinner.set_message("fitting force balance and simulation");
    let calibration = calibrate_sdof(rig, recordings);
    spinner.finish_and_clear();
    let calibration = calibration.map_err(Failure::input)?;
    let document = || report::calibrate_sdof::document(&calibration, recordings).map_err(Failure::other);
    tell(args, &calibration.rig, &calibration, &sdof_lines(&calibration), document)
}

/// Writes the calibrated rig and the report, and prints the calibration, as JSON or in lines.
fn tell(
    args: &Args,
    rig: &Rig,
    calibration: &impl Serialize,
    lines: &[String],
    document: impl FnOnce() -> Result<Document, Failure>,
) -> Result<(), Failure> {
    rig.write(&args.out).map_err(Failure::other)?;
    if let Some(path) = &args.report {
        write(path, document()?.html().as_bytes())?;
    }
    if args.json {
        return json(calibration);
    }
    for text in lines {
        line(text)?;
    }
    line(format_args!("wrote {}", args.out.display()))
}

fn sdof_lines(calibration: &force_balance::SdofCalibration) -> Vec<String> {
    let mut out = vec![format!("{:<32} {:>12} {:>12}   95 % interval", "parameter", "before", "calibrated")];
    for e in &calibration.estimates {
        let [name, before, value, interval] = NamedUnit::new(&e.key, e.value).row(e.guess, e.value, e.interval95);
        out.push(format!("{name:<32} {before:>12} {value:>12}   {interval}"));
    }
    out.push(report::calibrate_sdof::method(calibration).into());
    out.extend(calibration.undetermined.iter().map(|sentence| format!("undetermined: {sentence}")));
    match &calibration.held_out {
        None => out.push("held out: none, the recordings are too short".into()),
        Some(h) => {
            out.push(format!("held out: {}", h.recordings));
            out.push(format!(
                "  force balance: before {} N, after {} N",
                significant(h.balance_before_n, 3),
                significant(h.balance_after_n, 3)
            ));
            let number = |v: Option<f64>| v.map_or("diverges".into(), |v| significant(v, 3));
            out.push(format!(
                "  simulation over {} s: before {}, after {}, sensor noise {}",
                significant(h.window_s, 2),
                number(h.simulation_before),
                number(h.simulation_after),
                significant(calibration.sensor_noise_std, 2)
            ));
        }
    }
    out
}

fn lines(calibration: &Calibration) -> Vec<String> {
    let mut out = Vec::new();
    if !calibration.parameters.is_empty() {
        out.push(format!("{:<42} {:>12} {:>12}   95 % interval", "parameter", "before", "calibrated"));
    }
    for p in &calibration.parameters {
        let note = if p.determined { "" } else { "   not determined" };
        let [name, before, value, interval] =
            NamedUnit::new(&p.key.to_string(), p.value).row(p.before, p.value, p.interval95);
        out.push(format!("{name:<42} {before:>12} {value:>12}   {interval}{note}"));
    }
    for (channel, poles) in &calibration.path_poles {
        out.push(format!("{channel}: transfer path of {poles} poles"));
    }
    for free in &calibration.undetermined {
        out.push(format!("the recordings do not determine {}", free.free));
    }
    for e in &calibration.explained {
        out.push(format!(
            "{}: {} of the power is deterministic; the residual is within {:.2} dB of the rig's noise",
            e.channel,
            share(e.deterministic),
            e.residual_db
        ));
    }
    if !calibration.converged {
        out.push("the search ended before it converged".into());
    }
    out.push(format!("held out: {}; log-spectral distance, dB", calibration.held_out_recordings));
    for h in &calibration.held_out {
        out.push(format!(
            "  {} {}: before {:.2}, after {:.2}, noise floor {:.2}",
            h.recording, h.channel, h.before_db, h.after_db, h.floor_db
        ));
    }
    out
}
