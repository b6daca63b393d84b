//! `ballrace demo`.

use std::path::PathBuf;

use super::Failure;

/// Make recordings, fit, export, run the device on them, and write a report
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:\n  ballrace demo --out demo\n  then open demo/report.html")]
pub struct Args {
    /// Folder for everything that is made
    #[arg(long)]
    out: PathBuf,
    /// Seed of everything random
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print the results as one JSON document
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(_: &Args) -> Result<(), Failure> {
    Err(Failure::Other("to come".into()))
}
