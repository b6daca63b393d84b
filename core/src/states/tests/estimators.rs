//! Estimators other than differences as streams.

extern crate std;
use std::vec::Vec;

use crate::states::{Alignment, Estimator, Orders, SpecError, StateSpec, VirtualStates};
use crate::testing::samples;

const SAVITZKY_GOLAY: Estimator = Estimator::SavitzkyGolay { excess: 1, stretch: 1.5 };
const KALMAN: Estimator = Estimator::Kalman { cutoff: 0.22 };

fn spec(estimator: Estimator, dimension: usize, orders: Orders) -> StateSpec {
    StateSpec { dimension, orders, alignment: Alignment::Causal, estimator }
}

/// States at the newest sample, one row a sample, from the first valid one on.
fn present(spec: StateSpec, samples: &[f32]) -> Vec<Vec<f32>> {
    let mut memory = std::vec![f32::NAN; spec.memory_len()];
    let mut stream = VirtualStates::new(spec, &mut memory).unwrap();
    let (mut x, mut dx) = (std::vec![0.0; spec.dimension], std::vec![0.0; spec.dimension]);
    let mut rows = Vec::new();
    for sample in samples {
        if stream.push(*sample, &mut x, &mut dx) {
            stream.present(&mut x);
            rows.push(x.clone());
        }
    }
    rows
}

/// White Gaussian noise of unit variance: sums of twelve uniform numbers.
fn noise(count: usize) -> Vec<f32> {
    let mut seed = 1u64;
    let mut uniform = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f32 / (1u64 << 24) as f32
    };
    (0..count).map(|_| (0..12).map(|_| uniform()).sum::<f32>() - 6.0).collect()
}

fn spread(values: impl Iterator<Item = f32> + Clone) -> f64 {
    let count = values.clone().count() as f64;
    let mean = values.clone().map(f64::from).sum::<f64>() / count;
    (values.map(|v| (f64::from(v) - mean).powi(2)).sum::<f64>() / count).sqrt()
}

#[test]
fn streams_start_at_the_warm_up_with_increments_as_targets_and_leave_nothing_behind() {
    let a = samples(200);
    for estimator in [SAVITZKY_GOLAY, KALMAN] {
        for (dimension, orders) in [(1, Orders::Even), (4, Orders::Even), (8, Orders::Even), (9, Orders::Consecutive)] {
            let spec = spec(estimator, dimension, orders);
            let mut memory = std::vec![f32::NAN; spec.memory_len()];
            let mut stream = VirtualStates::new(spec, &mut memory).unwrap();
            let mut first: Option<Vec<Vec<u32>>> = None;
            // Also after what no reset announced: samples that are not finite, or whose estimates are not.
            for before in [None, Some(0.0), Some(f32::NAN), Some(f32::INFINITY), Some(f32::MAX)] {
                let (mut x, mut dx, mut newest) =
                    (std::vec![0.0; dimension], std::vec![0.0; dimension], std::vec![0.0; dimension]);
                if let Some(before) = before {
                    stream.push(before, &mut x, &mut dx);
                    stream.push(-before, &mut x, &mut dx);
                    if before.is_finite() {
                        stream.reset();
                    }
                }
                let mut rows = Vec::new();
                for (t, sample) in a.iter().enumerate() {
                    let valid = stream.push(*sample, &mut x, &mut dx);
                    assert_eq!(valid, t + 1 >= spec.warm_up(), "{spec:?} sample {t} after {before:?}");
                    if valid {
                        if !rows.is_empty() {
                            assert_eq!(x, newest, "states are those of the sample before");
                        }
                        stream.present(&mut newest);
                        assert_eq!(newest[0], *sample, "state 0 is the sample");
                        assert!(x.iter().zip(&dx).zip(&newest).all(|((x, dx), newest)| *dx == newest - x));
                        rows.push([&x[..], &dx[..]].concat().iter().map(|v| v.to_bits()).collect());
                    }
                }
                assert!(!rows.is_empty());
                assert_eq!(*first.get_or_insert(rows.clone()), rows, "{spec:?} after {before:?}");
            }
        }
    }
}

#[test]
fn invariant_samples_of_any_size_give_no_nan() {
    for estimator in [SAVITZKY_GOLAY, KALMAN] {
        let spec = spec(estimator, 8, Orders::Even);
        let mut memory = std::vec![0.0; spec.memory_len()];
        let mut stream = VirtualStates::new(spec, &mut memory).unwrap();
        let (mut x, mut dx) = ([0.0; 8], [0.0; 8]);
        let mut valid = 0;
        for (t, noise) in noise(4000).into_iter().enumerate() {
            let sample = match t % 1000 {
                500 => f32::MAX,
                600 => f32::NAN,
                700 => -f32::MAX,
                710 => f32::MAX,
                800 => f32::MIN_POSITIVE,
                _ => noise * 1e30,
            };
            if stream.push(sample, &mut x, &mut dx) {
                valid += 1;
                assert!(x.iter().chain(&dx).all(|v| v.is_finite()), "{estimator:?} sample {t}");
            }
        }
        assert!(valid > 2000, "{estimator:?}: {valid}");
    }
}

#[test]
fn invariant_without_measurement_noise_the_estimates_are_the_differences() {
    let a = samples(120);
    let differences = present(spec(Estimator::Differences, 4, Orders::Even), &a);
    for (estimator, tolerance) in [
        (Estimator::SavitzkyGolay { excess: 0, stretch: 1.0 }, 1e-5),
        // The highest cut-off there is: the signal's density is 4^7 that of the noise at the Nyquist frequency.
        (Estimator::Kalman { cutoff: 0.499 }, 0.5),
    ] {
        let estimates = present(spec(estimator, 4, Orders::Even), &a);
        for (estimate, difference) in estimates.iter().rev().zip(differences.iter().rev()) {
            for (k, (estimate, difference)) in estimate.iter().zip(difference).enumerate() {
                let error = (estimate - difference).abs() / 4f32.powi(k as i32);
                assert!(error < tolerance, "{estimator:?} state {k}: {estimate} for {difference}");
            }
        }
    }
}

