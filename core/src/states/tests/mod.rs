//! Tests of all estimators as streams.

extern crate std;
use super::*;
use std::vec::Vec;

mod estimators;
mod kalman_gain;
mod savitzky_golay_weights;

/// Definition, written out: Δ^k by repeated differencing of the whole recording.
fn reference(a: &[f32], spec: StateSpec) -> Vec<(Vec<f32>, Vec<f32>)> {
    let highest = spec.orders.highest(spec.dimension);
    let mut d = std::vec![a.to_vec()];
    for k in 0..highest {
        d.push(d[k].windows(2).map(|w| w[1] - w[0]).collect());
    }
    let at = |k: usize, start: isize| -> Option<f32> { usize::try_from(start).ok().and_then(|s| d[k].get(s).copied()) };
    (0..a.len() as isize)
        .filter_map(|t| {
            let pick = |k: usize, target: bool| match spec.alignment {
                Alignment::Forward => at(k, t),
                Alignment::Half => at(k, t - (k / 2) as isize),
                Alignment::Causal => at(k, t + target as isize - k as isize),
            };
            let n = spec.dimension;
            let x: Option<Vec<f32>> = (0..n).map(|i| pick(spec.orders.state(i), false)).collect();
            let y: Option<Vec<f32>> = (0..n).map(|i| pick(spec.orders.state(i) + 1, true)).collect();
            Some((x?, y?))
        })
        .collect()
}

#[test]
fn streaming_equals_the_definition_for_every_dimension_order_and_alignment() {
    let a: Vec<f32> = (0..80).map(|i| ((i * i * 7919) % 1000) as f32 / 250.0 - 2.0).collect();
    for dimension in 1..=MAX_DIMENSION {
        for orders in [Orders::Even, Orders::Consecutive] {
            for alignment in [Alignment::Forward, Alignment::Half, Alignment::Causal] {
                let spec = StateSpec { dimension, orders, alignment, estimator: Estimator::Differences };
                let mut delays = std::vec![f32::NAN; spec.memory_len()];
                let mut streaming = VirtualStates::new(spec, &mut delays).unwrap();
                for _ in 0..2 {
                    // Twice: a reset must leave nothing behind.
                    streaming.reset();
                    let (mut x, mut y) = (std::vec![0.0; dimension], std::vec![0.0; dimension]);
                    let got: Vec<_> =
                        a.iter()
                            .filter_map(|&s| {
                                if streaming.push(s, &mut x, &mut y) { Some((x.clone(), y.clone())) } else { None }
                            })
                            .collect();
                    assert_eq!(got, reference(&a, spec), "{spec:?}");
                }
            }
        }
    }
}

#[test]
fn causal_targets_are_the_increments_of_the_states() {
    let spec = StateSpec {
        dimension: 4,
        orders: Orders::Even,
        alignment: Alignment::Causal,
        estimator: Estimator::Differences,
    };
    let a: Vec<f32> = (0..40).map(|i| ((i * i) % 17) as f32).collect();
    let rows = reference(&a, spec);
    for pair in rows.windows(2) {
        for i in 0..4 {
            assert_eq!(pair[0].1[i], pair[1].0[i] - pair[0].0[i]);
        }
    }
}

#[test]
fn refuses_what_it_cannot_stream() {
    let spec = |dimension| StateSpec {
        dimension,
        orders: Orders::Even,
        alignment: Alignment::Half,
        estimator: Estimator::Differences,
    };
    assert!(VirtualStates::new(spec(0), &mut [0.0; 9]).is_none());
    assert!(VirtualStates::new(spec(17), &mut [0.0; 900]).is_none());
    assert!(VirtualStates::new(spec(3), &mut [0.0; 8]).is_none());
    assert!(VirtualStates::new(spec(3), &mut [0.0; 9]).is_some());
}
