//! Where a search in time or frequency can start: what the residual of the nominal rig points at.

use std::f64::consts::TAU;

use rayon::prelude::*;
use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

use super::hypothesis::Pointers;
use super::residual::{Whitened, whitened};
use crate::rig::Rig;
use crate::whittle::likelihood::{Expected, judged};
use crate::whittle::observed::Observed;

/// Width of a band in which a resonance may stand out, Hz.
const BAND_HZ: f64 = 120.0;
/// Harmonics that a speed is judged by.
const HARMONICS: usize = 4;
/// Samples that times are looked for at.
const STEP: usize = 64;
/// Missing samples that are looked for, at most, and the gain in ln L from which they are.
const MISSING: usize = 400;
const MISSED: f64 = 30.0;

/// What the residuals of a few recordings point at.
pub fn of(rig: &Rig, observed: &[Observed], expected: &[Expected]) -> Pointers {
    let Some(machine) = rig.bearing() else { return Pointers::default() };
    let orders = machine.bearing.geometry().orders();
    let residuals = whitened(observed, expected);
    Pointers {
        resonances_hz: resonances(&residuals),
        times_s: times(&residuals),
        drops: drops(observed, expected),
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
    (-500..=500).filter(|k| *k != 0).map(|k| 4e-4 * f64::from(k)).collect()
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

/// When samples may be missing in all recordings, s, and how many: what is expected fits up to that time, and fits again
/// after it once it is moved by as much. A row of balls looks like the next, so that a ball pass more or less is as good; the
/// fewest are taken.
fn drops(observed: &[Observed], expected: &[Expected]) -> Vec<(f64, f64)> {
    let Some(shortest) = observed.iter().map(|o| o.condition.samples).min() else { return Vec::new() };
    let blocks = shortest / STEP;
    let sums: Vec<Vec<Vec<f64>>> = observed.iter().zip(expected).map(|(o, e)| running_misfits(o, e, blocks)).collect();
    let lags = 2 * MISSING + 1;
    // Least misfit without anything missing.
    let whole: f64 = sums.iter().map(|of| of.iter().map(|s| s[blocks]).fold(f64::INFINITY, f64::min)).sum();
    let with = |missing: usize, block: usize| -> f64 {
        let parts = |of: &Vec<Vec<f64>>| {
            let both = |lag: usize| of[lag][block] + of[lag + missing][blocks] - of[lag + missing][block];
            (0..lags - missing).map(both).fold(f64::INFINITY, f64::min)
        };
        sums.iter().map(parts).sum()
    };
    let best = (1..=MISSING).into_par_iter().map(|missing| {
        let at = (4..blocks.saturating_sub(4)).map(|block| (with(missing, block), block));
        let (misfit, block) = at.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0));
        (misfit, missing, block)
    });
    let rate = observed[0].condition.sample_rate_hz;
    let found = best.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(misfit, ..)| whole - misfit > MISSED);
    found.map(|(_, missing, block)| ((block * STEP) as f64 / rate, missing as f64)).into_iter().collect()
}

/// Of every lag of what is expected, from `-MISSING` to `MISSING` samples: the misfit from the beginning to every block.
fn running_misfits(o: &Observed, e: &Expected, blocks: usize) -> Vec<Vec<f64>> {
    let samples = o.condition.samples;
    let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(samples);
    let of_lag = |lag: usize| {
        let lag = lag as f64 - MISSING as f64;
        let step = Complex::from_polar(1.0, TAU * lag / samples as f64);
        let mut sums = vec![0.0; blocks + 1];
        for channel in 0..2 {
            let Some(x) = &o.spectra[channel] else { continue };
            let (mut bins, mut by) = (vec![Complex::default(); x.len()], Complex::new(1.0, 0.0));
            for (k, bin) in bins.iter_mut().enumerate() {
                if judged(x, 1.0).contains(&k) {
                    *bin = (x[k] - e.mean[channel][k] * by) / e.variance[channel][k].sqrt();
                }
                by *= step;
            }
            let mut signal = inverse.make_output_vec();
            inverse.process(&mut bins, &mut signal).unwrap_or_default();
            for (sum, block) in sums[1..].iter_mut().zip(signal.chunks_exact(STEP)) {
                *sum += block.iter().map(|v| v * v).sum::<f64>() / samples as f64;
            }
        }
        // −ln L of real numbers of unit variance.
        let mut total = 0.0;
        sums.iter_mut().for_each(|sum| {
            total += 0.5 * *sum;
            *sum = total;
        });
        sums
    };
    (0..2 * MISSING + 1).into_par_iter().map(of_lag).collect()
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
