//! Acquisition faults and single events, found in the samples themselves: clipping, lost samples, a shock.
//!
//! Clipped samples are marked, and a recording is cut where samples are lost or a shock strikes; the search for forces then goes
//! on. Whether a fault is reported is decided by the same gate as of every cause.

use std::ops::Range;

use super::acquire::{Acquired, Track};
use super::table::{Table, TermModel};
use crate::identify::force_balance::shooting::{self, Span};
use crate::identify::force_balance::{BalanceError, states::Sensed};
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::{EffectEntry, Rig};

/// Minimum count of consecutive samples of a plateau.
const PLATEAU: usize = 3;
/// Minimum count of plateaus at the maximum of a clipped signal.
const PLATEAUS: usize = 2;
/// Difference of the samples of a plateau from the greatest, as a share of it: noise behind the limit.
const FLAT: f64 = 2e-3;
/// Least step beside a plateau over what its samples differ by; a smooth signal's is below 2.
const KINK: f64 = 10.0;
/// Robust standard deviations beyond which a row belongs to a shock.
const BURST: f64 = 12.0;
/// Most bursts in a recording, most of its rows that they are, least share of the squares of all recordings that they hold, and
/// strength over the first from which what comes later is another.
const BURSTS: (usize, f64, f64, f64) = (1, 0.01, 0.1, 0.5);
/// Rows of a blow.
const BLOW: usize = 8;
/// Least ratio of a jump of lost samples to the typical one, and to the next largest.
const JUMP: (f64, f64) = (8.0, 2.5);
/// Least ratio of a jump of the position, from one sample to the next, to the change of its course there: a shock changes the velocity
/// alone, and the position by at most half of that.
const JUMP_OF_KINK: f64 = 0.55;
/// Samples of a recording below which it is not searched for faults.
const SEARCHED: usize = 64;

/// Acquisition fault or single event.
#[derive(Clone, Debug)]
pub struct Fault {
    /// Effect of the fault.
    pub entry: EffectEntry,
    /// Evidence in a sentence.
    pub evidence: String,
}

impl Fault {
    /// Whether it is in every recording, and so in the corrected rig.
    pub fn lasts(&self) -> bool {
        matches!(self.entry.kind, EffectKind::SensorClipping | EffectKind::MainsInterference)
    }
}

/// Finds faults of the recordings under test; marks, subtracts or cuts.
///
/// # Errors
///
/// As [`Acquired::smooth`].
pub fn clean(acquired: &mut Acquired) -> Result<Vec<Fault>, BalanceError> {
    let mut faults = Vec::new();
    let searched = acquired.under_test().all(|t| t.len() >= SEARCHED);
    if searched {
        faults.extend(clipping(&mut acquired.tracks));
    }
    if searched && faults.is_empty() {
        faults.extend(lost_samples(acquired));
    }
    if !faults.is_empty() {
        acquired.smooth()?;
    }
    Ok(faults)
}

