//! Sequentially thresholded least squares (Brunton et al. 2016) for Ξ, theory (17) to (20), on library columns scaled
//! by their RMS.
//!
//! A threshold is a share of power: a term is dropped if ξ²⟨θ²⟩ is less than that share of the target's variance. It
//! therefore means the same for every record length and unit. Each equation has its own, the largest whose held-out
//! error is within one standard error of the best (Breiman et al. 1984).

mod diagnose;
mod r_factor;
pub(crate) mod settings;

pub use diagnose::{Diagnosis, diagnose, noise_terms};
pub use r_factor::RFactor;

use faer::Mat;
use faer::linalg::solvers::SolveLstsqCore;
use rayon::prelude::*;

use settings::GridSettings;

/// Options of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct StlsqConfig {
    /// Share of the target's variance below which a term is dropped; `None`: chosen per equation on held-out
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

/// Candidate thresholds: 0, then 1e-6 to 1e-1.
fn grid() -> Vec<f64> {
    let GridSettings { min_exponent, per_decade, intervals } = GridSettings::DEFAULT;
    std::iter::once(0.0).chain((0..=intervals).map(|k| 10f64.powf(min_exponent + f64::from(k) / per_decade))).collect()
}

/// Fits every output of `train`, theory (18) to (20); `held_out`, one per recording, chooses the thresholds. Without
/// held-out recordings and without a stated threshold nothing is thresholded.
pub fn fit(train: &RFactor, held_out: &[RFactor], config: &StlsqConfig) -> Vec<Equation> {
    (0..train.outputs()).into_par_iter().map(|output| fit_output(train, held_out, output, config)).collect()
}

fn fit_output(train: &RFactor, held_out: &[RFactor], output: usize, config: &StlsqConfig) -> Equation {
    let at = |threshold: f64| Equation { coefficients: threshold_path(train, output, threshold, config), threshold };
    if let Some(threshold) = config.threshold {
        return at(threshold);
    }
    if held_out.is_empty() {
        return at(0.0);
    }
    let candidates: Vec<(Equation, Vec<f64>)> = grid()
        .into_iter()
        .map(|threshold| {
            let equation = at(threshold);
            // Relative to each recording's own variance, or a loud recording decides alone.
            let errors = held_out.iter().map(|m| 1.0 - m.r_squared(output, &equation.coefficients)).collect();
            (equation, errors)
        })
        .collect();
    choose(candidates)
}

/// Sparsest candidate within one standard error of the best, theory (20).
fn choose(candidates: Vec<(Equation, Vec<f64>)>) -> Equation {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let best = candidates
        .iter()
        .map(|(_, errors)| errors)
        .min_by(|a, b| mean(a).total_cmp(&mean(b)))
        .cloned()
        .unwrap_or_default();
    let within = |errors: &[f64]| {
        // Of the paired differences: the recordings' own scatter is common to both.
        let differences: Vec<f64> = errors.iter().zip(&best).map(|(e, b)| e - b).collect();
        let excess = mean(&differences);
        let n = differences.len() as f64;
        let variance = differences.iter().map(|d| (d - excess).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        excess <= (variance / n).sqrt()
    };
    let chosen = candidates.iter().rposition(|(_, errors)| within(errors)).unwrap_or(0);
    candidates.into_iter().nth(chosen).map(|(equation, _)| equation).expect("the grid is not empty")
}

/// Coefficients of one equation for one threshold, theory (19).
fn threshold_path(train: &RFactor, output: usize, threshold: f64, config: &StlsqConfig) -> Vec<f64> {
    let scales: Vec<f64> = (0..train.terms).map(|t| train.term_rms(t)).collect();
    let target_power = train.variance(output).max(f64::MIN_POSITIVE);
    let mut active: Vec<usize> = (0..train.terms).filter(|t| scales[*t] > 0.0).collect();
    let mut scaled = solve(train, &active, &scales, output, config.ridge);
    for _ in 0..config.rounds {
        let kept: Vec<usize> =
            active.iter().zip(&scaled).filter(|(_, c)| *c * *c >= threshold * target_power).map(|(t, _)| *t).collect();
        if kept.len() == active.len() {
            break;
        }
        active = kept;
        scaled = solve(train, &active, &scales, output, config.ridge);
    }
    let mut coefficients = vec![0.0; train.terms];
    for (term, c) in active.iter().zip(&scaled) {
        coefficients[*term] = c / scales[*term];
    }
    coefficients
}

/// Ridge least squares for the active terms, theory (18), in coefficients of columns with unit RMS.
fn solve(train: &RFactor, active: &[usize], scales: &[f64], output: usize, ridge: f64) -> Vec<f64> {
    if active.is_empty() {
        return Vec::new();
    }
    let (n, rows) = (active.len(), train.terms);
    let (a, y) = (train.scaled(active, scales), train.target(output));
    let mut tall = Mat::zeros(rows + n, n);
    tall.as_mut().subrows_mut(0, rows).copy_from(&a);
    let mut rhs = Mat::zeros(rows + n, 1);
    rhs.as_mut().subrows_mut(0, rows).copy_from(&y);
    for i in 0..n {
        tall[(rows + i, i)] = ridge.sqrt();
    }
    tall.qr().solve_lstsq_in_place_with_conj(faer::Conj::No, rhs.as_mut());
    (0..n).map(|i| rhs[(i, 0)]).collect()
}

#[cfg(test)]
mod tests;