#[test]
fn invariant_ramps_and_slow_sines_give_their_derivatives() {
    let ramp: Vec<f32> = (0..400).map(|t| 3.0 + 0.25 * t as f32).collect();
    let (rate, from) = (0.05_f32, 100);
    let sine: Vec<f32> = (0..400).map(|t| (rate * t as f32).sin()).collect();
    for estimator in [SAVITZKY_GOLAY, KALMAN] {
        let spec = spec(estimator, 3, Orders::Consecutive);
        let last = present(spec, &ramp).pop().unwrap();
        assert!((last[1] - 0.25).abs() < 1e-4 && last[2].abs() < 1e-4, "{estimator:?}: {last:?}");
        let rows = present(spec, &sine);
        for (t, row) in rows.iter().enumerate().skip(from) {
            let phase = rate * (t + sine.len() - rows.len()) as f32;
            // A difference of order k lags by k/2 samples, which is an error of order rate^(k+1).
            assert!((row[1] - rate * phase.cos()).abs() < rate * rate, "{estimator:?} at {t}: {row:?}");
            assert!((row[2] + rate * rate * phase.sin()).abs() < 2.0 * rate.powi(3), "{estimator:?} at {t}: {row:?}");
        }
    }
}

/// After the warm-up the states hardly depend on what came before.
#[test]
fn invariant_the_filter_has_settled_after_the_warm_up() {
    let a = noise(4000);
    for cutoff in [0.02, 0.1, 0.22, 0.45] {
        for dimension in [2, 4, 8] {
            let spec = spec(Estimator::Kalman { cutoff }, dimension, Orders::Even);
            let (long, short) = (present(spec, &a), present(spec, &a[2000..]));
            let same = &long[long.len() - short.len()..];
            for k in 1..dimension {
                let usual = spread(same.iter().map(|row| row[k]));
                let worst = f64::from((same[0][k] - short[0][k]).abs());
                assert!(worst < 0.01 * usual, "{cutoff} {dimension} {k}: {worst} of {usual}");
            }
        }
    }
}

/// Standard deviation of each order on white noise of unit variance: the table of docs/results.md.
#[test]
fn null_white_noise_is_amplified_less_than_by_differences() {
    let a = noise(60_000);
    for dimension in [2, 4, 8] {
        let of = |estimator| present(spec(estimator, dimension, Orders::Even), &a);
        let all = [
            Estimator::Differences,
            Estimator::SavitzkyGolay { excess: 0, stretch: 1.25 },
            Estimator::SavitzkyGolay { excess: 1, stretch: 1.5 },
            Estimator::Kalman { cutoff: 0.22 },
        ]
        .map(of);
        let mut central = 1.0_f64;
        for k in 1..dimension {
            // C(2o, o) of order o = 2k.
            central = ((4 * k - 3)..=(4 * k)).map(|v| v as f64).product::<f64>() * central
                / ((2 * k - 1) * (2 * k)).pow(2) as f64;
            let [differences, narrow, wide, kalman] = all.each_ref().map(|rows| spread(rows.iter().map(|r| r[k])));
            std::println!(
                "n_MD {dimension} order {:2}: sqrt C(2k,k) {:9.3} differences {differences:9.3} Savitzky-Golay {narrow:8.3} \
                 (excess 1, stretch 1.5: {wide:8.3}) Kalman {kalman:8.3}",
                2 * k,
                central.sqrt()
            );
            assert!((differences / central.sqrt() - 1.0).abs() < 0.05);
            assert!(narrow < 0.7 * differences && wide < differences && kalman < differences, "{dimension} {k}");
        }
    }
}

#[test]
fn what_cannot_be_streamed_is_refused_with_the_reason() {
    let causal = |estimator, dimension| spec(estimator, dimension, Orders::Even);
    for (spec, expected) in [
        (causal(KALMAN, 0), SpecError::Dimension { found: 0 }),
        (
            StateSpec { alignment: Alignment::Half, ..causal(KALMAN, 4) },
            SpecError::NotCausal { found: Alignment::Half },
        ),
        (causal(KALMAN, 9), SpecError::Order { found: 16 }),
        (causal(SAVITZKY_GOLAY, 9), SpecError::Order { found: 16 }),
        (causal(Estimator::SavitzkyGolay { excess: 5, stretch: 1.0 }, 4), SpecError::Excess { found: 5 }),
        (causal(Estimator::SavitzkyGolay { excess: 0, stretch: 0.5 }, 4), SpecError::Stretch { found: 0.5 }),
        (causal(Estimator::SavitzkyGolay { excess: 0, stretch: 8.0 }, 8), SpecError::Window { found: 120 }),
        (causal(Estimator::Kalman { cutoff: 0.5 }, 4), SpecError::Cutoff { found: 0.5 }),
    ] {
        assert_eq!(spec.check(), Err(expected));
        assert!(VirtualStates::new(spec, &mut [0.0; 999]).is_none());
    }
    assert!(!causal(Estimator::Kalman { cutoff: f32::NAN }, 4).is_valid());
    assert!(!causal(Estimator::SavitzkyGolay { excess: 0, stretch: f32::NAN }, 4).is_valid());
    let spec = causal(SAVITZKY_GOLAY, 8);
    assert!(VirtualStates::new(spec, &mut std::vec![0.0; spec.memory_len() - 1]).is_none());
}
