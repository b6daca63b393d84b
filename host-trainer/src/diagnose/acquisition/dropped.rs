//! Samples that a logger dropped: one turn of the shaft is short by as many, while all others are like those around them.

use std::ops::Range;

use crate::identify::likelihood::observed::accelerations;
use crate::recording::Recording;
use crate::signal::order::pulses;
use crate::signal::surrogate::autoregression::Autoregression;
use crate::signal::transform::median;

/// Fewest turns of a recording by which one is found short.
const TURNS: usize = 2 * AROUND + 1;
/// Turns before and after one that it is held against: a speed that wanders or drifts differs less from these.
const AROUND: usize = 3;
/// Samples, and share of a turn, by which turns of an even speed differ.
const ALIKE: [f64; 2] = [2.5, 0.004];
/// Variance of a turn between two whole samples, each uniform within one.
const WHOLE_SAMPLES: f64 = 1.0 / 6.0;
/// Standard deviations of a turn by which it must be short.
const LEAST_Z: f64 = 6.0;
/// Samples after a jump in which an autoregression errs.
const JUMP: usize = 12;
/// Samples by which a gap found by phases may be farther away than one within a turn. By hand.
const REACH: usize = 600;

/// How missing samples show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Those after them follow at once: a turn of the shaft is short by the tachometer.
    ShortTurn,
    /// The same without a tachometer: the phases of lines jump.
    PhaseJump,
    /// The last one before them stands in their place.
    Held,
}

/// Missing samples of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Sample before which they are missing.
    pub sample: usize,
    /// Their count.
    pub count: usize,
    /// Standard deviations of a turn by which this one is short; a turn's is at least that of its whole samples. Of held samples √(−2 ln p)
    /// of the probability p of such a run.
    pub z: f64,
    /// How they show.
    pub kind: Kind,
}

impl Gap {
    /// Samples of the recording that stand where others are missing, or among which others are.
    pub fn span(&self) -> Range<usize> {
        match self.kind {
            Kind::ShortTurn => self.sample..self.sample,
            Kind::PhaseJump => self.sample.saturating_sub(REACH)..self.sample + REACH,
            Kind::Held => self.sample..self.sample + self.count,
        }
    }
}

/// Missing samples by a recording's tachometer; `None` without one, if every turn is like those around it, or if only a pulse is
/// missing.
pub fn gap(recording: &Recording) -> Option<Gap> {
    let pulses = pulses(&recording.channel("tacho")?.samples);
    let turns: Vec<f64> = pulses.windows(2).map(|p| (p[1] - p[0]) as f64).collect();
    if turns.len() < TURNS {
        return None;
    }
    let usual: Vec<f64> = (0..turns.len()).map(|n| expected(&turns, n)).collect::<Option<_>>()?;
    let off = |n: usize| turns[n] - usual[n];
    let is_odd = |n: &usize| off(*n).abs() > ALIKE[0].max(ALIKE[1] * usual[*n]);
    let odd: Vec<usize> = (0..turns.len()).filter(is_odd).collect();
    let [odd] = odd.as_slice() else { return None };
    let count = (-off(*odd)).rem_euclid(usual[*odd]);
    let alike = ALIKE[0].max(ALIKE[1] * usual[*odd]);
    if count.min(usual[*odd] - count) < alike {
        return None;
    }
    let others = (0..turns.len()).filter(|n| n != odd).map(|n| off(n).powi(2));
    let scatter = (others.sum::<f64>() / (turns.len() - 1) as f64).max(WHOLE_SAMPLES);
    let z = off(*odd).abs() / scatter.sqrt();
    if z < LEAST_Z {
        return None;
    }
    let sample = jump(recording, pulses[*odd]..pulses[*odd + 1])?;
    Some(Gap { sample, count: count.round() as usize, z, kind: Kind::ShortTurn })
}

