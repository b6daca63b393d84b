//! Where a search in time or frequency can start: what the residual of the nominal rig points at.

use std::f64::consts::TAU;

use rayon::prelude::*;
use realfft::num_complex::Complex;

use super::hypothesis::Pointers;
use super::residual::Whitened;
use crate::rig::Rig;
use crate::whittle::observed::Observed;

/// Width of a band in which a resonance may stand out, Hz.
const BAND_HZ: f64 = 120.0;
/// Harmonics that a speed is judged by.
const HARMONICS: usize = 4;
/// Samples that times are looked for at.
const STEP: usize = 64;

/// What the residuals of a few recordings point at.
pub fn of(rig: &Rig, observed: &[Observed], residuals: &[Whitened]) -> Pointers {
    let Some(machine) = rig.bearing() else { return Pointers::default() };
    let orders = machine.bearing.geometry().orders();
    Pointers {
        resonances_hz: resonances(residuals),
        times_s: times(residuals),
        slips: best(&slips(), |slip| score(observed, |shaft_hz, t| orders.bpfo * shaft_hz * (1.0 - slip) * t)),
        drifts_per_s: best(&drifts(), |rate| {
            score(observed, |shaft_hz, t| orders.bpfo * shaft_hz * (t + 0.5 * rate * t * t))
        }),
    }
}

fn slips() -> Vec<f64> {
    (1..=160).map(|k| 1e-3 * f64::from(k)).chain((1..=40).map(|k| -5e-4 * f64::from(k))).collect()
}

fn drifts() -> Vec<f64> {
    (-80..=80).filter(|k| *k != 0).map(|k| 2.5e-3 * f64::from(k)).collect()
}

/// The two of these with the highest scores, where they are above half of that of 0.
fn best(values: &[f64], score: impl Fn(f64) -> f64 + Sync) -> Vec<f64> {
    let none = score(0.0);
    let mut scored: Vec<(f64, f64)> = values.par_iter().map(|v| (score(*v), *v)).collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    scored.truncate(2);
    scored.into_iter().filter(|(s, _)| *s > 0.5 * none).map(|(_, v)| v).collect()
}

/// Power of each recording's first channel at harmonics of a phase, `turns` of the shaft's speed in Hz and the time in s.
fn score(observed: &[Observed], turns: impl Fn(f64, f64) -> f64) -> f64 {
    let mut sum = 0.0;
    for o in observed {
        let Some(signal) = o.samples.iter().flatten().next() else { continue };
        let (shaft_hz, rate) = (o.condition.shaft_hz, o.condition.sample_rate_hz);
        let mut lines = [Complex::<f64>::default(); HARMONICS];
        for (i, value) in signal.iter().enumerate() {
            let unit = Complex::from_polar(1.0, -TAU * turns(shaft_hz, i as f64 / rate));
            let mut turn = unit;
            for line in &mut lines {
                *line += turn * *value;
                turn *= unit;
            }
        }
        sum += lines.iter().map(|l| l.norm_sqr()).sum::<f64>();
    }
    sum
}

/// The two bands of `ay`'s residual that stand out most.
fn resonances(residuals: &[Whitened]) -> Vec<f64> {
    let of: Vec<&Whitened> = residuals.iter().filter(|w| w.channel == 1).collect();
    let Some(first) = of.first() else { return Vec::new() };
    let nyquist = 0.5 * first.sample_rate_hz;
    let count = (nyquist / BAND_HZ).ceil() as usize;
    let mut bands = vec![(0.0, 0usize); count + 1];
    for w in &of {
        let step = w.sample_rate_hz / w.signal.len() as f64;
        for (k, bin) in w.spectrum.iter().enumerate().skip(1) {
            let band = &mut bands[((k as f64 * step / BAND_HZ) as usize).min(count)];
            // Lines count little, a hill much.
            band.0 += bin.norm_sqr().max(1e-9).ln();
            band.1 += 1;
        }
    }
    let mut level: Vec<(f64, f64)> = bands
        .iter()
        .enumerate()
        .filter(|(_, (_, n))| *n > 8)
        .map(|(k, (sum, n))| (sum / *n as f64, (k as f64 + 0.5) * BAND_HZ))
        .collect();
    level.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut out: Vec<f64> = Vec::new();
    for (_, hz) in level {
        if out.len() < 2 && out.iter().all(|o| (o - hz).abs() > 4.0 * BAND_HZ) {
            out.push(hz);
        }
    }
    out
}

/// When the residual's power changes most for good, and when its greatest burst is.
fn times(residuals: &[Whitened]) -> Vec<f64> {
    let Some(shortest) = residuals.iter().map(|w| w.signal.len()).min() else { return Vec::new() };
    let rate = residuals[0].sample_rate_hz;
    let blocks = shortest / STEP;
    let mut level = vec![0.0; blocks];
    for w in residuals {
        for (block, part) in level.iter_mut().zip(w.signal.chunks_exact(STEP)) {
            *block += (part.iter().map(|v| v * v).sum::<f64>() / STEP as f64).max(1e-6).ln();
        }
    }
    let total: f64 = level.iter().sum();
    let (mut sum, mut change) = (0.0, (0.0, 0usize));
    for k in 1..blocks {
        sum += level[k - 1];
        let (n, m) = (k as f64, (blocks - k) as f64);
        let difference = (sum / n - (total - sum) / m).abs() * (n * m / blocks as f64).sqrt();
        if difference > change.0 {
            change = (difference, k);
        }
    }
    let burst = level.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(k, _)| k);
    // Within the block, the first sample of the burst that stands out.
    let from = burst.saturating_sub(1) * STEP;
    let onset = (from..(from + 3 * STEP).min(shortest))
        .find(|i| residuals.iter().map(|w| w.signal[*i].powi(2)).sum::<f64>() > 20.0 * residuals.len() as f64);
    let mut out = vec![(change.1 * STEP) as f64 / rate, (burst * STEP) as f64 / rate];
    out.extend(onset.map(|i| i as f64 / rate));
    out
}
