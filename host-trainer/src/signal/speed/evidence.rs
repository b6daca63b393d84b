//! How far each frequency stands out, over the spectrum and the envelopes of bands side by side.

use rayon::prelude::*;
use realfft::num_complex::Complex;

use crate::signal::Sample;
use crate::signal::kurtogram::Bank;
use crate::signal::lines::{floor, half_width};
use crate::signal::spectrum::{Spectrum, welch};

/// Longest stretch that one transform is taken of, s: ball passes wander, and longer ones do not sharpen them.
const STRETCH_S: f64 = 4.0;
/// Most bands side by side.
const MOST_BANDS: usize = 8;
/// Share of values that stand out of nothing.
const COMMON: f64 = 0.9;

/// Spectra over their noise, and what they add up to.
pub(super) struct Evidence {
    /// Hz from one value of [`total`](Self::total) to the next.
    pub(super) step_hz: f64,
    /// Sum over the spectra of ln(power over what is common), where that is above 0; the greatest of three
    /// neighbours, so that a comb may be a step wide.
    pub(super) total: Vec<f64>,
    /// Power over noise: of the recording, and of the squared envelope of each band.
    pub(super) ratios: Vec<Spectrum>,
    /// Independent stretches averaged over.
    pub(super) averaged: f64,
}

impl Evidence {
    /// Up to a frequency; `None` for a recording too short.
    pub(super) fn from_samples<S: Sample>(samples: &[S], sample_rate_hz: f64, highest_hz: f64) -> Option<Self> {
        let bank = Bank::new(samples, sample_rate_hz)?;
        let duration_s = bank.counted_s();
        let stretch_s = duration_s.min(STRETCH_S);
        let bands = ((bank.nyquist_hz() / (1.1 * highest_hz)) as usize).clamp(1, MOST_BANDS);
        let width = bank.nyquist_hz() / bands as f64;
        let power =
            |values: &[f64], rate_hz: f64| welch(&[values], rate_hz, values.len().min((rate_hz * stretch_s) as usize));
        let raw: Vec<f64> = samples.iter().map(|v| (*v).into()).collect();
        let envelopes: Vec<Option<Spectrum>> = (0..bands)
            .into_par_iter()
            .map(|b| {
                let envelope = bank.envelope(&(width * b as f64..width * (b + 1) as f64), 2);
                let squares: Vec<f64> = envelope.counted().iter().map(Complex::norm_sqr).collect();
                power(&squares, envelope.rate_hz)
            })
            .collect();
        let mut ratios: Vec<Spectrum> = envelopes.into_iter().collect::<Option<_>>()?;
        ratios.push(power(&raw, sample_rate_hz)?);
        for spectrum in &mut ratios {
            spectrum.values.truncate((highest_hz / spectrum.step_hz) as usize + 2);
            let floor = floor(&spectrum.values, half_width(spectrum.step_hz));
            spectrum.values.iter_mut().zip(floor).for_each(|(v, f)| *v = if f > 0.0 { *v / f } else { 0.0 });
        }
        let step_hz = 1.0 / stretch_s;
        let mut sum = vec![0.0; (highest_hz / step_hz) as usize];
        for spectrum in &ratios {
            let common = common(&spectrum.values);
            for (k, total) in sum.iter_mut().enumerate() {
                let at = (k as f64 * step_hz / spectrum.step_hz).round() as usize;
                *total += spectrum.values.get(at).map_or(0.0, |v| (v / common).ln().max(0.0));
            }
        }
        // What is under two steps leaks from the mean.
        sum.iter_mut().take(3).for_each(|v| *v = 0.0);
        let wide = |k: usize| sum[k.saturating_sub(1)..(k + 2).min(sum.len())].iter().copied().fold(0.0, f64::max);
        let total = (0..sum.len()).map(wide).collect();
        let averaged = (2.0 * duration_s / stretch_s - 1.0).max(1.0);
        Some(Self { step_hz, total, ratios, averaged })
    }

    /// At a frequency; nothing beyond the ends.
    pub(super) fn at(&self, frequency_hz: f64) -> f64 {
        let k = (frequency_hz / self.step_hz).round();
        if k < 0.0 { 0.0 } else { self.total.get(k as usize).copied().unwrap_or(0.0) }
    }

    /// Mean and standard deviation of it.
    pub(super) fn spread(&self) -> (f64, f64) {
        let n = self.total.len() as f64;
        let mean = self.total.iter().sum::<f64>() / n;
        let variance = self.total.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
        (mean, variance.sqrt())
    }
}

/// The value that [`COMMON`] of all stay below.
fn common(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get((COMMON * sorted.len() as f64) as usize).copied().unwrap_or(1.0).max(f64::MIN_POSITIVE)
}
