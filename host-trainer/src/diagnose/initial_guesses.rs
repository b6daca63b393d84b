//! Initial guesses of times, frequencies and rates from the residual of the nominal rig.

use std::f64::consts::TAU;

use rayon::prelude::*;
use realfft::num_complex::Complex;

use super::hypothesis::{Gap, InitialGuesses};
use super::residual::{Whitened, whitened};
use crate::identify::likelihood::observed::Observed;
use crate::identify::likelihood::whittle::{Prediction, judged_bins};
use crate::rig::{OperatingCondition, Rig};
use crate::signal::transform::inverse_plan;

/// Width of a band in which a resonance may stand out, Hz.
const BAND_HZ: f64 = 120.0;
/// Harmonics that a speed is judged by.
const HARMONICS: usize = 4;
/// Times that the place of a speed is narrowed to two thirds.
const NARROWINGS: usize = 20;
/// Samples that times are looked for at.
const STEP: usize = 64;
/// Drift below which rounding may be all that a tachometer shows, 1/s.
const SLOWEST_DRIFT_PER_S: f64 = 1e-6;
/// Missing samples that are looked for, at most, and the gain in ln L from which they are.
const MISSING: usize = 400;
const MISSED: f64 = 30.0;

/// Initial guesses from the residuals of a subset of the recordings.
pub fn initial_guesses(rig: &Rig, observed: &[Observed], expected: &[Prediction]) -> InitialGuesses {
    let Some(machine) = rig.bearing() else { return InitialGuesses::default() };
    let orders = machine.bearing.geometry().orders();
    let residuals = whitened(observed, expected);
    let passing: Vec<Slow> = observed.iter().zip(expected).flat_map(|(o, e)| slow(o, e, orders.bpfo)).collect();
    InitialGuesses {
        resonances_hz: resonances(&residuals),
        times_s: times(&residuals),
        gap: gap(observed, expected),
        slips: best(&slips(), |slip| score(&passing, |shaft_hz, t| orders.bpfo * shaft_hz * (1.0 - slip) * t)),
        drifts_per_s: by_tachometers(observed).unwrap_or_else(|| {
            best(&drifts(), |rate| score(&passing, |shaft_hz, t| orders.bpfo * shaft_hz * (t + 0.5 * rate * t * t)))
        }),
    }
}

/// The rate at which the speed drifts, where every recording has a tachometer.
fn by_tachometers(observed: &[Observed]) -> Option<Vec<f64>> {
    let rates: Vec<f64> = observed.iter().map(|o| Some(o.tachometer?.gains_per_s)).collect::<Option<_>>()?;
    let mean = rates.iter().sum::<f64>() / rates.len() as f64;
    Some(vec![mean].into_iter().filter(|rate| rate.abs() > SLOWEST_DRIFT_PER_S).collect())
}

fn slips() -> Vec<f64> {
    (-40..=320).map(|k| 5e-4 * f64::from(k)).collect()
}

fn drifts() -> Vec<f64> {
    (-500..=500).map(|k| 4e-4 * f64::from(k)).collect()
}

/// Of evenly spaced values those two at which the score is highest among its neighbours, 0 aside, and between these the
/// highest place: the many balls that pass in a recording tell more than the spacing, and waveforms are alike but there.
fn best(values: &[f64], score: impl Fn(f64) -> f64 + Sync) -> Vec<f64> {
    let scores: Vec<f64> = values.par_iter().map(|v| score(*v)).collect();
    let peak = |i: &usize| scores[*i] >= scores[i - 1] && scores[*i] > scores[i + 1] && values[*i] != 0.0;
    let mut peaks: Vec<usize> = (1..values.len() - 1).filter(peak).collect();
    peaks.sort_by(|a, b| scores[*b].total_cmp(&scores[*a]));
    let highest = |i: usize| {
        let (mut from, mut to) = (values[i - 1], values[i + 1]);
        for _ in 0..NARROWINGS {
            let thirds = [1.0, 2.0].map(|n| from + (to - from) * n / 3.0);
            let [low, high] = thirds.map(&score);
            if low < high { from = thirds[0] } else { to = thirds[1] }
        }
        0.5 * (from + to)
    };
    peaks.into_iter().take(2).map(highest).collect()
}

