//! Fifth stage: causes fitted by simulation, and judged by simulations of what they were not fitted to.
//!
//! Recordings are cut into windows. Each is simulated from a start of its own, fitted to it, as any user could do; the
//! window is as long as the corrected rig's error allows. The published errors are those of these windows, each simulated
//! with parameters from the other folds.

use rayon::prelude::*;

use super::acquire::{Acquired, frequency_hz};
use super::blocks::gain_p;
use super::causes::Cause;
use super::settings::SdofSettings;
use super::table::in_turn;
use crate::identify::force_balance::equation::Parameter;
use crate::identify::force_balance::regression::Fit;
use crate::identify::force_balance::shooting::{self, Observed, Refined, Span};
use crate::rig::Rig;
use crate::rig::config::RigKey;
use crate::stats::significance::{Z975, t975};

const SETTINGS: SdofSettings = SdofSettings::DEFAULT;

/// A rig fitted by simulation.
#[derive(Clone, Debug)]
pub struct SimulatedFit {
    /// Rig with the fitted values.
    pub rig: Rig,
    /// Keys that were fitted.
    pub keys: Vec<RigKey>,
    /// Values, and half the widths of their 95 % intervals; no width where the fit has none.
    pub values: Vec<(f64, Option<f64>)>,
    /// Rig of each fold, fitted without it.
    folds: Vec<Rig>,
    /// RMS of the simulation.
    pub rms: f64,
}

/// Windows, and the fold of each.
#[derive(Clone, Debug)]
pub struct Windows {
    /// Windows of the recordings under test, in order.
    pub spans: Vec<Span>,
    folds: Vec<usize>,
    /// Length, samples of the first recording.
    pub length: usize,
    /// Whether folds are recordings, not blocks of time.
    pub by_recording: bool,
}

impl Windows {
    /// Windows of about `length` samples at the first recording's rate.
    pub fn new(acquired: &Acquired, length: usize) -> Self {
        let count = acquired.under_test().count();
        let rate = acquired.tracks[0].sample_rate_hz;
        let total: usize = acquired.under_test().map(|t| t.len()).sum();
        let by_recording = count >= SETTINGS.folds;
        let (mut spans, mut tracks) = (Vec::new(), Vec::new());
        for (index, track) in acquired.tracks.iter().enumerate().filter(|(_, t)| !t.healthy) {
            let valid = track.valid();
            let samples = valid.len();
            let each =
                ((length as f64 * track.sample_rate_hz / rate) as usize).clamp(SETTINGS.min_block, samples.max(1));
            let windows = (samples / each).max(1);
            let cut = |k: usize| valid.start + k * samples / windows;
            spans.extend((0..windows).map(|k| Span { track: index, first: cut(k), last: cut(k + 1) }));
            tracks.push(index);
        }
        let starts: Vec<usize> = tracks
            .iter()
            .scan(0, |sum, n| {
                let start = *sum;
                *sum += acquired.tracks[*n].len();
                Some(start)
            })
            .collect();
        let fold = |span: &Span| {
            let number = tracks.iter().position(|n| *n == span.track).unwrap_or_default();
            let middle = starts[number] + (span.first + span.last) / 2;
            in_turn(count, number, middle as f64 / total.max(1) as f64)
        };
        let folds = spans.iter().map(fold).collect();
        Self { spans, folds, length, by_recording }
    }

    fn outside(&self, fold: usize) -> Vec<Span> {
        thinned(self.spans.iter().zip(&self.folds).filter(|(_, f)| **f != fold).map(|(s, _)| *s).collect())
    }
}

/// Evenly spread windows of which there are no more samples than a fit takes, but at least one a fold.
fn thinned(spans: Vec<Span>) -> Vec<Span> {
    let total: usize = spans.iter().map(|s| s.last - s.first).sum();
    let share = (SETTINGS.simulated_samples as f64 / total.max(1) as f64).min(1.0);
    let count = ((share * spans.len() as f64) as usize).clamp(SETTINGS.folds.min(spans.len()), spans.len());
    (0..count).map(|n| spans[n * spans.len() / count]).collect()
}

