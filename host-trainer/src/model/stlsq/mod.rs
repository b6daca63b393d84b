//! Sequentially thresholded least squares (Brunton et al. 2016) for Ξ, theory (17) to (20), on library columns scaled
//! by their RMS.
//!
//! A threshold is a share of power: a term is dropped if ξ²⟨θ²⟩ is less than that share of the target's variance. It
//! therefore means the same for every record length and unit. Each equation has its own, the largest whose error on the
//! validation recordings is within one standard error of the best (Breiman et al. 1984).

mod diagnose;
mod r_factor;
mod regression;
pub(crate) mod settings;

pub use diagnose::{Diagnosis, diagnose, noise_terms};
pub use r_factor::RFactor;
pub(super) use r_factor::add_gram;

use rayon::prelude::*;

use crate::model::path::{PathPoint, last_as_good_as_best};
use regression::Regression;
use settings::GridSettings;

/// Options of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct StlsqConfig {
    /// Share of the target's variance below which a term is dropped; `None`: chosen per equation on validation
    /// recordings.
    pub threshold: Option<f64>,
    /// Ridge penalty μ on scaled coefficients, theory (18).
    pub ridge: f64,
    /// Limit of the rounds of thresholding.
    pub rounds: usize,
}

impl Default for StlsqConfig {
    fn default() -> Self {
        Self { threshold: None, ridge: 1e-6, rounds: 20 }
    }
}

/// Column of Ξ for one equation.
#[derive(Clone, Debug, PartialEq)]
pub struct Equation {
    /// Coefficient of each of the library's terms, 0 for those dropped.
    pub coefficients: Vec<f64>,
    /// Threshold of this equation.
    pub threshold: f64,
}

impl Equation {
    /// Number of terms.
    pub fn terms(&self) -> usize {
        self.coefficients.iter().filter(|c| **c != 0.0).count()
    }
}

/// Candidate thresholds: 0, then 1e-6 to 1e-1.
fn grid() -> Vec<f64> {
    let GridSettings { min_exponent, per_decade, intervals } = GridSettings::DEFAULT;
    std::iter::once(0.0).chain((0..=intervals).map(|k| 10f64.powf(min_exponent + f64::from(k) / per_decade))).collect()
}

/// Thresholds of a path to a stated one.
fn thresholds_up_to(stated: f64) -> Vec<f64> {
    grid().into_iter().filter(|threshold| *threshold < stated).chain([stated]).collect()
}

/// Fits every output of `train`, theory (18) to (20); `validation`, one per recording, chooses the thresholds. Without
/// validation recordings and without a stated threshold nothing is thresholded.
pub fn fit(train: &RFactor, validation: &[RFactor], config: &StlsqConfig) -> Vec<Equation> {
    fit_with_path(train, validation, &[], config).0
}

/// The same, and the path from all terms to few, scored on `validation` and on `held_out`, which chooses nothing.
pub fn fit_with_path(
    train: &RFactor,
    validation: &[RFactor],
    held_out: &[RFactor],
    config: &StlsqConfig,
) -> (Vec<Equation>, Vec<PathPoint>) {
    let thresholds: Vec<f64> = match config.threshold {
        Some(stated) => thresholds_up_to(stated),
        None if validation.is_empty() => vec![0.0],
        None => grid(),
    };
    let regression = Regression::new(train, config.ridge);
    let paths: Vec<OutputPath> = (0..train.outputs())
        .into_par_iter()
        .map(|output| {
            let path = regression.threshold_path(output, &thresholds, config.rounds);
            let equation = |(threshold, coefficients): (&f64, _)| Equation { coefficients, threshold: *threshold };
            let equations: Vec<Equation> = thresholds.iter().zip(path).map(equation).collect();
            // Relative to each recording's own variance, or a loud recording decides alone.
            let error = |part: &RFactor, e: &Equation| 1.0 - part.r_squared(output, &e.coefficients);
            let errors = |e: &Equation| validation.iter().map(|part| error(part, e)).collect();
            OutputPath { errors: equations.iter().map(errors).collect(), equations }
        })
        .collect();
    let together = [validation, held_out].map(|parts| RFactor::merge(&parts.iter().collect::<Vec<_>>()));
    let point = |(k, threshold): (usize, &f64)| PathPoint {
        threshold: *threshold,
        terms: paths.iter().map(|path| path.equations[k].terms()).sum(),
        validation: together[0].as_ref().map(|rows| r_squared(rows, &paths, k)),
        held_out: together[1].as_ref().map(|rows| r_squared(rows, &paths, k)),
    };
    let points = thresholds.iter().enumerate().map(point).collect();
    let chosen = |(output, mut path): (usize, OutputPath)| {
        let chosen = match config.threshold {
            Some(_) => thresholds.len() - 1,
            None => last_as_good_as_best(&path.errors, 0.0),
        };
        let threshold = thresholds[chosen];
        let coefficients = regression.refined(output, &path.equations.swap_remove(chosen).coefficients);
        Equation { coefficients, threshold }
    };
    (paths.into_iter().enumerate().map(chosen).collect(), points)
}

/// Equations of one output for growing thresholds.
struct OutputPath {
    equations: Vec<Equation>,
    /// Unexplained share of each validation recording, for each equation.
    errors: Vec<Vec<f64>>,
}

/// Mean R² of the outputs at place `k` of their paths.
fn r_squared(rows: &RFactor, paths: &[OutputPath], k: usize) -> f64 {
    let each = paths.iter().enumerate().map(|(output, path)| rows.r_squared(output, &path.equations[k].coefficients));
    each.sum::<f64>() / paths.len() as f64
}

#[cfg(test)]
mod tests;
