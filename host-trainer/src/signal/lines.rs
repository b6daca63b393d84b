//! Lines of a spectrum and their significance over the noise around, theory (74).

use serde::Serialize;

use super::settings::LineSettings;
use super::spectrum::Spectrum;
use super::transform::median;

const SETTINGS: LineSettings = LineSettings::DEFAULT;

/// A line of an amplitude spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Line {
    /// Expected frequency, Hz.
    pub expected_hz: f64,
    /// Frequency of the greatest value within the tolerance, Hz.
    pub frequency_hz: f64,
    /// Amplitude there, in the spectrum's unit.
    pub amplitude: f64,
    /// Root mean square of the noise around, in the spectrum's unit.
    pub background: f64,
    /// Power over that of the background.
    pub ratio: f64,
    /// p-value of the ratio in Gaussian noise.
    pub p_value: f64,
}

/// Mean power of the noise under each value of a power spectrum, theory (74): the median over `half_width` values to
/// either side, over ln 2, as powers of noise are exponential. Lines do not move a median while they are the fewer.
pub fn floor(powers: &[f64], half_width: usize) -> Vec<f64> {
    let half_width = half_width.max(1);
    let hop = half_width.div_ceil(2);
    let at = |middle: usize| {
        // Without the mean and what leaks from it.
        let from = middle.saturating_sub(half_width).max(2.min(powers.len()));
        let to = (middle + half_width + 1).min(powers.len()).max(from);
        median(&mut powers[from..to].to_vec()).unwrap_or(0.0) / std::f64::consts::LN_2
    };
    let knots: Vec<f64> = (0..=powers.len().div_ceil(hop)).map(|k| at((k * hop).min(powers.len()))).collect();
    let between = |i: usize| {
        let (k, share) = (i / hop, (i % hop) as f64 / hop as f64);
        (1.0 - share) * knots[k] + share * knots[k + 1]
    };
    (0..powers.len()).map(between).collect()
}

/// Values to either side that make the neighbourhood in a spectrum of this step.
pub fn half_width(step_hz: f64) -> usize {
    SETTINGS.min_half_width_bins.max((SETTINGS.min_half_width_hz / step_hz).ceil() as usize)
}

/// An amplitude spectrum with its background.
#[derive(Clone, Debug, PartialEq)]
pub struct Marked<'s> {
    /// Amplitude spectrum.
    pub spectrum: &'s Spectrum,
    /// Root mean square of the noise under each value.
    pub background: Vec<f64>,
}

impl<'s> Marked<'s> {
    /// Background of an amplitude spectrum.
    pub fn new(spectrum: &'s Spectrum) -> Self {
        let powers: Vec<f64> = spectrum.values.iter().map(|v| v * v).collect();
        let background = floor(&powers, half_width(spectrum.step_hz)).into_iter().map(f64::sqrt).collect();
        Self { spectrum, background }
    }

    /// Line of greatest amplitude within a tolerance of a frequency, at least one step; `None` beyond the spectrum.
    pub fn line(&self, expected_hz: f64, tolerance_hz: f64) -> Option<Line> {
        let step = self.spectrum.step_hz;
        let reach = tolerance_hz.max(step);
        let from = ((expected_hz - reach) / step).ceil().max(1.0) as usize;
        let to = ((expected_hz + reach) / step).floor().max(0.0) as usize;
        let values = self.spectrum.values.get(from..=to).filter(|v| !v.is_empty())?;
        let (offset, amplitude) = values.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let background = self.background[from + offset];
        let ratio = if background > 0.0 { (amplitude / background).powi(2) } else { 0.0 };
        // Of the greatest of the values searched.
        let p_value = -(values.len() as f64 * (-(-ratio).exp()).ln_1p()).exp_m1();
        let frequency_hz = (from + offset) as f64 * step;
        Some(Line { expected_hz, frequency_hz, amplitude, background, ratio, p_value })
    }
}

#[cfg(test)]
mod tests {
    use super::super::spectrum::amplitudes;
    use super::super::test_signals::gaussian;
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_tone_stands_out_by_what_it_is_over_the_noise() {
        // A tone of 0.3 in noise of variance 1 over 5 s: under a Hann window the noise has power 4·1.5/n.
        let n = 50_000;
        let samples: Vec<f64> =
            gaussian(n, 3).iter().enumerate().map(|(i, v)| v + 0.3 * (TAU * 0.1 * i as f64).sin()).collect();
        let spectrum = amplitudes(&[&samples], 10_000.0).unwrap();
        let line = Marked::new(&spectrum).line(1000.3, 0.5).unwrap();
        assert!((line.frequency_hz - 1000.0).abs() < 0.11, "{line:?}");
        assert!((line.amplitude - 0.3).abs() < 0.03, "{line:?}");
        let expected = (6.0 / n as f64).sqrt();
        assert!((line.background / expected - 1.0).abs() < 0.2, "{line:?} {expected}");
        assert!(line.p_value < 1e-12);
    }

    #[test]
    fn null_p_values_of_noise_are_even() {
        let samples = gaussian(100_000, 9);
        let spectrum = amplitudes(&[&samples], 10_000.0).unwrap();
        let marked = Marked::new(&spectrum);
        let p: Vec<f64> = (1..400).map(|k| marked.line(f64::from(k) * 12.0, 0.05).unwrap().p_value).collect();
        for level in [0.05, 0.2, 0.5] {
            let share = p.iter().filter(|p| **p < level).count() as f64 / p.len() as f64;
            // Neighbours under a Hann window are no independent draws: the rule errs to the safe side.
            assert!(share < 1.25 * level + 0.02 && share > 0.5 * level, "{share} of {level}");
        }
    }
}
