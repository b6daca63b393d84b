//! Fits to states by estimators other than differences.

use ballrace_core::states::{Estimator, SpecError};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

const SAVITZKY_GOLAY: Estimator = Estimator::SavitzkyGolay { excess: 1, stretch: 4.0 };
const KALMAN: Estimator = Estimator::Kalman { cutoff: 0.05 };

/// Ten recordings of a slow tone of amplitude `tone` in white noise of unit variance.
fn recordings(tone: f32) -> Vec<Series> {
    let one = |k: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(k);
        let mut noise = || (0..12).map(|_| rng.random_range(-0.5..0.5f32)).sum::<f32>();
        (0..2000).map(|t| tone * (0.1 * t as f32 + k as f32).sin() + noise()).collect()
    };
    (0..10).map(|k| Series { name: format!("r{k}"), samples: one(k) }).collect()
}

fn config(estimator: Estimator, alignment: Alignment) -> FitConfig {
    FitConfig {
        spec: StateSpec { dimension: 2, orders: Orders::Even, alignment, estimator },
        degree: 1,
        harmonics: 0,
        powers: false,
        solver: Solver::Stlsq(StlsqConfig::default()),
        null_fits: 3,
        ..FitConfig::default()
    }
}

fn next_sample(recordings: &[Series], estimator: Estimator) -> f64 {
    let fitted = fit(recordings, 1000.0, &config(estimator, Alignment::Causal), &|_| ()).unwrap();
    fitted.report.scores.causal.next_sample.unwrap()
}

/// Of a tone of half the power of the noise no more than a third can be predicted.
#[test]
fn invariant_a_tone_in_noise_is_predicted_better_than_by_differences() {
    let tone = recordings(1.0);
    let differences = next_sample(&tone, Estimator::Differences);
    for estimator in [SAVITZKY_GOLAY, KALMAN] {
        let found = next_sample(&tone, estimator);
        println!("{estimator:?}: {found:.3}, differences {differences:.3}");
        assert!(found > differences + 0.01 && found < 0.34, "{estimator:?}: {found}, differences {differences}");
    }
}

#[test]
fn null_white_noise_is_not_predicted() {
    for estimator in [SAVITZKY_GOLAY, KALMAN] {
        let found = next_sample(&recordings(0.0), estimator);
        assert!(found.abs() < 0.005, "{estimator:?}: {found}");
    }
}

#[test]
fn an_estimator_is_refused_outside_of_the_causal_alignment() {
    let refused = fit(&recordings(0.0), 1000.0, &config(KALMAN, Alignment::Half), &|_| ()).unwrap_err();
    assert!(matches!(refused, FitError::States(SpecError::NotCausal { found: Alignment::Half })), "{refused}");
}
