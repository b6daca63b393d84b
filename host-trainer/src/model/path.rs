//! Path of models from all terms to few, and the choice on it.

use serde::{Deserialize, Serialize};

/// Model on the path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathPoint {
    /// Share of power below which a term is removed.
    pub threshold: f64,
    /// Nonzero coefficients.
    pub terms: usize,
    /// R² of the derivatives on the validation recordings, which choose the threshold.
    pub validation: Option<f64>,
    /// R² of the derivatives on the held-out recordings, which choose nothing.
    pub held_out: Option<f64>,
}

/// Index of the last of several candidates, each with an error for every recording, whose error exceeds that of the best by
/// no more than one standard error (Breiman et al. 1984), theory (20), or than what is `immaterial`; 0 for none. A candidate
/// whose error is not finite is never taken.
pub fn last_as_good_as_best(errors: &[Vec<f64>], immaterial: f64) -> usize {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let finite = errors.iter().filter(|errors| mean(errors).is_finite());
    let Some(best) = finite.min_by(|a, b| mean(a).total_cmp(&mean(b))) else { return 0 };
    let within = |errors: &Vec<f64>| {
        // Of the paired differences: the recordings' own scatter is common to both.
        let differences: Vec<f64> = errors.iter().zip(best).map(|(e, b)| e - b).collect();
        let excess = mean(&differences);
        let n = differences.len() as f64;
        let variance = differences.iter().map(|d| (d - excess).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        excess <= (variance / n).sqrt().max(immaterial)
    };
    errors.iter().rposition(within).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_that_is_not_worse_beyond_its_scatter_is_taken() {
        // Differences to the best: 0.01 ± 0.02, then 0.2 ± 0.02.
        let errors = [[0.5, 0.6, 0.7], [0.4, 0.5, 0.6], [0.43, 0.49, 0.61], [0.6, 0.72, 0.78]].map(Vec::from);
        assert_eq!(last_as_good_as_best(&errors, 0.0), 2);
        assert_eq!(last_as_good_as_best(&errors, 0.25), 3, "0.2 is immaterial");
        assert_eq!(last_as_good_as_best(&[], 0.0), 0);
        let broken = [[f64::NAN, 0.1], [0.2, 0.3], [0.5, f64::INFINITY]].map(Vec::from);
        assert_eq!(last_as_good_as_best(&broken, 0.0), 1);
    }
}
