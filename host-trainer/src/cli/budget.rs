//! Command `ballrace budget`.

use std::path::{Path, PathBuf};

use ballrace_core::model::Input;
use clap::ValueEnum;
use serde::Serialize;

use super::output::{Force, Outputs};
use super::{Failure, json, line, write};
use crate::model::OwnedModel;
use crate::model::budget::{self, Budget, BudgetConfig, Functions, Target};
use crate::model::file;
use crate::report::plot::frontier::{self, Point};

/// Predict a model's flash, RAM, stack, and cycles by stage on a microcontroller
///
/// From the model's sizes alone, by costs fitted to traces of the device's code; no emulator is needed.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Example:\n  ballrace budget --model model.bin --target cortex-m4f --clock-hz 168e6 --wait-states 5\n  \
    says which share of the time between two samples an STM32F4 at 168 MHz needs, and for what\n  \
    ballrace budget --model f32_256.json fixed_24.json --plot frontier.svg\n  \
    puts scores beside cycles, flash and RAM\n\n\
    Cycles are those of the Cortex-M4's manual for each instruction; `worst` is the most expensive sample"
)]
pub struct Args {
    /// Model written by `fit`, or its binary or JSON form written by `export`; several, written by `fit`, give a table with their
    /// scores
    #[arg(long, required = true, num_args = 1..)]
    model: Vec<PathBuf>,
    /// Write a picture of the scores of several models against their cycles
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    device: DeviceArgs,
    /// Clock of the processor, Hz
    #[arg(long, default_value_t = 168e6, value_name = "HZ")]
    clock_hz: f64,
    #[command(flatten)]
    force: Force,
    /// Print the budget as one JSON document
    #[arg(long)]
    json: bool,
}

/// Arguments that say which device is meant.
#[derive(clap::Args, Debug)]
pub struct DeviceArgs {
    /// Microcontroller
    #[arg(long, value_enum, default_value = "cortex-m4f")]
    target: TargetName,
    /// Wait states of its flash, behind caches of 64 lines of code and 8 of constants, 16 bytes each
    #[arg(long, default_value_t = 0, value_name = "N")]
    wait_states: u32,
    /// The device is built with the faster functions of the feature `approx`
    #[arg(long)]
    approx: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum TargetName {
    #[value(name = "cortex-m4f")]
    CortexM4f,
}

impl DeviceArgs {
    /// What is asked of the budget.
    pub fn config(&self) -> BudgetConfig {
        let target = match self.target {
            TargetName::CortexM4f => Target::CortexM4f,
        };
        let functions = if self.approx { Functions::Approx } else { Functions::Exact };
        BudgetConfig { target, functions, wait_states: self.wait_states }
    }
}

/// A budget with the time between two samples.
#[derive(Serialize)]
struct Document<'a> {
    #[serde(flatten)]
    budget: &'a Budget,
    clock_hz: f64,
    sample_rate_hz: f64,
    /// Cycles between two samples.
    period_cycles: f64,
    /// Share of the period that an evaluated sample takes, mean.
    share: f64,
    /// Share of the period that the most expensive sample takes.
    worst_share: f64,
}

