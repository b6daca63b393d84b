//! Closed-form gain of the Kalman filter against the Riccati equation.

extern crate std;

use nalgebra::{SMatrix, SVector};

use crate::states::kalman::{CHAIN, gain};

/// Stationary gain by iterating the Riccati equation of a chain of N integrators in differences, theory (103): its
/// noise enters every difference, as d_k[t+1] = Σ_(j≥k) d_j[t] + w.
fn riccati<const N: usize>(cutoff: f64) -> SVector<f64, N> {
    let transition = SMatrix::<f64, N, N>::from_fn(|i, j| if j >= i { 1.0 } else { 0.0 });
    let ratio = (2.0 * (std::f64::consts::PI * cutoff).sin()).powi(2 * N as i32);
    let noise = SMatrix::<f64, N, N>::from_element(ratio);
    let mut covariance = noise;
    let mut gain = SVector::<f64, N>::zeros();
    for _ in 0..4000 {
        gain = covariance.column(0) / (covariance[(0, 0)] + 1.0);
        let updated = covariance - gain * covariance.row(0);
        covariance = transition * updated * transition.transpose() + noise;
        covariance = (covariance + covariance.transpose()) * 0.5;
    }
    gain
}

fn agrees<const N: usize>() {
    for cutoff in [0.05, 0.1, 0.22, 0.4] {
        let (expected, found) = (riccati::<N>(cutoff), gain(N - 1, cutoff as f32));
        for (k, expected) in expected.iter().enumerate() {
            let found = f64::from(found[k]);
            assert!((found - expected).abs() < 1e-6 * expected.max(1e-3), "{N} {cutoff} {k}: {found} for {expected}");
        }
    }
}

#[test]
fn invariant_gain_solves_the_riccati_equation() {
    agrees::<1>();
    agrees::<2>();
    agrees::<3>();
    agrees::<5>();
}

/// The filter of order 1 is the α–β filter: Kalata, IEEE Trans. AES 20 (1984) 174–182, whose tracking index Λ obeys
/// Λ² = β²/(1 − α), with Λ² the ratio of the variances of process and measurement noise.
#[test]
fn literature_alpha_beta_filter() {
    for cutoff in [0.05_f32, 0.22, 0.4] {
        let found = gain(1, cutoff);
        let (alpha, beta) = (f64::from(found[0]), f64::from(found[1]));
        let ratio = (2.0 * (std::f64::consts::PI * f64::from(cutoff)).sin()).powi(4);
        assert!((beta * beta - ratio * (1.0 - alpha)).abs() < 1e-6, "{cutoff}: {alpha} {beta}");
    }
}

#[test]
fn invariant_gains_are_positive_and_end_with_the_order() {
    for highest in 0..CHAIN {
        for cutoff in [0.01, 0.05, 0.22, 0.49] {
            let gain = gain(highest, cutoff);
            for (k, value) in gain.iter().enumerate() {
                assert!(value.is_finite() && (*value > 0.0) == (k <= highest), "{highest} {cutoff} {k}: {value}");
            }
            assert!(gain[0] <= 1.0 + 1e-6);
        }
    }
}
