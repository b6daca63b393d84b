//! Transmission path from the rig to the sensor through an unknown structure: an all-pole filter, theory (53).
//!
//! Poles are resonances; zeros are approximated by many of them (J. Makhoul, "Linear prediction: a tutorial review",
//! Proc. IEEE 63 (1975) 561–580). The filter is stored as reflection coefficients, all within ±1, so that every accepted
//! file is a stable filter.

use realfft::num_complex::Complex;

use crate::signal::transform::{forward_plan, inverse_plan};

/// Transmission path of one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct TransmissionPath {
    /// `ax` or `ay`.
    pub channel: String,
    /// Sample rate of the filter, Hz.
    pub sample_rate_hz: f64,
    /// Gain of the input.
    pub gain: f64,
    /// Reflection coefficients, each within ±1.
    pub reflection: Vec<f64>,
}

impl TransmissionPath {
    /// Filter coefficients a_1 … a_p, by Levinson's recursion (Makhoul, eq. 38d).
    pub fn coefficients(&self) -> Vec<f64> {
        let mut a: Vec<f64> = Vec::with_capacity(self.reflection.len());
        for &k in &self.reflection {
            let before = a.clone();
            for (i, value) in a.iter_mut().enumerate() {
                *value += k * before[before.len() - 1 - i];
            }
            a.push(k);
        }
        a
    }

    /// Filters a signal in place, from rest.
    pub fn filter(&self, signal: &mut [f64]) {
        let a = self.coefficients();
        for k in 0..signal.len() {
            let past: f64 = a.iter().zip(signal[..k].iter().rev()).map(|(a, x)| a * x).sum();
            signal[k] = self.gain * signal[k] - past;
        }
    }

    /// Squared gain |H|² at the frequencies of `samples` samples, from 0 to half the sample rate.
    pub fn power(&self, samples: usize) -> Vec<f64> {
        let transform = forward_plan(samples);
        let mut buffer = transform.make_input_vec();
        // A recording shorter than the filter sees its coefficients folded, as its frequencies are.
        for (i, a) in std::iter::once(1.0).chain(self.coefficients()).enumerate() {
            buffer[i % samples] += a;
        }
        let mut out = transform.make_output_vec();
        transform.process(&mut buffer, &mut out).unwrap_or_default();
        out.iter().map(|a| self.gain * self.gain / a.norm_sqr().max(f64::MIN_POSITIVE)).collect()
    }

    /// Samples after which the impulse response stays within `share` of its greatest value; at most `most`.
    pub fn settles_within(&self, share: f64, most: usize) -> usize {
        let mut impulse = vec![0.0; most];
        if let Some(first) = impulse.first_mut() {
            *first = 1.0;
        }
        self.filter(&mut impulse);
        let greatest = impulse.iter().fold(0.0f64, |g, v| g.max(v.abs()));
        impulse.iter().rposition(|v| v.abs() > share * greatest).map_or(0, |last| last + 1)
    }

    /// Filter of `poles` poles fitted to `power`, given at evenly spaced frequencies from 0 to half the sample rate: the
    /// autocorrelation method (Makhoul, section III), which matches peaks better than valleys.
    pub fn of_power(channel: &str, sample_rate_hz: f64, power: &[f64], poles: usize) -> Self {
        let length = 2 * power.len().saturating_sub(1).max(1);
        let inverse = inverse_plan(length);
        let mut spectrum: Vec<Complex<f64>> = power.iter().map(|p| Complex::new(*p, 0.0)).collect();
        spectrum.resize(length / 2 + 1, Complex::default());
        let mut correlation = inverse.make_output_vec();
        inverse.process(&mut spectrum, &mut correlation).unwrap_or_default();
        let r: Vec<f64> = correlation.iter().map(|v| v / length as f64).collect();
        let mut error = r[0].max(f64::MIN_POSITIVE);
        let (mut a, mut reflection): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        for order in 0..poles.min(length / 2) {
            let sum: f64 = r[order + 1] + a.iter().enumerate().map(|(i, a)| a * r[order - i]).sum::<f64>();
            let k = -sum / error;
            let before = a.clone();
            a.iter_mut().enumerate().for_each(|(i, value)| *value += k * before[order - 1 - i]);
            a.push(k);
            reflection.push(k);
            error *= 1.0 - k * k;
        }
        Self { channel: channel.into(), sample_rate_hz, gain: error.sqrt(), reflection }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resonant() -> TransmissionPath {
        TransmissionPath { channel: "ay".into(), sample_rate_hz: 1000.0, gain: 0.3, reflection: vec![-0.4, 0.95, 0.2] }
    }

    #[test]
    fn invariant_the_filter_has_the_power_it_says() {
        let path = resonant();
        let samples = 4096;
        let mut impulse = vec![0.0; samples];
        impulse[0] = 1.0;
        path.filter(&mut impulse);
        let transform = forward_plan(samples);
        let mut out = transform.make_output_vec();
        transform.process(&mut impulse, &mut out).unwrap();
        for (h, p) in out.iter().zip(path.power(samples)) {
            assert!((h.norm_sqr() / p - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn invariant_an_all_pole_power_gives_its_poles_back() {
        let path = resonant();
        let again = TransmissionPath::of_power("ay", 1000.0, &path.power(4096), 5);
        assert!((again.gain / path.gain - 1.0).abs() < 1e-9, "{again:?}");
        let padded = path.reflection.iter().chain(&[0.0, 0.0]);
        assert!(again.reflection.iter().zip(padded).all(|(a, b)| (a - b).abs() < 1e-9), "{again:?}");
    }

    #[test]
    fn a_resonance_takes_its_time_to_settle() {
        let path = resonant();
        let settled = path.settles_within(1e-3, 10_000);
        // |pole|² is about the second coefficient, so 1e-3 is reached after ln 1e-3 / ln √0.95 = 269 samples.
        assert!((200..400).contains(&settled), "{settled}");
    }
}
