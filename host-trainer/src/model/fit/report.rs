//! Report of a fit; part of the model file.

use ballrace_core::network::Arithmetic;
use serde::{Deserialize, Serialize};

use super::choice;
use super::limits::Limit;
use super::score::Scores;
use super::single_fit::{SingleFit, Split};
use super::terms::Entered;
use super::verdict::Verdict;
use super::{FitConfig, Solver};
use crate::model::path::PathPoint;
use crate::model::stlsq::Diagnosis;

/// Program and version that writes a report.
pub const CREATED_BY: &str = concat!("ballrace ", env!("CARGO_PKG_VERSION"));

/// Report of a fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Program and version.
    pub created_by: String,
    /// Recordings, states and library of the fit.
    pub training: Training,
    /// The four scores.
    pub scores: Scores,
    /// Verdict on the scores.
    pub verdict: Verdict,
    /// Sparse equations.
    pub equations: Vec<EquationReport>,
    /// Number of nonzero coefficients.
    pub terms_kept: usize,
    /// Mean number of coefficients an equation keeps under the null: for least squares on targets
    /// unrelated to the states, for SINDy-NN on the surrogates; `None` without surrogates.
    pub terms_noise_would_keep: Option<f64>,
    /// Models on the path from all terms to few: the Pareto front.
    #[serde(default)]
    pub path: Vec<PathPoint>,
    /// Conditioning of the library.
    pub diagnosis: Diagnosis,
    /// Healthy level of the residual.
    pub monitor: MonitorReport,
}

/// Recordings, states and library of a fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Training {
    /// Recordings fitted to.
    pub recordings: Vec<String>,
    /// Recordings that choose thresholds, the early stop, and one of several trainings.
    #[serde(default)]
    pub validation: Vec<String>,
    /// Recordings held out.
    pub held_out: Vec<String>,
    /// Whether validation and held-out part are the end of the only recording.
    pub within_recording: bool,
    /// Channel, if recordings have several.
    #[serde(default)]
    pub channel: Option<String>,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Smallest and largest sample of the recordings fitted to, m/s².
    pub range_m_per_s2: (f32, f32),
    /// Name of the solver.
    pub solver: String,
    /// Alignment and orders of the states, in words.
    pub states: String,
    /// Number of terms of the library.
    pub functions: usize,
    /// Names of the library's terms, in order.
    pub terms: Vec<String>,
    /// Terms and states that causes of a diagnosis added.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub entered: Vec<Entered>,
    /// Gradient steps; `None` for least squares.
    pub steps: Option<usize>,
    /// Whether the validation loss ended the training early; `None` for least squares.
    pub stopped_early: Option<bool>,
    /// Seed of the fit.
    pub seed: u64,
}

/// One equation of the sparse dynamics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EquationReport {
    /// Left side of the equation.
    pub name: String,
    /// R² on held-out recordings; `None` for latent equations, which have no measured left side.
    pub r_squared_held_out: Option<f64>,
    /// Threshold: for least squares the share of the target's variance, for SINDy-NN that of the power of ẋ, that a term must be
    /// worth.
    pub threshold: f64,
    /// Kept terms, the greatest share first.
    pub terms: Vec<TermReport>,
}

/// One term of an equation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TermReport {
    /// Name in scaled variables.
    pub name: String,
    /// Index in the library.
    pub index: usize,
    /// Coefficient in scaled variables.
    pub coefficient: f64,
    /// Coefficient in physical units: derivative in m/s² per sample, variables as centred differences in m/s² (the
    /// argument of sin and cos stays scaled); `None` for latent variables.
    pub physical: Option<f64>,
    /// Share of the explained power by orthogonal least squares, theory (21); the shares of an equation add up to 1.
    pub share: f64,
}

/// Healthy level of the residual, and the limit with what it rests on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MonitorReport {
    /// Samples in a block.
    pub block: u32,
    /// Number of healthy blocks.
    pub healthy_blocks: usize,
    /// Number of them that the model was not fitted to.
    pub held_out_blocks: usize,
    /// Mean squared normalised residual of a healthy block, by the mean of its logarithm.
    pub healthy_mean: f64,
    /// Standard deviation of that logarithm from block to block without its drift, theory (86).
    pub healthy_spread: f64,
    /// How far the logarithms of held-out blocks are above the others, which were raised by so much.
    pub held_out_shift: f64,
    /// False alarms a day for which the limit is set.
    pub false_alarms_per_day: f64,
    /// Blocks that a day holds.
    pub blocks_per_day: f64,
    /// Limit of the statistic.
    pub limit: Limit,
}

impl MonitorReport {
    /// What the limit is and rests on, in words.
    pub fn basis(&self) -> String {
        let l = &self.limit;
        let beyond = match (l.extrapolated, l.asked_log_power > l.log_power) {
            (true, true) => format!(
                "held where no drift of a healthy machine goes (the rate asks for {:.2}, extrapolated)",
                l.asked_log_power.exp()
            ),
            (true, false) => "extrapolated from the simulated machines".into(),
            (false, _) => String::from("from simulated machines"),
        };
        format!(
            "{} false alarms a day of {:.0} blocks, at a factor of {:.2} in power to either side, {beyond}; rests on {} healthy \
             blocks ({} held out, {:.0} effective), noise {:.3}, drift {:.3}; {:.0} healthy blocks without an alarm would show it",
            self.false_alarms_per_day,
            self.blocks_per_day,
            l.log_power.exp(),
            self.healthy_blocks,
            self.held_out_blocks,
            l.effective_blocks,
            l.spread,
            l.drift,
            l.needed_blocks
        )
    }
}

impl Training {
    pub(super) fn new(split: &Split, sample_rate_hz: f64, config: &FitConfig, once: &SingleFit) -> Self {
        let names = |series: &[super::Series]| series.iter().map(|s| s.name.clone()).collect();
        let samples = || split.train.iter().flat_map(|s| s.samples.iter().copied());
        let library = once.layout.library;
        Self {
            recordings: names(&split.train),
            validation: names(&split.validation),
            held_out: names(&split.held_out),
            within_recording: split.within,
            channel: None,
            sample_rate_hz,
            range_m_per_s2: (samples().fold(f32::MAX, f32::min), samples().fold(f32::MIN, f32::max)),
            solver: match &config.solver {
                Solver::SindyNn { hidden, .. } => match config.arithmetic {
                    Arithmetic::Float => format!("sindy-nn, hidden {hidden:?}"),
                    Arithmetic::Fixed => format!("sindy-nn, hidden {hidden:?}, 16-bit fixed point"),
                },
                Solver::Stlsq(_) => "stlsq".into(),
            },
            states: format!(
                "n_MD {}, {:?} orders, {:?} alignment",
                config.spec.dimension, config.spec.orders, config.spec.alignment
            )
            .to_lowercase()
            .replace("n_md", "n_MD")
                + &choice::estimator_in_words(config.spec.estimator),
            functions: library.len(),
            terms: (0..library.len()).filter_map(|t| library.term(t)).map(|t| t.to_string()).collect(),
            entered: Vec::new(),
            steps: once.trained.as_ref().map(|t| t.steps),
            stopped_early: once.trained.as_ref().map(|t| t.stopped_early),
            seed: config.seed,
        }
    }
}
