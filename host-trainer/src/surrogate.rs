//! Phase-randomised surrogates (Theiler et al. 1992): the recording's power spectrum, nothing else of it.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use realfft::RealFftPlanner;

/// A surrogate of a recording: same length, mean and periodogram, uniformly random phases.
pub fn phase_randomised(recording: &[f32], seed: u64) -> Vec<f32> {
    let n = recording.len();
    if n < 3 {
        return recording.to_vec();
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut planner = RealFftPlanner::<f64>::new();
    let forward = planner.plan_fft_forward(n);
    let inverse = planner.plan_fft_inverse(n);
    let mut values: Vec<f64> = recording.iter().map(|v| f64::from(*v)).collect();
    let mut spectrum = forward.make_output_vec();
    forward.process(&mut values, &mut spectrum).expect("buffers are the plan's own");
    // The mean and, for even lengths, the Nyquist bin are real and keep their phase.
    let last = if n.is_multiple_of(2) { n / 2 } else { spectrum.len() };
    for bin in &mut spectrum[1..last] {
        let angle = rng.random_range(0.0..std::f64::consts::TAU);
        *bin *= realfft::num_complex::Complex::from_polar(1.0, angle);
    }
    inverse.process(&mut spectrum, &mut values).expect("buffers are the plan's own");
    values.iter().map(|v| (*v / n as f64) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_the_autocorrelation_and_nothing_else() {
        for n in [2000, 2001] {
            // A sawtooth: its phases are all in line.
            let a: Vec<f32> = (0..n).map(|i| (i % 50) as f32 / 25.0 + 0.5).collect();
            let b = phase_randomised(&a, 1);
            // The circular autocovariance is the transform of the periodogram.
            let covariance = |v: &[f32], lag: usize| -> f64 {
                let mean = v.iter().map(|v| f64::from(*v)).sum::<f64>() / n as f64;
                (0..n).map(|i| (f64::from(v[i]) - mean) * (f64::from(v[(i + lag) % n]) - mean)).sum::<f64>() / n as f64
            };
            for lag in [0, 1, 7, 25, 333] {
                assert!((covariance(&a, lag) - covariance(&b, lag)).abs() < 1e-4, "{n} {lag}");
            }
            assert!(a.iter().zip(&b).any(|(a, b)| (a - b).abs() > 0.3));
            assert_eq!(b, phase_randomised(&a, 1));
            assert_ne!(b, phase_randomised(&a, 2));
        }
    }
}
