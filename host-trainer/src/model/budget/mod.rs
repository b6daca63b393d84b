//! Budget of a model on a microcontroller, predicted from its sizes without an emulator: flash, RAM, stack, and cycles a
//! sample by stage.
//!
//! The cost of a sample is linear in the work it does, theory (9) to (12): [`work()`] counts it (steps of panels, sigmoids,
//! terms, coefficients, …), [`settings`] has the cost of each, fitted to traces of the bare-metal image on models of many
//! sizes (`firmware-sim/cycles/budget.sh`) and checked on others.

pub mod settings;
pub mod within;
pub mod work;

use ballrace_core::device::Device;
use ballrace_core::model::{Input, Model};
use ballrace_core::states::Estimator;
use serde::Serialize;

use crate::model::export::BreaksLimit;
use settings::{COSTS, Memory};
pub use work::{Stage, Work, work};

/// Microcontroller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Target {
    /// Cortex-M4 with the single-precision floating-point unit.
    #[default]
    CortexM4f,
}

/// Functions of `ballrace_core::math` that the device is built with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Functions {
    /// Those of the host, to the bit.
    #[default]
    Exact,
    /// The faster ones of the feature `approx`.
    Approx,
}

/// What a budget is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BudgetConfig {
    /// Microcontroller.
    pub target: Target,
    /// Functions the device is built with.
    pub functions: Functions,
    /// Wait states of the flash, behind caches of 64 lines of code and 8 of constants, 16 bytes each.
    pub wait_states: u32,
}

/// Cost of one unit of work, and of sums of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    /// Instructions of a sample that the model is evaluated for, mean.
    pub instructions: f64,
    /// Cycles of such a sample, mean, without wait states.
    pub cycles: f64,
    /// Cycles of the most expensive sample, without wait states.
    pub worst_cycles: f64,
    /// Lines of flash waited for.
    pub flash_lines: f64,
}

impl Cost {
    /// Cost of a unit from its four numbers, in the order of the fields.
    pub const fn new([instructions, cycles, worst_cycles, flash_lines]: [f64; 4]) -> Self {
        Self { instructions, cycles, worst_cycles, flash_lines }
    }

    fn add(&mut self, unit: &Self, count: f64) {
        self.instructions += count * unit.instructions;
        self.cycles += count * unit.cycles;
        self.worst_cycles += count * unit.worst_cycles;
        self.flash_lines += count * unit.flash_lines;
    }
}

/// Cycles of a stage of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StageBudget {
    /// Stage.
    pub stage: Stage,
    /// Instructions, mean of the evaluated samples.
    pub instructions: f64,
    /// Cycles with the wait states, mean of the evaluated samples.
    pub cycles: f64,
    /// Cycles with the wait states in the most expensive sample.
    pub worst_cycles: f64,
}

/// Memory and time of a model on a microcontroller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Budget {
    /// What was asked for.
    #[serde(flatten)]
    pub config: BudgetConfig,
    /// Flash of the device's code, its constants and the model, bytes.
    pub flash_bytes: usize,
    /// Of which the model, bytes.
    pub model_bytes: usize,
    /// Static RAM, bytes.
    pub static_bytes: usize,
    /// Most stack in use, bytes.
    pub stack_bytes: usize,
    /// Cost by stage, in the order of a sample.
    pub stages: Vec<StageBudget>,
    /// Instructions of an evaluated sample, mean.
    pub instructions: f64,
    /// Cycles of an evaluated sample, mean.
    pub cycles: f64,
    /// Cycles of the most expensive sample.
    pub worst_cycles: f64,
}

impl Budget {
    /// Cycles between two samples at a clock and a sample rate, both in Hz.
    pub fn period_cycles(clock_hz: f64, sample_rate_hz: f64) -> f64 {
        clock_hz / sample_rate_hz
    }

    /// Checks that the most expensive sample takes no more than so many cycles.
    ///
    /// # Errors
    /// [`BreaksLimit`] with the cycles predicted.
    pub fn check_cycles(&self, most: usize) -> Result<(), BreaksLimit> {
        let found = self.worst_cycles.ceil() as usize;
        if found > most {
            return Err(BreaksLimit { limit: "cycle", found, most, unit: "cycles a sample" });
        }
        Ok(())
    }
}

/// Budget of a model.
pub fn budget(model: &Model<'_>, config: BudgetConfig) -> Budget {
    let counts = work(model);
    let stages: Vec<_> = Stage::ALL
        .into_iter()
        .map(|stage| {
            let mut sum = Cost::default();
            for (work, count) in counts.iter().filter(|(work, _)| work.stage() == stage) {
                sum.add(&unit(*work, config.functions), *count);
            }
            let waiting = f64::from(config.wait_states) * sum.flash_lines;
            let (cycles, worst_cycles) = (sum.cycles + waiting, sum.worst_cycles.max(sum.cycles) + waiting);
            StageBudget { stage, instructions: sum.instructions, cycles, worst_cycles }
        })
        .collect();
    let total = |of: fn(&StageBudget) -> f64| stages.iter().map(of).sum();
    let memory = Memory::of(config.functions);
    let estimator = match model.input {
        Input::VirtualStates(spec) => spec.estimator,
        Input::Direct(_) => Estimator::Differences,
    };
    let stack_bytes = match estimator {
        Estimator::Differences => memory.stack_differences,
        Estimator::Kalman { .. } => memory.stack_kalman,
        Estimator::SavitzkyGolay { .. } => memory.stack_windows,
    };
    Budget {
        config,
        flash_bytes: memory.code_bytes + model.byte_len(),
        model_bytes: model.byte_len(),
        static_bytes: memory.static_bytes + size_of::<f32>() * Device::scratch_len(model),
        stack_bytes,
        instructions: total(|s| s.instructions),
        cycles: total(|s| s.cycles),
        worst_cycles: total(|s| s.worst_cycles),
        stages,
    }
}

/// Cost of a unit of work; nothing for one without a measured cost, which a test excludes.
fn unit(work: Work, functions: Functions) -> Cost {
    let row = COSTS.iter().find(|row| row.work == work);
    row.map_or(Cost::default(), |row| match functions {
        Functions::Exact => Cost::new(row.exact),
        Functions::Approx => Cost::new(row.approx),
    })
}

#[cfg(test)]
mod tests;
