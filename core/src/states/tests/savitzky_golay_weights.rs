//! End-point weights of Savitzky and Golay against tables, SciPy and exact fractions.

extern crate std;
use std::vec::Vec;

use crate::states::savitzky_golay::end_point_weights;

fn weights(window: usize, degree: usize, order: usize) -> Vec<f32> {
    let mut weights = std::vec![f32::NAN; window];
    end_point_weights(degree, order, &mut weights);
    weights
}

fn assert_close(found: &[f32], expected: &[f64], case: &str) {
    assert_eq!(found.len(), expected.len());
    let largest = expected.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for (found, expected) in found.iter().zip(expected) {
        assert!((f64::from(*found) - expected).abs() < 2e-7 * largest, "{case}: {found} for {expected}");
    }
}

/// Gorry, Anal. Chem. 62 (1990) 570–573, end points of quadratic fits: the published integers over their norm; for
/// degree 1 the weights are those of a straight line's slope.
#[test]
fn literature_gorry_end_points() {
    let over = |norm: f64, integers: &[i32]| integers.iter().map(|i| f64::from(*i) / norm).collect::<Vec<_>>();
    assert_close(&weights(5, 2, 0), &over(35.0, &[3, -5, -3, 9, 31]), "smoothing, 5 points");
    assert_close(&weights(5, 2, 1), &over(70.0, &[26, -27, -40, -13, 54]), "first derivative, 5 points");
    assert_close(&weights(4, 1, 1), &over(10.0, &[-3, -1, 1, 3]), "slope, 4 points");
    assert_close(&weights(5, 2, 2), &over(7.0, &[2, -1, -2, -1, 2]), "second derivative, 5 points");
}

/// `scipy.signal.savgol_coeffs(w, p, deriv=k, pos=w-1, use="dot")` of SciPy 1.x for (6, 3, 2), whose Vandermonde
/// system is still well conditioned.
#[test]
fn golden_scipy() {
    let scipy = [-0.515_873_016, 0.936_507_937, 0.412_698_413, -0.698_412_698, -1.007_936_508, 0.873_015_873];
    assert_close(&weights(6, 3, 2), &scipy, "(6, 3, 2)");
}

/// Solutions in exact fractions. SciPy's are wrong there: the norm of (24, 15, 14) is 0.025 by SciPy.
#[test]
fn golden_exact_fractions_where_monomials_fail() {
    let found = weights(24, 15, 14);
    for (i, expected) in [(0, -0.0866362641), (1, 0.823933114), (2, -3.22205795), (21, 3.48174726), (23, 0.0966624192)]
    {
        assert!((f64::from(found[i]) - expected).abs() < 2e-6, "{i}: {} for {expected}", found[i]);
    }
    for ((window, degree, order), norm) in [((24, 15, 14), 18.266_993_868), ((64, 16, 15), 4.328_075_820e-6)] {
        let found = weights(window, degree, order).iter().map(|w| f64::from(*w).powi(2)).sum::<f64>().sqrt();
        assert!((found / norm - 1.0).abs() < 1e-6, "{found} for {norm}");
    }
}

#[test]
fn invariant_exact_on_polynomials_up_to_the_degree() {
    for (window, degree, order) in [(2, 1, 1), (4, 2, 2), (9, 4, 1), (9, 4, 3), (20, 6, 5), (64, 8, 2)] {
        let weights = weights(window, degree, order);
        for power in 0..=degree {
            // (s/w)^power at s = −(w−1) … 0 samples from the newest.
            let unit = window as f64;
            let at = |i: usize| ((i as f64 - (window - 1) as f64) / unit).powi(power as i32);
            let found: f64 = weights.iter().enumerate().map(|(i, w)| f64::from(*w) * at(i)).sum();
            let factorial: f64 = (1..=order).map(|k| k as f64).product();
            let expected = if power == order { factorial / unit.powi(order as i32) } else { 0.0 };
            let scale: f64 = weights.iter().map(|w| f64::from(w.abs())).sum();
            assert!(
                (found - expected).abs() < 1e-6 * scale,
                "{window} {degree} {order} t^{power}: {found}, {expected}"
            );
        }
    }
}

#[test]
fn invariant_shortest_windows_of_excess_0_are_differences() {
    for order in 1..=15 {
        let mut binomials = std::vec![1.0_f64];
        for k in 0..order {
            binomials.push(binomials[k] * (order - k) as f64 / (k + 1) as f64);
        }
        let sign = |i: usize| if (order - i).is_multiple_of(2) { 1.0 } else { -1.0 };
        let expected: Vec<f64> = binomials.iter().enumerate().map(|(i, b)| sign(i) * b).collect();
        assert_close(&weights(order + 1, order, order), &expected, "differences");
    }
}