/// What is slow in one channel of a recording, its ends faded, in shares of its random part.
struct Slow {
    signal: Vec<f64>,
    rate_hz: f64,
    shaft_hz: f64,
}

/// Every channel of a recording up to the last harmonic that a speed is judged by, at `order` turns of the shaft, and a
/// quarter more.
fn slow(o: &Observed, e: &Prediction, order: f64) -> Vec<Slow> {
    let OperatingCondition { samples, sample_rate_hz, shaft_hz, .. } = o.condition;
    let highest = 1.25 * HARMONICS as f64 * order * shaft_hz;
    let wanted = (highest * samples as f64 / sample_rate_hz).ceil() as usize;
    let of = |channel: usize| {
        let x = o.spectra[channel].as_ref()?;
        let known = judged_bins(x, 1.0);
        let kept = wanted.clamp(2, known.end);
        let mut bins = vec![Complex::default(); kept + 1];
        for k in known.start..kept {
            bins[k] = x[k] / e.noise.variance[channel][k].sqrt();
        }
        let inverse = inverse_plan(2 * kept);
        let mut signal = inverse.make_output_vec();
        inverse.process(&mut bins, &mut signal).ok()?;
        let phase = |i: usize| TAU * (i as f64 + 0.5) / (2 * kept) as f64;
        signal.iter_mut().enumerate().for_each(|(i, v)| *v *= 0.5 - 0.5 * phase(i).cos());
        Some(Slow { signal, rate_hz: sample_rate_hz * (2 * kept) as f64 / samples as f64, shaft_hz })
    };
    (0..2).filter_map(of).collect()
}

/// Power at harmonics of a phase, `turns` of the shaft's speed in Hz and the time in s.
fn score(recordings: &[Slow], turns: impl Fn(f64, f64) -> f64) -> f64 {
    let of = |Slow { signal, rate_hz, shaft_hz }: &Slow| {
        let mut lines = [Complex::<f64>::default(); HARMONICS];
        for (i, value) in signal.iter().enumerate() {
            let unit = Complex::from_polar(1.0, -TAU * turns(*shaft_hz, i as f64 / rate_hz));
            let mut turn = unit;
            for line in &mut lines {
                *line += turn * *value;
                turn *= unit;
            }
        }
        lines.iter().map(|l| l.norm_sqr()).sum::<f64>() / (signal.len() as f64).powi(2)
    };
    recordings.iter().map(of).sum()
}

/// When samples may be missing in all recordings, s, and how many: what is expected fits up to that time, and fits again
/// after it once it is moved by as much. A row of balls looks like the next, so that a ball pass more or less is as good; the
/// fewest are taken.
fn gap(observed: &[Observed], expected: &[Prediction]) -> Option<Gap> {
    let shortest = observed.iter().map(|o| o.condition.samples).min()?;
    let blocks = shortest / STEP;
    let sums: Vec<Vec<Vec<f64>>> = observed.iter().zip(expected).map(|(o, e)| running_misfits(o, e, blocks)).collect();
    let lags = 2 * MISSING + 1;
    // Least neg_log_likelihood without anything missing.
    let whole: f64 = sums.iter().map(|of| of.iter().map(|s| s[blocks]).fold(f64::INFINITY, f64::min)).sum();
    // The lag of a recording before the gap, and the neg_log_likelihood with it.
    let parted = |of: &Vec<Vec<f64>>, missing: usize, block: usize| -> (f64, usize) {
        let both = |lag: usize| (of[lag][block] + of[lag + missing][blocks] - of[lag + missing][block], lag);
        let found = (0..lags - missing).map(both).min_by(|a, b| a.0.total_cmp(&b.0));
        found.unwrap_or((f64::INFINITY, MISSING))
    };
    let with = |missing, block| -> f64 { sums.iter().map(|of| parted(of, missing, block).0).sum() };
    let best = (1..=MISSING).into_par_iter().map(|missing| {
        let at = (4..blocks.saturating_sub(4)).map(|block| (with(missing, block), block));
        let (neg_log_likelihood, block) = at.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0));
        (neg_log_likelihood, missing, block)
    });
    let found =
        best.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(neg_log_likelihood, ..)| whole - neg_log_likelihood > MISSED);
    let (_, missing, block) = found?;
    let lags: Vec<usize> = sums.iter().map(|of| parted(of, missing, block).1).collect();
    let sample = first_missing(observed, expected, &lags, missing, block);
    Some(Gap {
        time_s: sample as f64 / observed[0].condition.sample_rate_hz,
        count: missing as f64,
        leads: lags.iter().map(|lag| *lag as i64 - MISSING as i64).collect(),
    })
}

