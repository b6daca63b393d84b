//! Fourier transforms of real signals, Hann window, median.

use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

use crate::stats::cancel;

/// Planner with its cache: making a plan takes longer than using it.
static PLANNER: LazyLock<Mutex<RealFftPlanner<f64>>> = LazyLock::new(Mutex::default);

/// Plan from `length` real samples to their frequencies.
pub(crate) fn forward_plan(length: usize) -> Arc<dyn RealToComplex<f64>> {
    cancel::check();
    PLANNER.lock().unwrap_or_else(PoisonError::into_inner).plan_fft_forward(length)
}

/// Plan from frequencies to `length` real samples.
pub(crate) fn inverse_plan(length: usize) -> Arc<dyn ComplexToReal<f64>> {
    PLANNER.lock().unwrap_or_else(PoisonError::into_inner).plan_fft_inverse(length)
}

/// Periodic Hann window: half-overlapping windows add up evenly.
pub(crate) fn hann(length: usize) -> Vec<f64> {
    (0..length).map(|i| 0.5 - 0.5 * (std::f64::consts::TAU * i as f64 / length as f64).cos()).collect()
}

/// Fourier bins 0 to n/2 of n real values.
pub(crate) fn forward(values: &mut [f64]) -> Vec<Complex<f64>> {
    let transform = forward_plan(values.len());
    let mut bins = transform.make_output_vec();
    transform.process(values, &mut bins).expect("buffers are the plan's own");
    bins
}

/// Sum over k of `bins[k]` exp(2πi kt/n) for t = 0…n−1, n being the number of bins; no scaling.
pub(crate) fn inverse_complex(bins: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let n = bins.len();
    if n < 2 {
        return bins.to_vec();
    }
    let transform = inverse_plan(n);
    let mirrored = |k: usize| bins[(n - k) % n].conj();
    // Real and imaginary part each have a Hermitian spectrum.
    let part = |of: &dyn Fn(usize) -> Complex<f64>| {
        let mut half: Vec<_> = (0..=n / 2).map(of).collect();
        half[0].im = 0.0;
        if n.is_multiple_of(2) {
            half[n / 2].im = 0.0;
        }
        let mut out = transform.make_output_vec();
        transform.process(&mut half, &mut out).expect("buffers are the plan's own");
        out
    };
    let re = part(&|k| 0.5 * (bins[k] + mirrored(k)));
    let im = part(&|k| Complex::new(0.0, -0.5) * (bins[k] - mirrored(k)));
    re.into_iter().zip(im).map(|(re, im)| Complex::new(re, im)).collect()
}

/// Median, the upper one of an even count; reorders the values. `None` for no values.
pub(crate) fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn invariant_the_inverse_is_the_sum_that_it_is_said_to_be() {
        for n in [2, 5, 8] {
            let bins: Vec<_> = (0..n).map(|k| Complex::new(k as f64 - 1.3, (k * k) as f64 * 0.2)).collect();
            for (t, got) in inverse_complex(&bins).iter().enumerate() {
                let term =
                    |(k, b): (usize, &Complex<f64>)| b * Complex::from_polar(1.0, TAU * (k * t) as f64 / n as f64);
                let expected: Complex<f64> = bins.iter().enumerate().map(term).sum();
                assert!((got - expected).norm() < 1e-12, "{n} {t} {got} {expected}");
            }
        }
    }
}
