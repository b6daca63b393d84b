//! Filters that every term of the equation of motion passes alike, so that it still holds behind them: theory (63) to (65).
//!
//! A Gaussian kernel of at least 1.2 samples is band-limited: a signal of up to a fifth of the sample rate has aliases of
//! 1e-7. The sampled analytic derivatives are therefore derivatives of the smoothed signal, without the error of central
//! differences at any frequency (the aim of the parallel low-pass and decimation of Gautier, Janot, Vandanjon, "A new
//! closed-loop output error method for parameter identification of robot dynamics", IEEE TCST 21 (2013) 428–444).

use super::settings::BalanceSettings;
use crate::signal::transform::{forward_plan, inverse_plan};

const SETTINGS: BalanceSettings = BalanceSettings::DEFAULT;

/// A finite symmetric or antisymmetric kernel: y_k = Σ_j taps_j x_(k − j + reach).
#[derive(Clone, Debug, PartialEq)]
pub struct Kernel {
    /// Weights; odd count.
    pub taps: Vec<f64>,
    /// Samples on either side of the middle one.
    pub reach: usize,
}

impl Kernel {
    /// Gaussian of a standard deviation in samples, or its derivative of this order (0 to 2) per `step_s`.
    pub fn gaussian(deviation: f64, order: usize, step_s: f64) -> Self {
        Self::delayed(deviation, order, step_s, 0.0, 0.0)
    }

    /// Gaussian, or its derivative, with a delay in samples, and widened by a variance in samples².
    pub fn delayed(deviation: f64, order: usize, step_s: f64, delay: f64, widened: f64) -> Self {
        let variance = deviation * deviation + widened;
        let reach = (SETTINGS.kernel_reach_std * variance.sqrt()).ceil() as usize + 1;
        let tap = |j: usize| {
            let t = j as f64 - reach as f64 - delay;
            let bell = (-0.5 * t * t / variance).exp() / (std::f64::consts::TAU * variance).sqrt();
            match order {
                0 => bell,
                1 => -t / variance * bell / step_s,
                _ => (t * t / variance - 1.0) / variance * bell / (step_s * step_s),
            }
        };
        Self { taps: (0..=2 * reach).map(tap).collect(), reach }
    }

    /// Low-pass that is flat in its band, theory (65): 1 − (1 − G)⁴ of a Gaussian's gain G, or its derivative (twicing,
    /// J. W. Tukey, "Exploratory Data Analysis", 1977). For G = 0.84 the gain is 1 − 7e-4.
    pub fn flat(deviation: f64, order: usize, step_s: f64) -> Self {
        let parts = [(4.0, 1.0), (-6.0, 2.0), (4.0, 3.0), (-1.0, 4.0f64)];
        let each = parts.map(|(weight, times)| (weight, Self::gaussian(deviation * times.sqrt(), order, step_s)));
        let reach = each[3].1.reach;
        let mut taps = vec![0.0; 2 * reach + 1];
        for (weight, kernel) in &each {
            let first = reach - kernel.reach;
            taps[first..].iter_mut().zip(&kernel.taps).for_each(|(sum, tap)| *sum += weight * tap);
        }
        Self { taps, reach }
    }

    /// The filtered signal at some samples, which lie at least `reach` from either end; nearer, the end's value is taken
    /// to go on.
    pub fn at(&self, signal: &[f64], samples: &[usize]) -> Vec<f64> {
        let last = signal.len().saturating_sub(1);
        let one = |&k: &usize| {
            if k >= self.reach && k + self.reach <= last {
                let window = &signal[k - self.reach..=k + self.reach];
                return self.taps.iter().rev().zip(window).map(|(a, b)| a * b).sum();
            }
            let place = |j: usize| (k + self.reach).saturating_sub(j).min(last);
            self.taps.iter().enumerate().map(|(j, tap)| tap * signal[place(j)]).sum()
        };
        samples.iter().map(one).collect()
    }

    /// The filtered signal at every sample.
    pub fn everywhere(&self, signal: &[f64]) -> Vec<f64> {
        self.at(signal, &(0..signal.len()).collect::<Vec<_>>())
    }
}

/// High-pass of a measured acceleration, and its integrals: zero phase, by the Fourier transform, gain G_high of
/// theory (65), whose response does not ring and has decayed after two periods of f₀.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HighPass {
    /// Corner f₀, Hz.
    pub corner_hz: f64,
    /// Samples per second.
    pub sample_rate_hz: f64,
}

impl HighPass {
    /// Samples at either end of a recording at which its integrals are unreliable: two periods of the corner.
    pub fn unreliable(&self) -> usize {
        (2.0 * self.sample_rate_hz / self.corner_hz) as usize
    }

    /// Signal integrated `integrals` times, without frequencies below the corner. The recording is taken to be at rest
    /// before and after; two periods of the corner at either end are unreliable.
    pub fn apply(&self, signal: &[f64], integrals: i32) -> Vec<f64> {
        let n = signal.len();
        let pad = (4.0 * self.sample_rate_hz / self.corner_hz).ceil() as usize;
        let length = (n + pad).next_multiple_of(2);
        let (forward, inverse) = (forward_plan(length), inverse_plan(length));
        let mut real = signal.to_vec();
        real.resize(length, 0.0);
        let mut bins = forward.make_output_vec();
        if forward.process(&mut real, &mut bins).is_err() {
            return vec![0.0; n];
        }
        let last = bins.len() - 1;
        for (k, bin) in bins.iter_mut().enumerate() {
            let hz = k as f64 * self.sample_rate_hz / length as f64;
            if k == 0 || (k == last && integrals != 0) {
                *bin = Default::default();
                continue;
            }
            let gain = (1.0 - (-(hz / self.corner_hz).powi(2)).exp()).powi(2) / length as f64;
            let per_rate = realfft::num_complex::Complex::new(0.0, -1.0 / (std::f64::consts::TAU * hz));
            *bin = *bin * per_rate.powi(integrals) * gain;
        }
        bins[last].im = 0.0;
        if inverse.process(&mut bins, &mut real).is_err() {
            return vec![0.0; n];
        }
        real.truncate(n);
        real
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Derivative of the smoothed signal equals the smoothed derivative, up to a fifth of the sample rate.
    #[test]
    fn invariant_derivatives_of_a_smoothed_tone_are_exact() {
        let (step, omega) = (1e-3, 0.2 * std::f64::consts::TAU / 1e-3);
        let tone: Vec<f64> = (0..200).map(|k| (omega * k as f64 * step).sin()).collect();
        let narrowest = SETTINGS.min_kernel_std;
        let at = |order| Kernel::gaussian(narrowest, order, step).at(&tone, &[100])[0];
        let gain = (-0.5 * (narrowest * omega * step).powi(2)).exp();
        let (s, c) = (omega * 100.0 * step).sin_cos();
        for (order, expected) in [(0, s), (1, omega * c), (2, -omega * omega * s)] {
            assert!((at(order) - gain * expected).abs() < 1e-6 * omega.powi(order as i32), "{order}");
        }
    }

    #[test]
    fn invariant_integrals_of_a_tone_in_the_band() {
        let rate = 500.0;
        let omega = std::f64::consts::TAU * 10.0;
        let tone: Vec<f64> = (0..5000).map(|k| (omega * k as f64 / rate).sin()).collect();
        let pass = HighPass { corner_hz: 2.0, sample_rate_hz: rate };
        let twice = pass.apply(&tone, 2);
        let worst = (1500..3500).map(|k| (twice[k] * omega * omega + tone[k]).abs()).fold(0.0, f64::max);
        assert!(worst < 5e-3, "{worst}");
    }
}
