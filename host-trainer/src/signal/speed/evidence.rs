//! Evidence over frequency for theory (79), from the spectrum and the envelopes of adjacent bands.

use rayon::prelude::*;
use realfft::num_complex::Complex;

use super::settings::EvidenceSettings;
use crate::signal::Sample;
use crate::signal::kurtogram::Bank;
use crate::signal::lines::{floor, half_width};
use crate::signal::spectrum::{Spectrum, welch};

const SETTINGS: EvidenceSettings = EvidenceSettings::DEFAULT;

/// Spectra over their noise, and their sum in logarithms.
pub(super) struct Evidence {
    /// Step of [`total`](Self::total), Hz.
    pub(super) step_hz: f64,
    /// Sum over the spectra of ln(power over noise over its quantile), where above 0; the greatest of three
    /// neighbours, so that a tooth may be a step off.
    pub(super) total: Vec<f64>,
    /// Power over noise of the squared envelope of each band and, last, of the recording.
    pub(super) ratios: Vec<Spectrum>,
    /// Independent stretches averaged over.
    pub(super) averaged: f64,
}

impl Evidence {
    /// Evidence up to a frequency; `None` for a recording too short.
    pub(super) fn from_samples<S: Sample>(samples: &[S], sample_rate_hz: f64, highest_hz: f64) -> Option<Self> {
        let bank = Bank::new(samples, sample_rate_hz)?;
        let duration_s = bank.counted_s();
        let stretch_s = duration_s.min(SETTINGS.max_stretch_s);
        let bands = ((bank.nyquist_hz() / (SETTINGS.band_margin * highest_hz)) as usize).clamp(1, SETTINGS.max_bands);
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
            let common = quantile(&spectrum.values);
            for (k, total) in sum.iter_mut().enumerate() {
                let at = (k as f64 * step_hz / spectrum.step_hz).round() as usize;
                *total += spectrum.values.get(at).map_or(0.0, |v| (v / common).ln().max(0.0));
            }
        }
        // The mean leaks over two steps.
        sum.iter_mut().take(3).for_each(|v| *v = 0.0);
        let wide = |k: usize| sum[k.saturating_sub(1)..(k + 2).min(sum.len())].iter().copied().fold(0.0, f64::max);
        let total = (0..sum.len()).map(wide).collect();
        let averaged = (2.0 * duration_s / stretch_s - 1.0).max(1.0);
        Some(Self { step_hz, total, ratios, averaged })
    }

    /// Evidence at a frequency; 0 beyond the ends.
    pub(super) fn at(&self, frequency_hz: f64) -> f64 {
        let k = (frequency_hz / self.step_hz).round();
        if k < 0.0 { 0.0 } else { self.total.get(k as usize).copied().unwrap_or(0.0) }
    }

    /// Mean and standard deviation over frequency.
    pub(super) fn spread(&self) -> (f64, f64) {
        let n = self.total.len() as f64;
        let mean = self.total.iter().sum::<f64>() / n;
        let variance = self.total.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
        (mean, variance.sqrt())
    }
}

/// Quantile that counts as noise.
fn quantile(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get((SETTINGS.noise_quantile * sorted.len() as f64) as usize).copied().unwrap_or(1.0).max(f64::MIN_POSITIVE)
}
