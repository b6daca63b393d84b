//! Guesses of numbers that recordings show at once: modes, slip of the cage, drift of the speed.

use rayon::prelude::*;

use super::data::{Data, Point};
use super::settings::{GuessSettings, LikelihoodSettings};
use super::stretch::{Range, Stretch};

const SETTINGS: GuessSettings = GuessSettings::DEFAULT;
const LIKELIHOOD: LikelihoodSettings = LikelihoodSettings::DEFAULT;

/// Numbers from which searches start.
#[derive(Clone, Debug, Default)]
pub struct Guesses {
    /// Frequencies near which each channel's power differs most from the prediction, Hz.
    pub peaks_hz: [Vec<f64>; 2],
    /// Shares by which the cage may be slow.
    pub slips: Vec<f64>,
    /// Rates at which the speed may drift, 1/s.
    pub drifts_per_s: Vec<f64>,
}

impl Guesses {
    /// Guesses from recordings under a prediction.
    pub fn new(data: &Data, at: &Point) -> Self {
        Self {
            peaks_hz: [0, 1].map(|channel| peaks_hz(data, at, channel)),
            slips: slips(data, at),
            drifts_per_s: drifts_per_s(data),
        }
    }
}

/// Slip beyond that of a healthy cage with which the lines fit the recordings better.
fn slips(data: &Data, at: &Point) -> Vec<f64> {
    let of = |n: usize| {
        let healthy = Range { around: 0.0, reach: LIKELIHOOD.stretch[0] };
        let any = Range { around: -SETTINGS.slip[0], reach: SETTINGS.slip[1] };
        let prior = |stretch: f64| Stretch::outer_prior(&data.observations[n], stretch);
        let (_, before) = data.outer_stretch(at, n, healthy, prior);
        let (stretch, after) = data.outer_stretch(at, n, any, |_| 0.0);
        (after > before + SETTINGS.slip_gain).then_some(-stretch)
    };
    let mut all: Vec<f64> = (0..data.observations.len()).into_par_iter().filter_map(of).collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() < SETTINGS.same_slip);
    all
}

/// Rates of the tachometers, or a grid without any.
fn drifts_per_s(data: &Data) -> Vec<f64> {
    let rates: Vec<f64> = data.observations.iter().filter_map(|o| Some(o.tachometer?.gains_per_s)).collect();
    if rates.is_empty() {
        return SETTINGS.drifts_per_s.into_iter().flat_map(|rate| [rate, -rate]).collect();
    }
    let mean = rates.iter().sum::<f64>() / rates.len() as f64;
    if mean.abs() > SETTINGS.least_drift_per_s { vec![mean] } else { Vec::new() }
}

/// Frequencies near which the power of a channel differs most from a prediction, Hz, of all recordings.
fn peaks_hz(data: &Data, at: &Point, channel: usize) -> Vec<f64> {
    let band = |hz: f64| (SETTINGS.bands_per_octave * (hz / 100.0).log2()).floor() as i64;
    let mut bands = std::collections::BTreeMap::<i64, [f64; 2]>::new();
    for n in 0..data.observations.len() {
        let spectrum = data.channel(at, n, channel);
        for expected in spectrum.bins() {
            let hz = spectrum.observation.hz(expected.k as f64);
            if hz < SETTINGS.least_mode_hz {
                continue;
            }
            let entry = bands.entry(band(hz)).or_default();
            // Bounded, so that lines do not count as modes.
            entry[0] += (expected.power / expected.mean()).min(SETTINGS.most_power) - SETTINGS.mean_power;
            entry[1] += 1.0;
        }
    }
    let mut found: Vec<(f64, i64)> = bands.iter().map(|(band, [sum, count])| (sum / count.sqrt(), *band)).collect();
    found.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    let mut out: Vec<(f64, i64)> = Vec::new();
    for (z, band) in found {
        if z.abs() > SETTINGS.peak_z
            && out.len() < SETTINGS.peaks
            && out.iter().all(|(_, other)| (other - band).abs() > SETTINGS.apart)
        {
            out.push((z, band));
        }
    }
    out.into_iter().map(|(_, band)| 100.0 * ((band as f64 + 0.5) / SETTINGS.bands_per_octave).exp2()).collect()
}
