//! Modulation of a recording's power, band by band: squared-envelope spectra over their mean, theory (72).

use std::ops::Range;

use rayon::prelude::*;
use realfft::num_complex::Complex;

use super::settings::ModulationSettings;
use crate::signal::transform::{forward, hann, inverse_complex, median};

const SETTINGS: ModulationSettings = ModulationSettings::DEFAULT;

/// Spectrum of the squared envelope of a band.
#[derive(Clone, Debug, PartialEq)]
pub struct Modulated {
    /// Squared amplitude of the relative modulation of the power; a train of short impacts has 4 in each line.
    pub power: Vec<f64>,
    /// Mean of what noise alone would have around each value.
    pub floor: Vec<f64>,
    /// Number of values that the band can show.
    pub shown: usize,
}

/// Modulation of one channel of one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Modulation {
    /// Orders of the shaft from one value to the next.
    pub order_step: f64,
    /// One for each band.
    pub bands: Vec<Modulated>,
}

/// Whether tones are limited before the envelope is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tones {
    /// Spectrum whitened, tones limited: for detection.
    Limited,
    /// Spectrum as it is: for synthesis.
    Kept,
}

/// Bands of the 1/3-binary tree that show the modulations of a bearing whose inner race the balls pass at up to
/// `fastest_hz`.
pub fn bands(sample_rate_hz: f64, fastest_hz: f64) -> Vec<Range<f64>> {
    let nyquist = 0.5 * sample_rate_hz;
    let least = SETTINGS.narrowest_ball_passes * fastest_hz;
    let mut counts: Vec<u32> = (0..8).flat_map(|k| [1 << k, 3 << k]).filter(|c| *c <= SETTINGS.most_bands).collect();
    counts.sort_unstable();
    counts.retain(|count| *count == 1 || nyquist / f64::from(*count) >= least);
    counts.into_iter().flat_map(|count| partition(nyquist, count as usize)).collect()
}

/// Bands of equal width up to Nyquist's frequency.
pub fn partition(nyquist_hz: f64, count: usize) -> Vec<Range<f64>> {
    let width = nyquist_hz / count as f64;
    (0..count).map(|i| width * i as f64..width * (i + 1) as f64).collect()
}

impl Modulation {
    /// Modulation of a signal in bands, up to `highest_hz`; `None` for fewer than 64 samples.
    pub fn new(
        samples: &[f64],
        sample_rate_hz: f64,
        shaft_hz: f64,
        bands: &[Range<f64>],
        highest_hz: f64,
        tones: Tones,
    ) -> Option<Self> {
        if samples.len() < 64 || shaft_hz <= 0.0 {
            return None;
        }
        let step_hz = sample_rate_hz / samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        let mut bins = forward(&mut samples.iter().map(|v| v - mean).collect::<Vec<_>>());
        if tones == Tones::Limited {
            limit(&mut bins, step_hz);
        }
        let reach = ((0.5 * shaft_hz / step_hz) as usize).clamp(SETTINGS.floor_bins[0], SETTINGS.floor_bins[1]);
        let of = |band: &Range<f64>| {
            let shown_hz = highest_hz.min(SETTINGS.usable_share * (band.end - band.start));
            let power = squared_envelope(&bins, step_hz, band, shown_hz);
            let floor = floor(&power, reach);
            let shown = power.len();
            Modulated { power, floor, shown }
        };
        Some(Self { order_step: step_hz / shaft_hz, bands: bands.par_iter().map(of).collect() })
    }
}

/// Divides a spectrum by its local median, and limits what is far above it.
fn limit(bins: &mut [Complex<f64>], step_hz: f64) {
    let reach = ((0.5 * SETTINGS.whitening_hz / step_hz) as usize).max(12);
    let amplitudes: Vec<f64> = bins.iter().map(|b| b.norm()).collect();
    let local = local_median(&amplitudes, reach);
    for ((bin, amplitude), local) in bins.iter_mut().zip(&amplitudes).zip(&local) {
        let local = local.max(f64::MIN_POSITIVE.sqrt());
        let limited = (SETTINGS.tone_limit * local / amplitude.max(f64::MIN_POSITIVE)).min(1.0);
        *bin *= limited / local;
    }
}

/// Squared amplitudes of the relative modulation of a band's power, up to `shown_hz`.
fn squared_envelope(bins: &[Complex<f64>], step_hz: f64, band: &Range<f64>, shown_hz: f64) -> Vec<f64> {
    let last = bins.len() - 1;
    let low = ((band.start / step_hz) as usize).clamp(1, last);
    let high = ((band.end / step_hz) as usize).clamp(low + 1, last.max(low + 1));
    let mut cut = bins[low..high.min(bins.len())].to_vec();
    if cut.len() < 8 {
        return Vec::new();
    }
    // Twice as long, so that the square does not fold back.
    cut.resize(2 * cut.len(), Complex::default());
    let mut power: Vec<f64> = inverse_complex(&cut).iter().map(Complex::norm_sqr).collect();
    let mean = power.iter().sum::<f64>() / power.len() as f64;
    let window = hann(power.len());
    let weight = 0.5 * window.iter().sum::<f64>();
    let scale = 1.0 / mean.max(f64::MIN_POSITIVE);
    power.iter_mut().zip(&window).for_each(|(p, w)| *p = (*p * scale - 1.0) * w);
    let mut spectrum = forward(&mut power);
    spectrum.truncate((shown_hz / step_hz) as usize + 2);
    spectrum.iter().map(|v| v.norm_sqr() / (weight * weight)).collect()
}

/// Mean that exponential noise of the local median would have.
pub fn floor(power: &[f64], reach: usize) -> Vec<f64> {
    local_median(power, reach).iter().map(|m| (m / std::f64::consts::LN_2).max(f64::MIN_POSITIVE)).collect()
}

/// Median of the values within `reach` of each, at every quarter of that and linear between.
fn local_median(values: &[f64], reach: usize) -> Vec<f64> {
    let count = values.len();
    if count == 0 {
        return Vec::new();
    }
    let step = (reach / 4).max(1);
    let at = |centre: usize| {
        let mut near = values[centre.saturating_sub(reach)..(centre + reach + 1).min(count)].to_vec();
        median(&mut near).unwrap_or_default()
    };
    let knots: Vec<f64> = (0..=count.div_ceil(step)).map(|k| at((k * step).min(count - 1))).collect();
    let value = |k: usize| {
        let (knot, part) = (k / step, (k % step) as f64 / step as f64);
        knots[knot] * (1.0 - part) + knots[(knot + 1).min(knots.len() - 1)] * part
    };
    (0..count).map(value).collect()
}
