//! Command `ballrace demo`.

use std::path::PathBuf;

use crate::cli::demo::job::RIG;
use crate::cli::demo::{self, Config, generator};
use crate::cli::input::bar;
use crate::cli::output::{Force, Outputs};
use crate::cli::{Failure, json, line};
use crate::recording::write::files;

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
    let outputs = Outputs::new(Force::default(), []);
    let (config, recordings) = (Config::new(args.seed), args.out.join("recordings"));
    outputs.folder("out", &args.out, &[])?;
    outputs.recordings("out", &recordings, &files(&recordings, config.scenario.recordings))?;
    let rig = args.out.join(RIG);
    if std::fs::read(&rig).is_ok_and(|text| text != generator::RIG.as_bytes()) {
        let rig = rig.display();
        return Err(Failure::Input(format!(
            "--out: found {rig}, which is not the demo's, expected a folder of its own"
        )));
    }
    let bar = bar("demo");
    let outcome = demo::run(&config, &args.out, &|stage, share| {
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