/// A shock or lost samples in the residual of a model, at which the recording is cut.
pub fn burst(acquired: &mut Acquired, rig: &Rig, table: &Table, model: &TermModel) -> Option<Fault> {
    let left = table.residual(model);
    let total: f64 = left.iter().map(|r| r * r).sum();
    let mut start = 0;
    let mut found: Option<(usize, usize, f64)> = None;
    for (index, track) in acquired.tracks.iter().enumerate() {
        let rows = &left[start..start + table.library.rows[index]];
        start += rows.len();
        if track.healthy || track.len() < SEARCHED {
            continue;
        }
        let mut sizes: Vec<f64> = rows.iter().map(|r| r.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let scale = sizes[sizes.len() / 2] / 0.6745;
        let mut loud: Vec<usize> = (4..rows.len()).filter(|k| rows[*k].abs() > BURST * scale).collect();
        let Some(first) = loud.first().copied() else { continue };
        let held: f64 = loud.iter().map(|k| rows[*k].powi(2)).sum();
        let (most, share, least, echo) = BURSTS;
        // What rings after the first blow is its echo.
        let is_blow = |k: &usize| k - first <= BLOW;
        let strength = loud.iter().take_while(|k| is_blow(k)).map(|k| rows[*k].abs()).fold(0.0, f64::max);
        loud.retain(|k| is_blow(k) || rows[*k].abs() > echo * strength);
        let apart = loud.windows(2).filter(|w| w[1] - w[0] > track.len() / 50 + 8).count() + 1;
        // What comes again is a force of the machine's states.
        if apart > most {
            return None;
        }
        if loud.len() as f64 > share * rows.len() as f64 || held < least * total {
            continue;
        }
        let samples: Vec<usize> = (0..track.len()).filter(|k| !track.bad[*k]).collect();
        let at = samples[first];
        if found.as_ref().is_none_or(|(.., most)| held > *most) {
            found = Some((index, at, held));
        }
    }
    let (index, at, _) = found?;
    let time_s = at as f64 * acquired.tracks[index].step_s();
    let name = acquired.tracks[index].name.clone();
    let track = &acquired.tracks[index];
    let samples = lost_at(track, at);
    // A force that begins there moves the position by less than a sample's motion.
    let fault = if samples >= 1.0 && jumps(acquired, rig, index, at) == Some(true) {
        let numbers = [(ParameterKey::TimeS, time_s), (ParameterKey::Count, samples)];
        Fault {
            entry: EffectEntry::new(EffectKind::DroppedSamples, &numbers),
            evidence: format!("at {time_s:.4} s of {name} the position is not where the rig would have it from before"),
        }
    } else {
        Fault {
            entry: EffectEntry::new(EffectKind::Shock, &[(ParameterKey::TimeS, time_s)]),
            evidence: format!("a single burst of force at {time_s:.4} s of {name}, without a jump of the position"),
        }
    };
    cut(acquired, index, at).then_some(fault)
}

/// Whether the position jumps at a sample, by simulations of what is before and after; `None` where they say nothing.
fn jumps(acquired: &Acquired, rig: &Rig, index: usize, at: usize) -> Option<bool> {
    let reach = SEARCHED / 2;
    if acquired.sensed != Sensed::Position || at < reach || at + reach > acquired.tracks[index].len() {
        return None;
    }
    let mut known = acquired.clone();
    known.tracks[index].bad[at] = true;
    let before = Span { track: index, first: at - reach, last: at + 1 };
    let before = shooting::follow(rig, &known.observed(), &[before])?.pop()?;
    let after = Span { track: index, first: at, last: at + reach };
    let after = shooting::follow(rig, &acquired.observed(), &[after])?.pop()?;
    let [.., last, end] = before.as_slice() else { return None };
    let [begin, next, ..] = after.as_slice() else { return None };
    Some((begin - end).abs() > JUMP_OF_KINK * ((next - begin) - (end - last)).abs())
}

/// Cuts a recording in two at a sample, which goes with the later part; false where a part would be too short.
fn cut(acquired: &mut Acquired, index: usize, at: usize) -> bool {
    let whole = &acquired.tracks[index];
    if at < SEARCHED / 2 || whole.len() - at < SEARCHED / 2 {
        return false;
    }
    let part = |from: usize, to: usize| Track {
        input: whole.input[from..to].to_vec(),
        sensed: whole.sensed[from..to].to_vec(),
        raw: whole.raw[from..to].to_vec(),
        bad: whole.bad[from..to].to_vec(),
        start_s: whole.start_s + from as f64 * whole.step_s(),
        offset: whole.offset + from,
        ..whole.clone()
    };
    let parts = [part(0, at), part(at, whole.len())];
    acquired.tracks.splice(index..=index, parts);
    true
}

/// Plateaus at a recording's largest or least value, which the signal reaches with a kink.
fn clipping(tracks: &mut [Track]) -> Option<Fault> {
    let (mut levels, mut plateaus, mut clipped) = (Vec::new(), 0, 0);
    for track in tracks.iter_mut().filter(|t| !t.healthy) {
        for side in [-1.0, 1.0] {
            let values: Vec<f64> = track.sensed.iter().map(|x| side * x).collect();
            let level = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let found = plateaus_at(&values, level);
            if level <= 0.0 || found.len() < PLATEAUS {
                continue;
            }
            let at = |x: f64| x >= level * (1.0 - FLAT);
            clipped += values.iter().filter(|x| at(**x)).count();
            track.bad.iter_mut().zip(&values).for_each(|(bad, x)| *bad |= at(*x));
            plateaus += found.len();
            levels.push(level);
        }
    }
    levels.sort_by(f64::total_cmp);
    let level = *levels.get(levels.len() / 2)?;
    Some(Fault {
        entry: EffectEntry::new(EffectKind::SensorClipping, &[(ParameterKey::Value, level)]),
        evidence: format!(
            "{clipped} samples in {plateaus} plateaus are at {level:.6e}, which the signal reaches with a kink; none is beyond"
        ),
    })
}

/// Runs of samples at the greatest value that are flat beside the steps by which the signal comes and goes. A smooth signal's
/// steps beside n samples at its peak are 4 (n + 1)/n² of what these differ by; where they are equal, of its resolution.
fn plateaus_at(values: &[f64], level: f64) -> Vec<Range<usize>> {
    let at = |x: f64| x >= level * (1.0 - FLAT);
    let mut runs: Vec<Range<usize>> = Vec::new();
    for k in (0..values.len()).filter(|k| at(values[*k])) {
        match runs.last_mut().filter(|run| run.end == k) {
            Some(run) => run.end = k + 1,
            None => runs.push(k..k + 1),
        }
    }
    let resolution = resolution(values);
    let is_flat = |run: &Range<usize>| {
        if run.len() < PLATEAU || run.start == 0 || run.end == values.len() {
            return false;
        }
        let part = &values[run.clone()];
        let least = part.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = part.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let step = (part[0] - values[run.start - 1]).min(part[part.len() - 1] - values[run.end]);
        step > KINK * (greatest - least).max(resolution)
    };
    runs.retain(is_flat);
    runs
}

/// Least difference of two values of a signal that are not equal.
fn resolution(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min)
}