/// Shortest window, samples of the first recording: some periods of the motion.
pub fn shortest(acquired: &Acquired) -> usize {
    let hz = acquired.under_test().map(|t| frequency_hz(&t.states)).fold(f64::INFINITY, f64::min);
    let rate = acquired.tracks[0].sample_rate_hz;
    let most = longest(acquired);
    ((SETTINGS.window_periods * rate / hz.max(1e-9)) as usize).clamp(SETTINGS.min_window.min(most), most)
}

/// Longest window: at least one a fold, and several in a fit.
fn longest(acquired: &Acquired) -> usize {
    let total: usize = acquired.under_test().map(|t| t.len()).sum();
    let whole = acquired.under_test().map(|t| t.len()).max().unwrap_or(1);
    let each = if acquired.under_test().count() >= SETTINGS.folds { whole } else { total / SETTINGS.folds };
    let fitted = if total > SETTINGS.simulated_samples { SETTINGS.simulated_samples / SETTINGS.folds } else { whole };
    each.min(fitted).min(whole).max(SETTINGS.min_block)
}

/// Rig with causes, and the keys that a fit changes.
pub fn with_causes(rig: &Rig, causes: &[Cause], unknown: &[Parameter]) -> (Rig, Vec<RigKey>) {
    let mut rig = rig.clone();
    let first = rig.effects.len();
    let mut keys: Vec<RigKey> = unknown.iter().map(|p| p.key().into()).collect();
    for (index, cause) in causes.iter().enumerate() {
        rig = rig.with_effect(cause.entry.clone());
        keys.extend(cause.free.iter().map(|key| RigKey::Effect { index: first + index, key: *key }));
    }
    (rig, keys)
}

/// Longest windows over which a rig still follows the recordings, refitted from one length to the next.
pub fn longest_windows(rig: &Rig, keys: &[RigKey], acquired: &Acquired) -> (Windows, Rig) {
    let observed = acquired.observed();
    let whole = longest(acquired);
    let mut length = shortest(acquired);
    let mut windows = Windows::new(acquired, length);
    let Some(first) = refined(rig, keys, &observed, &thinned(windows.spans.clone())) else {
        return (windows, rig.clone());
    };
    let (mut rig, mut rms) = (first.rig, first.rms);
    while length < whole {
        length = (length * SETTINGS.window_growth).min(whole);
        let wider = Windows::new(acquired, length);
        let Some(next) = refined(&rig, keys, &observed, &thinned(wider.spans.clone())) else { break };
        let (growth, noise) = SETTINGS.window_error;
        if next.rms > (growth * rms).max(noise * acquired.noise_std) {
            break;
        }
        (windows, rig, rms) = (wider, next.rig, next.rms.max(rms));
    }
    (windows, rig)
}

/// A fit, or the same rig where nothing is fitted better.
fn refined(rig: &Rig, keys: &[RigKey], observed: &Observed, spans: &[Span]) -> Option<Refined> {
    shooting::refine(rig, keys, observed, spans).or_else(|| shooting::refine(rig, &[], observed, spans))
}

/// Fits a rig to the windows, and to those outside each fold.
pub fn fit(rig: &Rig, keys: &[RigKey], acquired: &Acquired, windows: &Windows) -> Option<SimulatedFit> {
    let observed = acquired.observed();
    let all = refined(rig, keys, &observed, &thinned(windows.spans.clone()))?;
    let folds: Vec<Rig> = (0..SETTINGS.folds)
        .into_par_iter()
        .map(|fold| {
            let spans = windows.outside(fold);
            if keys.is_empty() || spans.is_empty() {
                return all.rig.clone();
            }
            refined(&all.rig, keys, &observed, &spans).map_or_else(|| all.rig.clone(), |r| r.rig)
        })
        .collect();
    let own = all.fit.values.len() == keys.len();
    let values = keys.iter().enumerate().map(|(i, key)| {
        let value = all.rig.get(*key).unwrap_or(f64::NAN);
        (value, own.then(|| half_width(i, *key, value, &all.fit, &folds)))
    });
    let values = values.collect();
    Some(SimulatedFit { values, keys: keys.to_vec(), folds, rms: all.rms, rig: all.rig })
}

