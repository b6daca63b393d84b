//! Test signals.

use std::f64::consts::TAU;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// White Gaussian noise of variance 1.
pub(crate) fn gaussian(count: usize, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..count).map(|_| StandardNormal.sample(&mut rng)).collect()
}

/// Rings of a resonance at a repetition rate, each of peak 2 and dying by e in 1/(π·`width_hz`) s.
pub(super) fn impacts(count: usize, rate_hz: f64, repetition_hz: f64, resonance_hz: f64, width_hz: f64) -> Vec<f64> {
    let mut out = vec![0.0; count];
    for strike in 0.. {
        let at = f64::from(strike) / repetition_hz * rate_hz;
        if at >= count as f64 {
            return out;
        }
        let ring = |i: usize| {
            let t = (i as f64 - at) / rate_hz;
            2.0 * (-std::f64::consts::PI * width_hz * t).exp() * (TAU * resonance_hz * t).sin()
        };
        let end = (at + 8.0 * rate_hz / (std::f64::consts::PI * width_hz)) as usize;
        (at.ceil() as usize..end.min(count)).for_each(|i| out[i] += ring(i));
    }
    out
}