/// Finds lost samples in the positions, and cuts the recordings there.
fn lost_samples(acquired: &mut Acquired) -> Option<Fault> {
    if acquired.sensed != Sensed::Position {
        return None;
    }
    let mut fault = None;
    for index in (0..acquired.tracks.len()).rev() {
        let track = &acquired.tracks[index];
        if track.healthy {
            continue;
        }
        let (at, jump, usual, next) = largest_jump(&track.sensed);
        let [before, after] = [at - 1, at + 1].map(|k| track.sensed[k] - track.sensed[k - 1]);
        let kink = after - before;
        if (track.sensed[at] - track.sensed[at - 1] - 0.5 * (before + after)).abs() < JUMP_OF_KINK * kink.abs() {
            continue;
        }
        if jump.abs() < JUMP.0 * usual || jump.abs() < JUMP.1 * next {
            continue;
        }
        let (time_s, name) = (at as f64 * track.step_s(), track.name.clone());
        let samples = lost_at(track, at).max(1.0);
        if cut(acquired, index, at) {
            let numbers = [(ParameterKey::TimeS, time_s), (ParameterKey::Count, samples)];
            fault = Some(Fault {
                entry: EffectEntry::new(EffectKind::DroppedSamples, &numbers),
                evidence: format!(
                    "{name} jumps by {jump:.3e} from one sample to the next at {time_s:.4} s, {:.0} times the typical and \
                     {:.0} times the next largest jump",
                    jump.abs() / usual,
                    jump.abs() / next
                ),
            });
        }
    }
    fault
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

/// Count of samples lost at a jump of a recording, 0 if there is none.
fn lost_at(track: &Track, at: usize) -> f64 {
    lost(&track.sensed, at, super::acquire::frequency_hz(&track.states) * track.step_s())
}

/// The same of a signal, by the slopes over a tenth of the fastest period, in samples of 1/`band`, before and after; 1 where it stands.
fn lost(signal: &[f64], at: usize, band: f64) -> f64 {
    let width = ((0.1 / band.max(1e-9)) as usize).clamp(3, 40);
    let (before, after) = (at.saturating_sub(width), (at + width).min(signal.len() - 1));
    let slope = |from: usize, to: usize| (signal[to] - signal[from]) / (to - from).max(1) as f64;
    let mean = 0.5 * (slope(before, at - 1) + slope(at, after));
    let jump = signal[at] - signal[at - 1];
    if mean == 0.0 { 1.0 } else { (jump / mean - 1.0).abs().round().min(1e6) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sensor's limit is reached with a kink, with noise behind it or not; the peaks of a tone are not, though a coarse converter makes
    /// them flat.
    #[test]
    fn invariant_plateaus_of_a_limit_have_kinks() {
        let tone = |size: f64| move |k: i32| size * (0.02 * f64::from(k)).sin();
        let plateaus = |signal: &dyn Fn(i32) -> f64| {
            let values: Vec<f64> = (0..4000).map(signal).collect();
            let level = values.iter().copied().fold(0.0, f64::max);
            plateaus_at(&values, level).len()
        };
        let noise = crate::identify::force_balance::testing::white(5, 1e-4, 4000);
        assert!(plateaus(&|k| tone(2.0)(k).clamp(-1.0, 1.0)) > 10);
        assert!(plateaus(&|k| tone(2.0)(k).clamp(-1.0, 1.0) + noise[k as usize]) > PLATEAUS);
        assert_eq!(plateaus(&tone(1.0)), 0);
        assert_eq!(plateaus(&|k| (tone(1.0)(k) / 1e-3).round() * 1e-3), 0);
    }

    /// A force that begins within a motion of 1 mm a sample has moved the position by far less at the next one.
    #[test]
    fn null_a_force_that_begins_has_lost_no_samples() {
        let motion = |k: f64| 1e-3 * k;
        let forced: Vec<f64> =
            (0..60).map(|k| motion(f64::from(k)) + 2e-6 * f64::from((k - 29).max(0)).powi(2)).collect();
        assert_eq!(lost(&forced, 30, 0.01), 0.0);
        let two_lost: Vec<f64> = (0..60).map(|k| motion(f64::from(if k < 30 { k } else { k + 2 }))).collect();
        assert_eq!(lost(&two_lost, 30, 0.01), 2.0);
    }
}
