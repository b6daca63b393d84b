//! Command `ballrace diagnose`.

use std::path::PathBuf;

use super::output::{Force, Outputs};
use super::{Failure, json, line};
use crate::diagnose::result::{Cause, DiagnosisResult, Parameter};
use crate::diagnose::write::{Document, files, held_out_files};
use crate::diagnose::{Task, diagnose};
use crate::recording::load_all;
use crate::report;
use crate::report::diagnosis::percent;
use crate::report::held_out::errors;
use crate::rig::Rig;
use crate::stats::format::{by_chance, significant};
use crate::stats::units::{NamedUnit, in_words};

/// Find what a simulation lacks: the cause, its parameters and its location
///
/// Fits the causes of a vocabulary (friction, clearance, a race defect, a resonance, a wrong sensor
/// gain, ...) to the residual of a rig and selects among them. A cause is named only if it improves
/// the fit to held-out recordings beyond chance. Recordings for an sdof rig have channels `u` and `q`
/// (or `qdd`).
///
/// OUT then holds diagnosis.json, rig.corrected.toml (which `simulate` and `predict` take), report.html,
/// and heldout/*.csv with the measurement and the simulation by either rig.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Example:\n  ballrace diagnose --rig rig.toml --recordings data --out diagnosis\n  then open diagnosis/report.html"
)]
pub struct Args {
    /// Rig as known; `unknown = [...]` lists parameters that are only guessed
    #[arg(long, value_name = "rig.toml")]
    rig: PathBuf,
    /// Recordings of the healthy machine, which unknown parameters are fitted to
    #[arg(long, value_name = "DIR")]
    baseline: Option<PathBuf>,
    /// Recordings to diagnose
    #[arg(long, value_name = "DIR")]
    recordings: PathBuf,
    /// Folder to write to
    #[arg(long, value_name = "OUT")]
    out: PathBuf,
    /// Seed of simulations and permutations
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    force: Force,
    /// Print diagnosis.json
    #[arg(long)]
    json: bool,
}

/// Runs `diagnose`.
pub fn run(args: &Args) -> Result<(), Failure> {
    let read: Vec<PathBuf> = [&args.recordings].into_iter().chain(&args.baseline).cloned().collect();
    let outputs = Outputs::new(args.force, [&args.rig]).beside(&read);
    outputs.folder("out", &args.out, &[])?;
    let rig = Rig::read(&args.rig).map_err(Failure::input)?;
    let read = |path: &PathBuf| load_all(path).map_err(Failure::input);
    let recordings = read(&args.recordings)?;
    let baseline = args.baseline.as_ref().map(read).transpose()?;
    outputs.diagnosis("out", &args.out, &files(&args.out), &held_out_files(&args.out, &recordings))?;
    let task = Task { rig: &rig, baseline: baseline.as_deref(), recordings: &recordings, seed: args.seed };
    let spinner = super::input::spinner();
    let progress = |what: &str| spinner.set_message(what.to_owned());
    let outcome = diagnose(&task, &progress);
    spinner.finish_and_clear();
    let outcome = outcome.map_err(Failure::input)?;
    report::diagnosis::folder(&args.out, &task, &outcome).map_err(Failure::other)?;
    if args.json {
        return json(&Document::from_result(&outcome));
    }
    for text in lines(&outcome) {
        line(text)?;
    }
    line(format_args!("wrote {}; the report is {}", args.out.display(), args.out.join("report.html").display()))
}

fn lines(outcome: &DiagnosisResult) -> Vec<String> {
    let diagnosis = &outcome.diagnosis;
    let mut out = vec![report::diagnosis::verdict(outcome).1];
    for cause in &diagnosis.causes {
        out.extend(cause_lines(cause));
    }
    let fit = &diagnosis.fit;
    out.push(format!(
        "held out: {}\n  {}: before {}, after {}, noise floor {}, {}",
        fit.held_out,
        fit.metric,
        significant(fit.before, 4),
        significant(fit.after, 4),
        significant(fit.noise_floor, 4),
        by_chance(fit.p_value)
    ));
    for held in &outcome.held_out {
        let [before, after] = errors(held).map(|v| significant(v, 3));
        out.push(format!("  {}: measured minus simulated, RMS, before {before}, after {after}", held.name));
    }
    if !diagnosis.location.state.is_empty() {
        out.push(format!("where: {}", diagnosis.location.state));
    }
    for (name, value, interval) in &outcome.fitted {
        out.push(format!("fitted jointly: {}", with_range(name, *value, Some(*interval))));
    }
    out.extend(outcome.caveats.iter().map(|caveat| format!("note: {caveat}")));
    out
}

fn cause_lines(cause: &Cause) -> Vec<String> {
    let mut out = vec![format!("{}, probability {}", cause.name, percent(cause.probability))];
    if !cause.equation.is_empty() {
        out.push(format!("  {}", cause.equation));
    }
    for (name, value) in &cause.parameters {
        out.push(match value {
            Parameter::Number(v) => {
                format!("  {}", with_range(cause.key_with_unit(name), *v, cause.interval95.get(name).copied()))
            }
            Parameter::Name(text) => format!("  {name} {text}"),
        });
    }
    out.push(format!("  {}", cause.evidence));
    out
}

/// Parameter in words with its 95 % interval: `depth 2.6 µm (95 %: 2.4 to 2.8)`.
fn with_range(name: &str, value: f64, interval95: Option<[f64; 2]>) -> String {
    let range = interval95.map(|_| format!(" (95 %: {})", NamedUnit::new(name, value).texts(value, interval95).1));
    format!("{}{}", in_words(name, value, interval95), range.unwrap_or_default())
}