/// The sample from which on the later lag of each recording suits it better, near a block.
fn first_missing(
    observed: &[Observed],
    expected: &[Prediction],
    lags: &[usize],
    missing: usize,
    block: usize,
) -> usize {
    let near = (block - 1) * STEP..(block + 1) * STEP;
    let mut saved = vec![0.0; near.len()];
    for ((o, e), lag) in observed.iter().zip(expected).zip(lags) {
        let (early, late) = (misfit_of_lag(o, e, *lag), misfit_of_lag(o, e, lag + missing));
        saved.iter_mut().zip(near.clone()).for_each(|(saved, i)| *saved += late[i] - early[i]);
    }
    let (mut sum, mut best) = (0.0, (0.0, near.start));
    for (i, saved) in near.zip(saved) {
        sum += saved;
        if sum > best.0 {
            best = (sum, i + 1);
        }
    }
    best.1
}

/// Of every lag of what is expected, from `-MISSING` to `MISSING` samples: the neg_log_likelihood from the beginning to every block.
fn running_misfits(o: &Observed, e: &Prediction, blocks: usize) -> Vec<Vec<f64>> {
    let of_lag = |lag: usize| {
        let mut total = 0.0;
        let each = misfit_of_lag(o, e, lag);
        let block = |part: &[f64]| {
            total += part.iter().sum::<f64>();
            total
        };
        std::iter::once(0.0).chain(each.chunks_exact(STEP).map(block)).take(blocks + 1).collect()
    };
    (0..2 * MISSING + 1).into_par_iter().map(of_lag).collect()
}

/// What every sample adds to −ln L, of real numbers of unit variance, where what is expected comes `lag - MISSING` samples
/// earlier.
fn misfit_of_lag(o: &Observed, e: &Prediction, lag: usize) -> Vec<f64> {
    let samples = o.condition.samples;
    let inverse = inverse_plan(samples);
    let step = Complex::from_polar(1.0, TAU * (lag as f64 - MISSING as f64) / samples as f64);
    let mut neg_log_likelihood = vec![0.0; samples];
    for channel in 0..2 {
        let Some(x) = &o.spectra[channel] else { continue };
        let (mut bins, mut by) = (vec![Complex::default(); x.len()], Complex::new(1.0, 0.0));
        for (k, bin) in bins.iter_mut().enumerate() {
            if judged_bins(x, 1.0).contains(&k) {
                *bin = (x[k] - e.mean[channel][k] * by) / e.noise.variance[channel][k].sqrt();
            }
            by *= step;
        }
        let mut signal = inverse.make_output_vec();
        inverse.process(&mut bins, &mut signal).unwrap_or_default();
        neg_log_likelihood.iter_mut().zip(&signal).for_each(|(sum, v)| *sum += 0.5 * v * v / samples as f64);
    }
    neg_log_likelihood
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_speed_is_found_between_the_values_that_are_tried() {
        let peak = |value: f64| 1.0 / (1.0 + ((value - 0.018_367) / 3e-4).powi(2));
        let found = best(&slips(), peak);
        assert_eq!(found.len(), 1);
        assert!((found[0] - 0.018_367).abs() < 1e-6, "{found:?}");
    }
}
