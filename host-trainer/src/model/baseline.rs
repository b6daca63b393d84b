//! Linear baselines that any model of the next sample must beat: autoregression and persistence.

use faer::Mat;
use faer::linalg::solvers::SolveLstsqCore;

use super::fit::score::Sums;
use crate::recording::input::Series;

/// Prediction a[t+1] = c₀ + Σ c_k a[t+1−k], k = 1 … order.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearPredictor {
    /// Coefficients c₀, c₁, ….
    coefficients: Vec<f64>,
}

impl LinearPredictor {
    /// Least squares over all samples that have a whole past; `None` if there are fewer of them than coefficients.
    pub fn fit(recordings: &[Series], order: usize) -> Option<Self> {
        let windows = || recordings.iter().flat_map(|series| series.samples.windows(order + 1));
        let (rows, columns) = (windows().count(), order + 1);
        if rows < columns {
            return None;
        }
        let (mut past, mut next) = (Mat::zeros(rows, columns), Mat::zeros(rows, 1));
        for (i, window) in windows().enumerate() {
            past[(i, 0)] = 1.0;
            (1..=order).for_each(|k| past[(i, k)] = f64::from(window[order - k]));
            next[(i, 0)] = f64::from(window[order]);
        }
        past.qr().solve_lstsq_in_place_with_conj(faer::Conj::No, next.as_mut());
        Some(Self { coefficients: (0..columns).map(|k| next[(k, 0)]).collect() })
    }

    /// Model that repeats the present sample.
    pub fn persistence() -> Self {
        Self { coefficients: vec![0.0, 1.0] }
    }

    /// Score R² of the next sample over recordings, theory (22).
    pub fn r_squared(&self, recordings: &[Series]) -> f64 {
        let order = self.coefficients.len() - 1;
        let mut sums = Sums::default();
        for window in recordings.iter().flat_map(|series| series.samples.windows(order + 1)) {
            let past = window.iter().rev().skip(1).zip(&self.coefficients[1..]);
            let predicted = self.coefficients[0] + past.map(|(a, c)| f64::from(*a) * c).sum::<f64>();
            let next = f64::from(window[order]);
            sums.push(next, next - predicted);
        }
        sums.r_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(samples: Vec<f32>) -> Vec<Series> {
        vec![Series { name: "made".into(), samples }]
    }

    #[test]
    fn literature_a_sine_is_an_autoregression_of_order_two() {
        // a[t+1] = 2 cos ω a[t] − a[t−1].
        let made = series((0..500).map(|t| 1.0 + (0.4 * t as f32).sin()).collect());
        let fitted = LinearPredictor::fit(&made, 2).unwrap();
        let expected = [2.0 - 2.0 * 0.4f64.cos(), 2.0 * 0.4f64.cos(), -1.0];
        for (got, expected) in fitted.coefficients.iter().zip(expected) {
            assert!((got - expected).abs() < 1e-4, "{fitted:?}");
        }
        assert!(fitted.r_squared(&made) > 0.999_999);
        assert_eq!(LinearPredictor::fit(&series(vec![1.0; 4]), 3), None);
    }

    #[test]
    fn persistence_explains_what_the_correlation_of_neighbours_does() {
        // R² of repeating a sine is 1 − 2 (1 − cos ω).
        let made = series((0..100_000).map(|t| (0.4 * t as f32).sin()).collect());
        let expected = 1.0 - 2.0 * (1.0 - 0.4f64.cos());
        assert!((LinearPredictor::persistence().r_squared(&made) - expected).abs() < 1e-3);
    }
}
