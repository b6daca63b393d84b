//! Command `ballrace fleet`.

use std::path::PathBuf;

use serde_json::json;

use super::output::{Force, Outputs};
use super::{Failure, line, write};
use crate::fleet::machines::{Machine, machines};
use crate::fleet::store::Store;
use crate::report;
use crate::stats::format::significant;

/// Sum up the machines that `collect` has heard, worst first
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  ballrace fleet fleet.sqlite --diagnoses diagnoses --report fleet.html\n  \
    writes a page of all machines: status, trend, last verdict, what to look at next")]
pub struct Args {
    /// SQLite file of `collect`
    file: PathBuf,
    /// Write a page of all machines
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Folder with the machines' diagnoses, DIR/MACHINE/diagnosis.json
    #[arg(long, value_name = "DIR")]
    diagnoses: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print the machines as one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs `fleet`.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut outputs = Outputs::new(args.force, [&args.file]);
    args.report.iter().try_for_each(|path| outputs.file("report", path))?;
    if let Some(folder) = args.diagnoses.as_ref().filter(|folder| !folder.is_dir()) {
        return Err(Failure::option("diagnoses", folder.display(), "a folder"));
    }
    let store = Store::read(&args.file).map_err(Failure::input)?;
    let counts = store.counts().map_err(Failure::other)?;
    let machines = machines(&store, args.diagnoses.as_deref()).map_err(Failure::other)?;
    if let Some(path) = &args.report {
        let page = report::fleet::document(&machines, &counts).map_err(Failure::other)?;
        write(path, page.html().as_bytes())?;
    }
    if args.json {
        return super::json(&json!({ "schema": "ballrace-fleet/1", "machines": machines, "counts": counts }));
    }
    machines.iter().try_for_each(|machine| line(text(machine)))
}

fn text(machine: &Machine) -> String {
    let Machine { machine: name, status, share_of_limit, last_heard, look_at, .. } = machine;
    format!(
        "{name}: {status}, EWMA at {} of its limit, heard {last_heard} UTC; {look_at}",
        significant(*share_of_limit, 3)
    )
}
