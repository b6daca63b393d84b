//! Single events: lost samples, or a shock.
//!
//! Either gives one burst in the residual of every model. Lost samples make the position itself jump, a shock only the
//! velocity.

use super::{decide::Decision, finding::Fault, table::Table};
use crate::identify::force_balance::states::{Sensed, States};
use crate::rig::EffectEntry;
use crate::rig::effect::{EffectKind, ParameterKey};

/// Robust standard deviations beyond which a row belongs to a burst.
const BURST: f64 = 8.0;
/// Maximum count of bursts in a recording.
const BURSTS: usize = 2;
/// Maximum share of rows in bursts.
const ROWS: f64 = 0.03;
/// Minimum share of the sum of squares in bursts.
const HOLD: f64 = 0.4;
/// Minimum ratio of a jump of lost samples to the typical one.
const JUMP: f64 = 8.0;
/// Minimum ratio of a jump of lost samples to the next largest.
const ALONE: f64 = 2.5;

/// Finds lost samples in the positions of the first `count` recordings, and cuts the recordings there.
pub fn lost_samples(states: &mut States, count: &mut usize) -> Option<Fault> {
    if states.sensed != Sensed::Position {
        return None;
    }
    let mut fault = None;
    let mut track = 0;
    while track < *count {
        let signal = &states.tracks[track].sensed;
        let (at, jump, usual, next) = largest_jump(signal);
        if jump.abs() > JUMP * usual && jump.abs() > ALONE * next {
            let time_s = at as f64 * states.step_s();
            let name = states.tracks[track].name.clone();
            let samples = lost(&states.tracks[track].sensed, at, states.band.high_hz * states.step_s());
            if states.cut(track, at) {
                *count += 1;
                track += 1;
            } else {
                states.tracks[track].bad[at.saturating_sub(20)..at + 20].fill(true);
            }
            let times = jump.abs() / usual;
            fault.get_or_insert(Fault {
                entry: EffectEntry::new(EffectKind::DroppedSamples, &[(ParameterKey::TimeS, time_s), (ParameterKey::Count, samples)]),
                evidence: format!(
                    "{name} jumps by {jump:.3e} from one sample to the next at {time_s:.4} s, {times:.0} times the typical \
                     and {:.0} times the next largest jump",
                    jump.abs() / next
                ),
            });
        }
        track += 1;
    }
    fault
}

/// Finds a shock in the first `count` recordings and marks the affected samples.
pub fn shock(states: &mut States, table: &Table, decision: &Decision, count: usize) -> Option<Fault> {
    // A load step between two times of the grid leaves a burst too.
    if decision.chosen.parts.iter().any(|(term, _)| table.library.terms[*term].kind == EffectKind::LoadStep) {
        return None;
    }
    let left = table.residual(&decision.rich);
    let mut sizes: Vec<f64> =
        left.iter().zip(&table.places).filter(|(_, (t, _))| *t < count).map(|(r, _)| r.abs()).collect();
    let total: f64 = sizes.iter().map(|r| r * r).sum();
    sizes.sort_by(f64::total_cmp);
    let scale = sizes.get(sizes.len() / 2)? / 0.6745;
    let loud: Vec<(usize, usize, f64)> = left
        .iter()
        .zip(&table.places)
        .filter(|(r, (t, _))| *t < count && r.abs() > BURST * scale)
        .map(|(r, (t, row))| (*t, states.tracks[*t].rows[*row], r.abs()))
        .collect();
    let held: f64 = loud.iter().map(|(.., size)| size * size).sum();
    if loud.is_empty() || held < HOLD * total || loud.len() as f64 > ROWS * sizes.len() as f64 {
        return None;
    }
    // One burst reaches as far as the filter and the whitening do.
    let reach = (14.0 * states.deviation) as usize + 14 * states.stride;
    let mut bursts: Vec<(usize, usize, usize, f64)> = Vec::new();
    for (track, sample, size) in loud {
        match bursts.last_mut().filter(|(t, _, last, _)| *t == track && sample <= *last + reach) {
            Some((_, loudest, last, most)) => {
                *last = sample;
                if size > *most {
                    (*loudest, *most) = (sample, size);
                }
            }
            None => bursts.push((track, sample, sample, size)),
        }
    }
    if (0..count).any(|t| bursts.iter().filter(|(track, ..)| *track == t).count() > BURSTS) {
        return None;
    }
    let (track, at, ..) = *bursts.first()?;
    for (track, at, last, _) in bursts {
        let width = (8.0 * states.deviation) as usize + 2;
        let end = (last + width).min(states.tracks[track].len());
        states.tracks[track].bad[at.saturating_sub(width)..end].fill(true);
    }
    states.prepare();
    let (time_s, name) = (at as f64 * states.step_s(), states.tracks[track].name.clone());
    Some(Fault {
        entry: EffectEntry::new(EffectKind::Shock, &[(ParameterKey::TimeS, time_s)]),
        evidence: format!("a single burst of force at {time_s:.4} s of {name}, without a jump of the position"),
    })
}

/// Largest jump against the signal's local slope: index after it, its size, the typical size, and the largest one elsewhere.
fn largest_jump(signal: &[f64]) -> (usize, f64, f64, f64) {
    // The first difference minus the mean of those two samples away, which a jump does not affect.
    let course = |k: usize| 0.5 * ((signal[k - 2] - signal[k - 3]) + (signal[k + 2] - signal[k + 1]));
    let jumps: Vec<(usize, f64)> =
        (3..signal.len().saturating_sub(2)).map(|k| (k, signal[k] - signal[k - 1] - course(k))).collect();
    let mut sizes: Vec<f64> = jumps.iter().map(|(_, j)| j.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let usual = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0) / 0.6745;
    let largest = jumps.iter().copied().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((0, 0.0));
    let elsewhere = jumps.iter().filter(|(k, _)| k.abs_diff(largest.0) > 5).map(|(_, j)| j.abs()).fold(0.0, f64::max);
    (largest.0, largest.1, usual.max(f64::MIN_POSITIVE), elsewhere.max(f64::MIN_POSITIVE))
}

/// Count of samples lost at a jump, by the slopes over a tenth of the fastest period before and after.
fn lost(signal: &[f64], at: usize, band: f64) -> f64 {
    let width = ((0.1 / band.max(1e-9)) as usize).clamp(3, 40);
    let (before, after) = (at.saturating_sub(width), (at + width).min(signal.len() - 1));
    let slope = |from: usize, to: usize| (signal[to] - signal[from]) / (to - from).max(1) as f64;
    let mean = 0.5 * (slope(before, at - 1) + slope(at, after));
    let jump = signal[at] - signal[at - 1];
    if mean == 0.0 { 1.0 } else { (jump / mean - 1.0).abs().round().clamp(1.0, 1e6) }
}