/// Half the width of a 95 % interval: by the residual's correlation, or, where it is wider, by the folds (jackknife), whose
/// scatter holds what differs between recordings too.
fn half_width(index: usize, key: RigKey, value: f64, fit: &Fit, folds: &[Rig]) -> f64 {
    (Z975 * fit.covariance[index][index].max(0.0).sqrt()).max(scatter(key, value, folds))
}

/// Half the width of a 95 % interval by the jackknife.
fn scatter(key: RigKey, value: f64, folds: &[Rig]) -> f64 {
    let count = folds.len() as f64;
    let squares: f64 = folds.iter().filter_map(|r| r.get(key)).map(|v| (v - value).powi(2)).sum();
    t975(folds.len() - 1) * ((count - 1.0) / count * squares).sqrt()
}

/// A fit whose parameters are the regression's: where forces disturb the machine, a simulation adds up what they do, and its
/// fit is the worse one. `widths` are half the widths of the regression's intervals, of keys that it has, `rms` is its error.
pub fn by_regression(rig: &Rig, keys: &[RigKey], folds: Vec<Rig>, widths: &[Option<f64>], rms: f64) -> SimulatedFit {
    let values = keys.iter().zip(widths).map(|(key, width)| {
        let value = rig.get(*key).unwrap_or(f64::NAN);
        (value, width.map(|width| width.max(scatter(*key, value, &folds))))
    });
    SimulatedFit { values: values.collect(), keys: keys.to_vec(), folds, rms, rig: rig.clone() }
}

/// RMS error of a rig's simulation of some windows.
pub fn simulated_rms(rig: &Rig, acquired: &Acquired, windows: &Windows) -> Option<f64> {
    shooting::error(rig, &acquired.observed(), &windows.spans)
}

/// Whether forces disturb the machine: a simulation from fitted starts errs by far more than the sensor. Returns the shortest
/// windows too.
pub fn is_disturbed(rig: &Rig, acquired: &Acquired) -> (bool, Windows) {
    let windows = Windows::new(acquired, shortest(acquired));
    let error = shooting::error(rig, &acquired.observed(), &thinned(windows.spans.clone()));
    let least = (SETTINGS.disturbed * acquired.noise_std).max(SETTINGS.numerical * acquired.spread());
    (error.is_none_or(|error| error > least), windows)
}

impl SimulatedFit {
    /// Simulation of each window by the rig that was fitted without its fold.
    pub fn held_out(&self, acquired: &Acquired, windows: &Windows) -> Option<Vec<Vec<f64>>> {
        let observed = acquired.observed();
        let mut out: Vec<Vec<f64>> = vec![Vec::new(); windows.spans.len()];
        for (fold, rig) in self.folds.iter().enumerate() {
            let inside: Vec<usize> = (0..out.len()).filter(|n| windows.folds[*n] == fold).collect();
            let spans: Vec<Span> = inside.iter().map(|n| windows.spans[*n]).collect();
            if spans.is_empty() {
                continue;
            }
            let runs = shooting::follow(rig, &observed, &spans)?;
            inside.into_iter().zip(runs).for_each(|(n, run)| out[n] = run);
        }
        Some(out)
    }
}

/// Held-out errors of two simulations of the same samples.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// RMS before.
    pub before: f64,
    /// RMS after.
    pub after: f64,
    /// p-value of the improvement.
    pub p_value: f64,
}

/// Compares two simulations of the same measured stretches, in blocks.
pub fn compare(measured: &[Vec<f64>], before: &[Vec<f64>], after: &[Vec<f64>]) -> Comparison {
    let squares = |simulated: &[Vec<f64>]| -> Vec<f64> {
        let pairs = measured.iter().zip(simulated);
        pairs.flat_map(|(m, s)| m.iter().zip(s).map(|(m, s)| (m - s).powi(2)).collect::<Vec<_>>()).collect()
    };
    let (b, a) = (squares(before), squares(after));
    let root = |x: &[f64]| (x.iter().sum::<f64>() / x.len().max(1) as f64).sqrt();
    let length = (b.len() / SETTINGS.blocks).max(SETTINGS.min_block);
    let blocks = |squares: &[f64]| squares.chunks(length).map(|c| c.iter().sum()).collect::<Vec<f64>>();
    Comparison { before: root(&b), after: root(&a), p_value: gain_p(&blocks(&b), &blocks(&a)) }
}
