//! What happens once: samples that were lost, or a shock.
//!
//! Either leaves a burst in what every model leaves of the balance, and nothing elsewhere. Lost samples make the position
//! itself jump, a shock only its speed.

use super::{
    acquisition::Fault,
    decide::Decision,
    states::{Sensed, States},
    table::Table,
};
use crate::rig::EffectEntry;

/// Robust deviations beyond which a row is part of a burst.
const BURST: f64 = 8.0;
/// Most bursts in a recording, and most of its rows in them.
const BURSTS: usize = 2;
const ROWS: f64 = 0.03;
/// Share of the sum of squares that the bursts must hold.
const HOLD: f64 = 0.4;
/// Times the usual second difference that a jump of lost samples has.
const JUMP: f64 = 6.0;

/// Finds single events in the first `count` recordings and marks what they touch.
pub fn find(states: &mut States, table: &Table, decision: &Decision, count: usize) -> Option<Fault> {
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
        .map(|(r, (t, row))| (*t, states.tracks[*t].rows[*row], r * r))
        .collect();
    let held: f64 = loud.iter().map(|(.., power)| power).sum();
    if loud.is_empty() || held < HOLD * total || loud.len() as f64 > ROWS * sizes.len() as f64 {
        return None;
    }
    // One burst reaches as far as the filter and the whitening do.
    let reach = (14.0 * states.deviation) as usize + 14 * states.stride;
    let mut bursts: Vec<(usize, usize, usize)> = Vec::new();
    for (track, sample, _) in loud {
        match bursts.last_mut().filter(|(t, _, last)| *t == track && sample <= *last + reach) {
            Some((_, _, last)) => *last = sample,
            None => bursts.push((track, sample, sample)),
        }
    }
    let most = (0..count).map(|t| bursts.iter().filter(|(track, ..)| *track == t).count()).max()?;
    if most > BURSTS {
        return None;
    }
    let mut first = None;
    for (track, from, to) in bursts {
        let from = from.saturating_sub((7.0 * states.deviation) as usize + 14 * states.stride);
        let to = (to + (7.0 * states.deviation) as usize).min(states.tracks[track].len() - 1);
        let (sample, jump, usual) = largest_jump(&states.tracks[track].sensed[from..=to]);
        let at = from + sample;
        first.get_or_insert((track, at, jump, usual));
        // The balance around it is not to be believed; how far the kernel reaches is added by the rows themselves.
        states.tracks[track].bad[at.saturating_sub(1)..=at].fill(true);
    }
    let (track, at, jump, usual) = first?;
    states.prepare();
    let time_s = at as f64 * states.step_s();
    let name = states.tracks[track].name.clone();
    if jump.abs() > JUMP * usual {
        let count = lost(states, track, at);
        return Some(Fault {
            entry: EffectEntry::new("dropped-samples", &[("time_s", time_s), ("count", count)]),
            evidence: format!(
                "{name} jumps by {jump:.3e} from one sample to the next at {time_s:.4} s, {:.0} times the usual",
                jump.abs() / usual
            ),
        });
    }
    Some(Fault {
        entry: EffectEntry::new("shock", &[("time_s", time_s)]),
        evidence: format!(
            "a single burst of force at {time_s:.4} s of {name}, no jump of the position, and nothing like it elsewhere"
        ),
    })
}

/// Index after the largest jump beyond the signal's own course, the jump, and the usual size of such.
fn largest_jump(signal: &[f64]) -> (usize, f64, f64) {
    // The first difference against the mean of its neighbours two away, which a jump leaves alone.
    let course = |k: usize| 0.5 * ((signal[k - 2] - signal[k - 3]) + (signal[k + 2] - signal[k + 1]));
    let jumps: Vec<(usize, f64)> =
        (3..signal.len().saturating_sub(2)).map(|k| (k, signal[k] - signal[k - 1] - course(k))).collect();
    let mut sizes: Vec<f64> = jumps.iter().map(|(_, j)| j.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let usual = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0) / 0.6745;
    let largest = jumps.into_iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((0, 0.0));
    (largest.0, largest.1, usual.max(f64::MIN_POSITIVE))
}

/// How many samples a jump stands for: by the speed before and after.
fn lost(states: &States, track: usize, at: usize) -> f64 {
    let signal = &states.tracks[track].sensed;
    let width = ((1.0 * states.deviation) as usize).clamp(3, 40);
    let (before, after) = (at.saturating_sub(width), (at + width).min(signal.len() - 1));
    let slope = |from: usize, to: usize| (signal[to] - signal[from]) / (to - from).max(1) as f64;
    let mean = 0.5 * (slope(before, at.saturating_sub(1)) + slope(at, after));
    let jump = signal[at] - signal[at.saturating_sub(1)];
    let count = match states.sensed {
        Sensed::Position | Sensed::Acceleration if mean != 0.0 => jump / mean - 1.0,
        _ => 1.0,
    };
    count.abs().round().clamp(1.0, 1e6)
}