/// Runs `budget`.
pub fn run(args: &Args) -> Result<(), Failure> {
    let clock_hz = args.clock_hz;
    if !(clock_hz.is_finite() && clock_hz > 0.0) {
        return Err(Failure::option("clock-hz", clock_hz, "a positive frequency"));
    }
    let [path] = &args.model[..] else { return several(args) };
    if args.plot.is_some() {
        return Err(Failure::option("plot", "one model", "several"));
    }
    let (model, _) = file::read(path).map_err(Failure::input)?;
    let (budget, sample_rate_hz) = budget_of(path, &model, args)?;
    let period_cycles = Budget::period_cycles(clock_hz, sample_rate_hz);
    let (share, worst_share) = (budget.cycles / period_cycles, budget.worst_cycles / period_cycles);
    if args.json {
        return json(&Document { budget: &budget, clock_hz, sample_rate_hz, period_cycles, share, worst_share });
    }
    let functions = match budget.config.functions {
        Functions::Exact => "exact",
        Functions::Approx => "approximate",
    };
    line(format_args!("predicted for cortex-m4f, {functions} functions, {} wait states", budget.config.wait_states))?;
    let code = budget.flash_bytes - budget.model_bytes;
    line(format_args!(
        "  flash      {:>8} bytes ({} model, {code} code and constants)",
        budget.flash_bytes, budget.model_bytes
    ))?;
    line(format_args!("  static RAM {:>8} bytes", budget.static_bytes))?;
    line(format_args!("  stack      {:>8} bytes", budget.stack_bytes))?;
    line("  a sample     instructions    cycles     worst")?;
    for stage in &budget.stages {
        let name = stage.stage.name();
        line(format_args!(
            "  {name:12} {:>12.0} {:>9.0} {:>9.0}",
            stage.instructions, stage.cycles, stage.worst_cycles
        ))?;
    }
    line(format_args!(
        "  {:12} {:>12.0} {:>9.0} {:>9.0}",
        "total", budget.instructions, budget.cycles, budget.worst_cycles
    ))?;
    line(format_args!(
        "  {:.1} % of the {period_cycles:.0} cycles between two samples at {} MHz and {sample_rate_hz} Hz, at worst {:.1} %",
        100.0 * share,
        clock_hz / 1e6,
        100.0 * worst_share
    ))
}

/// Budget of a model, and its sample rate, Hz.
fn budget_of(path: &Path, model: &OwnedModel, args: &Args) -> Result<(Budget, f64), Failure> {
    let view = model.view();
    if let Input::Direct(_) = view.input {
        let path = path.display();
        return Err(Failure::Input(format!("{path}: the model takes states, expected one that takes samples")));
    }
    Ok((budget::budget(&view, args.device.config()), f64::from(view.sample_rate_hz)))
}

/// A model among several.
#[derive(Serialize)]
struct Row {
    model: String,
    /// Mean R² of the derivatives, held out.
    held_out: f64,
    /// R² of the next sample.
    next_sample: Option<f64>,
    #[serde(flatten)]
    budget: Budget,
}

/// Table, and picture, of several models.
fn several(args: &Args) -> Result<(), Failure> {
    if let Some(path) = &args.plot {
        Outputs::new(args.force, &args.model).file("plot", path)?;
    }
    let (mut rows, mut rates) = (Vec::new(), Vec::new());
    for path in &args.model {
        let (model, report) = file::read(path).map_err(Failure::input)?;
        let report = report.ok_or_else(|| {
            Failure::Input(format!("{}: found a model without scores, expected one written by `fit`", path.display()))
        })?;
        let (budget, rate) = budget_of(path, &model, args)?;
        if let Some(first) = rates.first().filter(|first| **first != rate && args.plot.is_some()) {
            let path = path.display();
            return Err(Failure::Input(format!("--plot: found {path} of {rate} Hz, expected {first} Hz as the first")));
        }
        rates.push(rate);
        rows.push(Row {
            model: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            held_out: report.scores.held_out.mean(),
            next_sample: report.scores.causal.next_sample,
            budget,
        });
    }
    if let Some(path) = &args.plot {
        let points: Vec<Point> = rows
            .iter()
            .map(|row| Point {
                name: row.model.clone(),
                cycles: row.budget.worst_cycles,
                held_out: row.held_out,
                next_sample: row.next_sample,
            })
            .collect();
        let period_cycles = Budget::period_cycles(args.clock_hz, rates[0]);
        write(path, frontier::svg(&points, period_cycles).map_err(Failure::other)?.as_bytes())?;
    }
    if args.json {
        return json(&rows);
    }
    line("| model | R² held out | R² next sample | cycles | worst | flash, bytes | RAM with stack, bytes |")?;
    line("|---|---|---|---|---|---|---|")?;
    for Row { model, held_out, next_sample, budget: b } in &rows {
        let next = next_sample.map_or("–".into(), |score| format!("{score:.4}"));
        let ram = b.static_bytes + b.stack_bytes;
        line(format_args!(
            "| {model} | {held_out:.4} | {next} | {:.0} | {:.0} | {} | {ram} |",
            b.cycles, b.worst_cycles, b.flash_bytes
        ))?;
    }
    Ok(())
}
