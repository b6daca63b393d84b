//! Command line: each command parses its arguments, calls the library and prints the result.

mod bearings;
#[cfg(feature = "fleet")]
mod broker;
mod budget;
mod calibrate;
#[cfg(feature = "fleet")]
mod collect;
mod completions;
mod demo;
mod diagnose;
mod evaluate;
mod export;
mod features;
mod fit;
#[cfg(feature = "fleet")]
mod fleet;
mod init;
mod input;
mod interrupt;
mod library;
mod man;
mod monitor;
mod output;
mod phases;
#[cfg(feature = "fleet")]
mod publish;
mod settings;
mod simulate;
mod spectra;
mod sweep;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// From a vibration recording to a sparse dynamics model on a microcontroller.
#[derive(Parser)]
#[command(name = "ballrace", version, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Init(init::Args),
    Demo(demo::command::Args),
    Fit(Box<fit::Args>),
    Export(export::Args),
    Budget(budget::Args),
    Features(features::Args),
    Library(library::Args),
    Monitor(monitor::Args),
    #[cfg(feature = "fleet")]
    Collect(collect::Args),
    #[cfg(feature = "fleet")]
    Fleet(fleet::Args),
    Phases(phases::Args),
    Simulate(simulate::SimulateArgs),
    Predict(simulate::PredictArgs),
    Calibrate(calibrate::Args),
    Diagnose(diagnose::Args),
    // The name of before.
    #[command(alias = "prove")]
    Evaluate(evaluate::Args),
    Spectra(spectra::Args),
    Sweep(sweep::Args),
    Completions(completions::Args),
    Man(man::Args),
}

/// Failure of a command, with its exit status.
#[derive(Debug)]
pub enum Failure {
    /// Bad usage or bad input: exit status 2.
    Input(String),
    /// Anything else: exit status 1.
    Other(String),
}

impl Failure {
    /// Failure by bad input, with the text of an error.
    pub fn input(error: impl std::fmt::Display) -> Self {
        Self::Input(error.to_string())
    }

    /// Failure by the value of an option.
    pub fn option(option: &str, found: impl std::fmt::Display, expected: impl std::fmt::Display) -> Self {
        Self::Input(format!("--{option}: found {found}, expected {expected}"))
    }

    /// Failure of any other kind, with the text of an error.
    pub fn other(error: impl std::fmt::Display) -> Self {
        Self::Other(error.to_string())
    }
}

/// Runs the command given by the arguments of the process.
pub fn run() -> ExitCode {
    let command = Cli::parse().command;
    match command {
        Command::Evaluate(_) | Command::Sweep(_) => interrupt::announce(interrupt::Again::Resumes),
        Command::Fit(_) | Command::Diagnose(_) => interrupt::announce(interrupt::Again::BeginsAnew),
        _ => {}
    }
    let result = match command {
        Command::Init(args) => init::run(&args),
        Command::Demo(args) => demo::command::run(&args),
        Command::Fit(args) => fit::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Budget(args) => budget::run(&args),
        Command::Features(args) => features::run(&args),
        Command::Library(args) => library::run(&args),
        Command::Monitor(args) => monitor::run(&args),
        #[cfg(feature = "fleet")]
        Command::Collect(args) => collect::run(&args),
        #[cfg(feature = "fleet")]
        Command::Fleet(args) => fleet::run(&args),
        Command::Phases(args) => phases::run(&args),
        Command::Simulate(args) => simulate::simulate(&args),
        Command::Predict(args) => simulate::predict(&args),
        Command::Calibrate(args) => calibrate::run(&args),
        Command::Diagnose(args) => diagnose::run(&args),
        Command::Evaluate(args) => evaluate::run(&args),
        Command::Spectra(args) => spectra::run(&args),
        Command::Sweep(args) => sweep::run(&args),
        Command::Completions(args) => completions::run(&args),
        Command::Man(args) => man::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Input(message)) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
        Err(Failure::Other(message)) => {
            eprintln!("error: {message}");
            ExitCode::from(1)
        }
    }
}

/// Prints a line on stdout. A closed pipe (`| head`) ends the process without an error.
pub(crate) fn line(text: impl std::fmt::Display) -> Result<(), Failure> {
    use std::io::Write;
    match writeln!(std::io::stdout(), "{text}") {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => std::process::exit(0),
        other => other.map_err(Failure::other),
    }
}

/// Prints one JSON document on stdout.
pub(crate) fn json(value: &impl serde::Serialize) -> Result<(), Failure> {
    line(serde_json::to_string_pretty(value).map_err(Failure::other)?)
}

/// Writes a file completely or not at all.
pub(crate) fn write(path: &std::path::Path, bytes: &[u8]) -> Result<(), Failure> {
    crate::recording::atomic_write::write_atomically(path, bytes)
        .map_err(|e| Failure::Other(format!("{}: {e}", path.display())))
}
