//! Command `ballrace budget`.

use std::path::PathBuf;

use ballrace_core::model::Input;
use clap::ValueEnum;
use serde::Serialize;

use super::{Failure, json, line};
use crate::model::budget::{self, Budget, BudgetConfig, Functions, Target};
use crate::model::file;

/// Predict a model's flash, RAM, stack, and cycles by stage on a microcontroller
///
/// From the model's sizes alone, by costs fitted to traces of the device's code; no emulator is needed.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Example:\n  ballrace budget --model model.bin --target cortex-m4f --clock-hz 168e6 --wait-states 5\n  \
    says which share of the time between two samples an STM32F4 at 168 MHz needs, and for what\n\n\
    Cycles are those of the Cortex-M4's manual for each instruction; `worst` is the most expensive sample"
)]
pub struct Args {
    /// Model written by `fit`, or its binary or JSON form written by `export`
    #[arg(long)]
    model: PathBuf,
    #[command(flatten)]
    device: DeviceArgs,
    /// Clock of the processor, Hz
    #[arg(long, default_value_t = 168e6, value_name = "HZ")]
    clock_hz: f64,
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
        return Err(Failure::Input(format!("--clock-hz: found {clock_hz}, expected a positive frequency")));
    }
    let (model, _) = file::read(&args.model).map_err(Failure::input)?;
    let view = model.view();
    if let Input::Direct(_) = view.input {
        let path = args.model.display();
        return Err(Failure::Input(format!("{path}: the model takes states, expected one that takes samples")));
    }
    let budget = budget::budget(&view, args.device.config());
    let sample_rate_hz = f64::from(view.sample_rate_hz);
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
