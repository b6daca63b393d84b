//! Diagnosis of a least-squares fit: conditioning, inseparable terms, terms kept under the null.

use ballrace_core::library::Library;
use serde::{Deserialize, Serialize};

use super::regression::Regression;
use super::settings::ConditioningSettings;
use super::{Equation, RFactor, StlsqConfig, thresholds_up_to};
use crate::model::samples::Samples;

const SETTINGS: ConditioningSettings = ConditioningSettings::DEFAULT;

/// Conditioning of the library's columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// Condition number of all columns, scaled to unit RMS.
    pub condition_number: f64,
    /// Condition number of the columns that are used.
    pub condition_number_used: f64,
    /// Pairs of used terms whose columns have an uncentred correlation above 0.99 in magnitude, with it.
    pub inseparable: Vec<(usize, usize, f64)>,
}

/// Conditioning of the columns of a fit.
pub fn diagnose(train: &RFactor, equations: &[Equation]) -> Diagnosis {
    let used: Vec<usize> = (0..train.terms).filter(|t| equations.iter().any(|e| e.coefficients[*t] != 0.0)).collect();
    let all: Vec<usize> = (0..train.terms).collect();
    let mut inseparable = Vec::new();
    for (n, a) in used.iter().enumerate() {
        for b in &used[n + 1..] {
            let correlation = train.term_product(*a, *b) / (train.term_rms(*a) * train.term_rms(*b));
            if correlation.abs() > SETTINGS.inseparable_correlation {
                inseparable.push((*a, *b, correlation));
            }
        }
    }
    Diagnosis {
        condition_number: train.condition_number(&all),
        condition_number_used: train.condition_number(&used),
        inseparable,
    }
}

/// Mean number of terms that an equation keeps under the null: the states of `states` refitted to the targets of
/// `unrelated` at the equations' thresholds.
pub fn noise_terms(
    library: Library,
    states: &[Samples<f32>],
    unrelated: &[Samples<f32>],
    equations: &[Equation],
    config: &StlsqConfig,
) -> f64 {
    let mixed: Vec<Samples<f32>> = states
        .iter()
        .zip(unrelated)
        .map(|(s, u)| {
            let len = s.x.len().min(u.dx.len());
            Samples { inputs: s.inputs, x: s.x[..len].to_vec(), dx: u.dx[..len].to_vec() }
        })
        .collect();
    let parts = RFactor::from_each(library, &mixed);
    let Some(moments) = RFactor::merge(&parts.iter().collect::<Vec<_>>()) else { return 0.0 };
    let regression = Regression::new(&moments, config.ridge);
    let kept: usize = equations
        .iter()
        .enumerate()
        .map(|(output, equation)| {
            let path = regression.threshold_path(output, &thresholds_up_to(equation.threshold), config.rounds);
            path.last().map_or(0, |coefficients| coefficients.iter().filter(|c| **c != 0.0).count())
        })
        .sum();
    kept as f64 / equations.len().max(1) as f64
}
