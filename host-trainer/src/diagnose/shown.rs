//! Fit of the synthesis to held-out recordings.

use serde::Serialize;

use super::result::{Fit, HeldOut, Left};
use crate::identify::calibrate::distance::log_spectral;
use crate::identify::likelihood::observed::CHANNELS;
use crate::signal::spectrum::welch;
use crate::stats::significance::sign_flip_of;

const SETTINGS: ShownSettings = ShownSettings::DEFAULT;
/// Metric of the fit.
pub const METRIC: &str = "log-spectral distance, dB";

/// Fit of the synthesis to held-out recordings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ShownSettings {
    /// Segment of the distance's densities, samples, theory (61).
    pub segment: usize,
    /// Blocks of frequency whose errors give the p-value. Not tuned: chosen by hand.
    pub blocks: usize,
}

impl ShownSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { segment: 2048, blocks: 24 };
}

/// Squared differences of the logarithms of two densities from the measured one, dB², in blocks of all frequencies.
struct Errors {
    before: Vec<f64>,
    after: Vec<f64>,
    hz: Vec<[f64; 2]>,
}

fn errors(held: &HeldOut) -> Option<Errors> {
    let segment = SETTINGS.segment.min(held.measured.len());
    let of = |samples: &[f64]| welch(&[samples], held.sample_rate_hz, segment);
    let (measured, before, after) = (of(&held.measured)?, of(&held.before)?, of(&held.after)?);
    let floor = 1e-9 * measured.values.iter().copied().fold(0.0, f64::max);
    let width = measured.values.len().div_ceil(SETTINGS.blocks).max(1);
    let mut found = Errors { before: Vec::new(), after: Vec::new(), hz: Vec::new() };
    for from in (0..measured.values.len()).step_by(width) {
        let inside = from..(from + width).min(measured.values.len());
        let mean = |of: &[f64]| {
            let error = |k: usize| (10.0 * (measured.values[k].max(floor) / of[k].max(1e-30)).log10()).powi(2);
            inside.clone().map(error).sum::<f64>() / inside.len() as f64
        };
        found.before.push(mean(&before.values));
        found.after.push(mean(&after.values));
        found.hz.push([inside.start, inside.end].map(|k| k as f64 * measured.step_hz));
    }
    Some(found)
}

/// Fit of the held-out recordings, and what is left.
pub fn fit(held: &[HeldOut], described: String, seed: u64) -> (Fit, Left) {
    let mean = |of: &dyn Fn(&HeldOut) -> Option<f64>| {
        let all: Vec<f64> = held.iter().filter_map(of).collect();
        all.iter().sum::<f64>() / all.len().max(1) as f64
    };
    let before = mean(&|h| log_spectral(&h.measured, &h.before, h.sample_rate_hz));
    let after = mean(&|h| log_spectral(&h.measured, &h.after, h.sample_rate_hz));
    let noise_floor = mean(&|h| Some(of_chance(h.measured.len())));
    let all: Vec<(&HeldOut, Errors)> = held.iter().filter_map(|h| Some((h, errors(h)?))).collect();
    let blocks = |of: fn(&Errors) -> &Vec<f64>| all.iter().flat_map(|(_, e)| of(e).clone()).collect::<Vec<_>>();
    let same = held.iter().all(|h| h.before == h.after);
    let gains = || blocks(|e| &e.before).iter().zip(blocks(|e| &e.after)).map(|(b, a)| b - a).collect::<Vec<_>>();
    let p_value = if same { 1.0 } else { sign_flip_of(&gains(), seed) };
    let beyond = |distance: f64| (distance.powi(2) - noise_floor.powi(2)).max(0.0);
    let share = if before > noise_floor { (beyond(after) / beyond(before)).min(1.0) } else { 0.0 };
    let left = |errors: &Errors| errors.after.iter().sum::<f64>();
    let worst = all.iter().max_by(|a, b| left(&a.1).total_cmp(&left(&b.1)));
    let frequency_hz = worst.map_or_else(Vec::new, |(_, errors)| most(errors, noise_floor));
    let channel = worst.and_then(|(h, _)| CHANNELS.into_iter().find(|c| h.name.ends_with(c))).unwrap_or_default();
    let fit = Fit { metric: METRIC.into(), held_out: described, before, after, noise_floor, p_value };
    (fit, Left { share, frequency_hz, order: Vec::new(), channel: channel.into() })
}

/// Bands where most of the error is left: more than twice the distance of chance.
fn most(errors: &Errors, noise_floor: f64) -> Vec<[f64; 2]> {
    let mut found: Vec<[f64; 2]> = Vec::new();
    for (error, [from, to]) in errors.after.iter().zip(&errors.hz) {
        match found.last_mut() {
            _ if error.sqrt() < 2.0 * noise_floor => {}
            Some(last) if last[1] == *from => last[1] = *to,
            _ => found.push([*from, *to]),
        }
    }
    found
}

/// Band of a held-out signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Name of the signal.
    pub name: String,
    /// Ends, Hz.
    pub hz: [f64; 2],
    /// Measured level over that before and after the correction, dB.
    pub over_db: [f64; 2],
}

/// Third of an octave in which the correction changes the difference to the measured level most; `None` without signals.
pub fn strongest_band(held: &[HeldOut]) -> Option<Band> {
    let bands = held.iter().flat_map(|h| thirds(h).unwrap_or_default());
    let nearer = |band: &Band| band.over_db[0].abs() - band.over_db[1].abs();
    bands.max_by(|a, b| nearer(a).total_cmp(&nearer(b)))
}

/// Thirds of an octave of a signal with at least two bins.
fn thirds(held: &HeldOut) -> Option<Vec<Band>> {
    let segment = SETTINGS.segment.min(held.measured.len());
    let of = |samples: &[f64]| welch(&[samples], held.sample_rate_hz, segment);
    let (measured, before, after) = (of(&held.measured)?, of(&held.before)?, of(&held.after)?);
    let last = measured.values.len() - 1;
    let first = 4.0 * measured.step_hz;
    let count = (3.0 * (last as f64 * measured.step_hz / first).log2()).floor() as usize;
    let band = |n: usize| {
        let hz = [n, n + 1].map(|n| first * (n as f64 / 3.0).exp2());
        let [from, to] = hz.map(|hz| (hz / measured.step_hz).round() as usize);
        let level = |values: &[f64]| 10.0 * values[from..to].iter().sum::<f64>().max(f64::MIN_POSITIVE).log10();
        let over_db = [&before, &after].map(|s| level(&measured.values) - level(&s.values));
        (to >= from + 2).then(|| Band { name: held.name.clone(), hz, over_db })
    };
    Some((0..count).filter_map(band).collect())
}

/// Distance of two recordings of the same noise, dB: a mean over K half-overlapping Hann segments has a relative variance of
/// 1.06/K (P. Welch, IEEE Trans. Audio Electroacoustics 15 (1967) 70–73).
fn of_chance(samples: usize) -> f64 {
    let segment = SETTINGS.segment.min(samples);
    let segments = (2 * samples / segment).saturating_sub(1).max(1) as f64;
    10.0 / std::f64::consts::LN_10 * (2.0 * 1.06 / segments).sqrt()
}
