//! Change of a channel against the baseline: amplitudes of the shaft's orders, and power in bands.

use super::observation::Observation;
use super::settings::ChangeSettings;
use crate::signal::spectrum::{Spectrum, amplitudes, welch};
use crate::signal::transform::median;

const SETTINGS: ChangeSettings = ChangeSettings::DEFAULT;

/// Change of one channel against the baseline, mean over recordings, dB.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Change {
    /// Change of the amplitude of each order of the shaft from 1, of each recording.
    pub orders: Vec<Vec<f64>>,
    /// Bands with the change of their power, Hz and dB.
    pub bands: Vec<([f64; 2], f64)>,
    /// Median change over bands.
    pub gain_db: f64,
    /// Root mean square of the bands' changes around that.
    pub shape_db: f64,
    /// Spread of the change over bands and recordings.
    pub spread_db: f64,
}

impl Change {
    /// Change of a channel; `None` where nothing in the baseline can be compared.
    pub fn new(recordings: &[Observation], baseline: &[Observation], channel: usize) -> Option<Self> {
        let (mut orders, mut of_bands) = (Vec::new(), Vec::new());
        let edges = edges(recordings.first()?.sample_rate_hz);
        for recording in recordings {
            let Some(samples) = recording.channels[channel].as_deref() else { continue };
            let matches = recording.matches(baseline);
            let healthy: Vec<&[f64]> = matches.iter().filter_map(|m| m.channels[channel].as_deref()).collect();
            if healthy.is_empty() {
                continue;
            }
            let rate = recording.sample_rate_hz;
            if recording.turns() >= SETTINGS.fewest_turns && matches.iter().all(|m| m.turns() >= SETTINGS.fewest_turns)
            {
                orders.extend(order_change(samples, &healthy, rate, recording.shaft_hz));
            }
            of_bands.push(band_change(samples, &healthy, rate, &edges)?);
        }
        let first = of_bands.first()?;
        let count = of_bands.len() as f64;
        let bands: Vec<_> = (0..first.len())
            .map(|k| ([edges[k], edges[k + 1]], of_bands.iter().map(|b| b[k]).sum::<f64>() / count))
            .collect();
        let gain_db = median(&mut bands.iter().map(|b| b.1).collect::<Vec<_>>())?;
        let around = |value: f64| (value - gain_db).clamp(-SETTINGS.most_db, SETTINGS.most_db).powi(2);
        let rms = |values: &[f64]| (values.iter().map(|v| around(*v)).sum::<f64>() / values.len() as f64).sqrt();
        let shape_db = rms(&bands.iter().map(|b| b.1).collect::<Vec<_>>());
        Some(Self { orders, gain_db, shape_db, spread_db: rms(&of_bands.concat()), bands })
    }

    /// Mean change of an order over recordings, dB, with its standard error, which is at least that of the scatter between
    /// healthy machines; `None` without orders.
    pub fn order_db(&self, order: usize) -> Option<[f64; 2]> {
        let values: Vec<f64> = self.orders.iter().filter_map(|o| o.get(order - 1).copied()).collect();
        let count = values.len() as f64;
        if values.is_empty() {
            return None;
        }
        let mean = values.iter().sum::<f64>() / count;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
        Some([mean, variance.max(SETTINGS.order_scatter_db.powi(2)).sqrt() / count.sqrt()])
    }
}

/// Edges of bands of a share of an octave.
fn edges(sample_rate_hz: f64) -> Vec<f64> {
    let octaves = (0.45 * sample_rate_hz / SETTINGS.lowest_hz).log2().max(0.0);
    let count = (SETTINGS.bands_per_octave * octaves) as usize;
    (0..=count.max(1)).map(|k| SETTINGS.lowest_hz * (k as f64 / SETTINGS.bands_per_octave).exp2()).collect()
}

fn band_change(samples: &[f64], healthy: &[&[f64]], rate: f64, edges: &[f64]) -> Option<Vec<f64>> {
    let shortest = healthy.iter().map(|h| h.len()).min()?.min(samples.len());
    let segment = shortest.min(8192);
    let (now, then) = (welch(&[samples], rate, segment)?, welch(healthy, rate, segment)?);
    let mean = |of: &Spectrum, low: f64, high: f64| {
        let from = (low / of.step_hz).round() as usize;
        let to = ((high / of.step_hz).round() as usize).clamp(from + 1, of.values.len().max(from + 1));
        let inside = of.values.get(from..to).unwrap_or(&[]);
        inside.iter().sum::<f64>() / inside.len().max(1) as f64
    };
    let change = |pair: &[f64]| {
        let ratio = mean(&now, pair[0], pair[1]).max(1e-30) / mean(&then, pair[0], pair[1]).max(1e-30);
        10.0 * ratio.log10()
    };
    Some(edges.windows(2).map(change).collect())
}

/// Change of the amplitude of each order, dB.
fn order_change(samples: &[f64], healthy: &[&[f64]], rate: f64, shaft_hz: f64) -> Option<Vec<f64>> {
    let (now, then) = (amplitudes(&[samples], rate)?, amplitudes(healthy, rate)?);
    let power = |of: &Spectrum, order: usize| {
        let hz = order as f64 * shaft_hz;
        let centre = (hz / of.step_hz).round() as usize;
        let reach = 2 + (SETTINGS.order_reach * hz / of.step_hz) as usize;
        let near = of.values.get(centre.saturating_sub(reach)..centre + reach + 1)?;
        Some(near.iter().map(|v| v * v).sum::<f64>().max(1e-30))
    };
    (1..=SETTINGS.orders).map(|k| Some(10.0 * (power(&now, k)? / power(&then, k)?).log10())).collect()
}