/// Turn by a straight line through those around it, of the median slope and the median height, which one odd turn among them does
/// not move (P. K. Sen, J. Am. Stat. Assoc. 63 (1968) 1379–1389); `None` if there are none.
fn expected(turns: &[f64], n: usize) -> Option<f64> {
    let from = n.saturating_sub(AROUND).min(turns.len().saturating_sub(2 * AROUND + 1));
    let near: Vec<usize> = (from..(from + 2 * AROUND + 1).min(turns.len())).filter(|other| *other != n).collect();
    let slope = |a: usize, b: usize| (turns[b] - turns[a]) / (b - a) as f64;
    let pairs = near.iter().enumerate().flat_map(|(k, a)| near[k + 1..].iter().map(move |b| (*a, *b)));
    let slope = median(&mut pairs.map(|(a, b)| slope(a, b)).collect::<Vec<_>>())?;
    median(&mut near.iter().map(|other| turns[*other] + slope * (n as f64 - *other as f64)).collect::<Vec<_>>())
}

/// Sample of the greatest jump within a turn: where the errors of an autoregression are largest.
fn jump(recording: &Recording, within: Range<usize>) -> Option<usize> {
    let mut energy = vec![0.0; within.len()];
    for channel in accelerations(recording).into_iter().flatten() {
        let errors = Autoregression::new(&channel.samples).innovations(&channel.samples);
        let first = channel.samples.len() - errors.len();
        let variance = errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64;
        for (place, sum) in energy.iter_mut().enumerate() {
            let from = (within.start + place).checked_sub(first)?;
            let there = errors.get(from..(from + JUMP).min(errors.len())).unwrap_or_default();
            *sum += there.iter().map(|e| e * e).sum::<f64>() / variance.max(f64::MIN_POSITIVE);
        }
    }
    // The window begins with the jump where the errors' sum is greatest for the last time.
    let best = energy.iter().copied().fold(0.0, f64::max);
    energy.iter().rposition(|e| *e > 0.98 * best).map(|place| within.start + place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::effect::{EffectKind, ParameterKey};
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{EffectEntry, Rig, Run, Start, simulate_many};

    fn recording(rig: &Rig) -> Recording {
        simulate_many(&[Run { rig, condition: condition(30.0, 500.0, 25_600), start: Start::seeded(3) }])
            .unwrap()
            .remove(0)
    }

    #[test]
    fn missing_samples_are_counted_and_placed() {
        for count in [40.0, 444.0] {
            let effect = EffectEntry::new(
                EffectKind::DroppedSamples,
                &[(ParameterKey::TimeS, 0.4), (ParameterKey::Count, count)],
            );
            let gap = gap(&recording(&nominal().with_effect(effect))).unwrap();
            assert!((gap.count as f64 - count).abs() <= 2.0, "{gap:?}");
            // Few missing samples jump little: 418 samples off of 40. The cut is wider.
            assert!(gap.sample.abs_diff(10_240) < super::super::MARGIN, "{gap:?}");
        }
    }

    /// Recording of 20 turns of about 712 samples; `longer` gives what each has beyond that.
    fn turning(longer: impl Fn(usize) -> usize) -> Recording {
        let mut recording = recording(&nominal());
        let mut pulse = 300;
        let mut tacho = vec![0.0; recording.len()];
        for turn in 0..20 {
            // A pulse of five samples.
            tacho[pulse..pulse + 5].fill(1.0);
            pulse += 712 + longer(turn);
        }
        recording.channels.iter_mut().filter(|c| c.name == "tacho").for_each(|c| c.samples = tacho.clone());
        recording
    }

    #[test]
    fn missing_samples_are_counted_by_pulses_of_several_samples() {
        let mut recording = turning(|_| 0);
        recording.channels.iter_mut().for_each(|c| drop(c.samples.drain(8000..8100)));
        assert_eq!(gap(&recording).map(|gap| gap.count), Some(100));
    }

    #[test]
    fn null_a_missed_pulse_and_a_wandering_speed_are_no_missing_samples() {
        for extra in [711, 712, 713] {
            assert_eq!(gap(&turning(|turn| if turn == 9 { extra } else { 0 })), None, "{extra}");
        }
        // As of a wandering machine: all turns of 712 to 714 samples but one of 715.
        let slowing = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 3, 2, 2, 2];
        assert_eq!(gap(&turning(|turn| slowing[turn])), None);
        for drift in [1, 2, 5] {
            assert_eq!(gap(&turning(|turn| drift * turn)), None, "{drift}");
        }
    }

    #[test]
    fn null_an_even_turning_shaft_has_lost_nothing() {
        assert_eq!(gap(&recording(&nominal())), None);
    }
}
