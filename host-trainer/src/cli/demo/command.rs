//! Command `ballrace demo`.

use std::path::PathBuf;

use crate::cli::demo::{self, Config};
use crate::cli::input::bar;
use crate::cli::output::{Force, Outputs};
use crate::cli::{Failure, json, line};

/// Simulate a machine that differs from its rig, diagnose it, and correct the model on the device
///
/// From some recording on the machine has a vibration mode that its nominal rig lacks; the diagnosis
/// does not know it. A model of the nominal rig is fitted and exported; the device's own code runs it
/// over the recordings and raises an alarm; some of them are diagnosed; a model of the corrected rig,
/// with the cause's terms in its library, is fitted and exported, and the device's residual falls.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  ballrace demo --out demo\n  then open demo/report.html")]
pub struct Args {
    /// Output folder
    #[arg(long)]
    out: PathBuf,
    /// Seed of everything random
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print the results as one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs `demo`.
pub fn run(args: &Args) -> Result<(), Failure> {
    Outputs::new(Force::default(), []).folder("out", &args.out, &[])?;
    let bar = bar("demo");
    let outcome = demo::run(&Config::new(args.seed), &args.out, &|stage, share| {
        bar.set_message(stage.to_owned());
        bar.set_position((100.0 * share) as u64);
    });
    bar.finish_and_clear();
    let outcome = outcome.map_err(Failure::other)?;
    if args.json {
        return json(&outcome);
    }
    line(outcome.text())?;
    line(format_args!("report: {}", args.out.join("report.html").display()))
}
