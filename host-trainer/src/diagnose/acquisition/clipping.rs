//! Clipping: samples that pile up at the greatest or least value of a recording.

use super::{Fault, SURE};
use crate::identify::likelihood::observed::{CHANNELS, accelerations};
use crate::recording::Recording;
use crate::rig::EffectEntry;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::signal::surrogate::autoregression::Autoregression;

/// Minimum count of samples at the limit of a clipped channel, in one recording or in all that share it; noise has one, or a few by rounding.
const TIES: usize = 12;
/// Samples at a limit over those at the next value, of a coarse converter near its limit, from which they pile up there.
const PILE: usize = 3;
/// Difference of two values that are one, as a share of them.
const TIE: f64 = 1e-6;

/// Least and greatest value that a sensor shows in each channel of a recording, m/s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits([[f64; 2]; 2]);

impl Limits {
    /// Limits of recordings of one sensor where their samples pile up, infinite elsewhere. What piles up too little in each does so
    /// in those together that have one greatest value.
    pub fn of(recordings: &[Recording]) -> Vec<Self> {
        let mut all = vec![Self([[f64::NEG_INFINITY, f64::INFINITY]; 2]); recordings.len()];
        for channel in 0..CHANNELS.len() {
            for (index, side) in [-1.0, 1.0].into_iter().enumerate() {
                let tops = recordings.iter().map(|recording| {
                    let found = accelerations(recording)[channel];
                    Top::of(found.map_or(&[][..], |channel| &channel.samples), side)
                });
                let tops: Vec<Top> = tops.collect();
                for (limits, top) in all.iter_mut().zip(&tops) {
                    let alike = tops.iter().filter(|other| is_at(top.value, other.value));
                    let together = alike.fold(Top { value: top.value, ..Top::default() }, |sum, other| sum.with(other));
                    if top.is_pile() || together.is_pile() {
                        limits.0[channel][index] = side * top.value;
                    }
                }
            }
        }
        all
    }

    /// Value within the limits of a channel.
    pub fn clamped(&self, channel: usize, value: f64) -> f64 {
        let [least, most] = self.0[channel];
        value.clamp(least, most)
    }

    /// Smaller size of a channel's limits; `None` without any.
    fn level(&self, channel: usize) -> Option<f64> {
        let level = self.0[channel].into_iter().map(f64::abs).fold(f64::INFINITY, f64::min);
        level.is_finite().then_some(level)
    }

    /// Whether a value is at a limit of a channel.
    fn has(&self, channel: usize, value: f64) -> bool {
        self.0[channel].into_iter().any(|limit| limit.is_finite() && is_at(limit, value))
    }

    /// Recording whose samples at the limits are as its other samples let expect, and not within the limits.
    pub fn restored(&self, recording: &Recording) -> Recording {
        let names = accelerations(recording).map(|found| found.map(|c| c.name.as_str()));
        let mut out = recording.clone();
        for found in &mut out.channels {
            let channel = names.iter().position(|name| *name == Some(found.name.as_str()));
            let Some(channel) = channel.filter(|channel| self.level(*channel).is_some()) else { continue };
            let unknown: Vec<bool> = found.samples.iter().map(|v| self.has(channel, *v)).collect();
            let restored = Autoregression::new(&found.samples).restored(&found.samples, &unknown);
            for ((sample, value), _) in found.samples.iter_mut().zip(restored).zip(unknown).filter(|(_, u)| *u) {
                *sample = sample.signum() * value.abs().max(sample.abs());
            }
        }
        out
    }
}

/// Greatest samples of a channel on a side.
#[derive(Clone, Copy, Default)]
struct Top {
    /// Greatest value.
    value: f64,
    /// Samples there.
    ties: usize,
    /// Samples at the next value.
    below: usize,
}

impl Top {
    fn of(samples: &[f64], side: f64) -> Self {
        let value = samples.iter().map(|v| side * v).fold(f64::NEG_INFINITY, f64::max);
        let next = samples.iter().map(|v| side * v).filter(|v| !is_at(value, *v)).fold(f64::NEG_INFINITY, f64::max);
        let count = |level: f64| samples.iter().filter(|v| is_at(level, side * **v)).count();
        Self { value, ties: count(value), below: count(next) }
    }

    fn with(self, other: &Self) -> Self {
        Self { ties: self.ties + other.ties, below: self.below + other.below, ..self }
    }

    /// Whether many samples are exactly there and few at the next value: a coarse converter has nearly as many at both.
    fn is_pile(&self) -> bool {
        self.ties >= TIES && self.ties > PILE * self.below
    }
}

fn is_at(level: f64, value: f64) -> bool {
    (level - value).abs() <= TIE * level.abs()
}

/// Faults of the clipped channels.
pub fn clipped(recordings: &[Recording], limits: &[Limits]) -> Vec<Fault> {
    let of = |(channel, name): (usize, &'static str)| {
        let mut levels: Vec<f64> = limits.iter().filter_map(|l| l.level(channel)).collect();
        levels.sort_by(f64::total_cmp);
        let level = *levels.get(levels.len() / 2)?;
        let at = |(recording, limits): (&Recording, &Limits)| {
            let samples = accelerations(recording)[channel].map(|c| c.samples.as_slice()).unwrap_or_default();
            samples.iter().filter(|v| limits.has(channel, **v)).count()
        };
        let ties: usize = recordings.iter().zip(limits).map(at).sum();
        let effect = EffectEntry::new(EffectKind::SensorClipping, &[(ParameterKey::Value, level)])
            .with_text(ParameterKey::Channel, name);
        let evidence = format!(
            "{ties} samples of {name} are exactly at the greatest or least value of their recording, {level:.4} m/s², in {} of {} \
             recordings.",
            levels.len(),
            recordings.len()
        );
        // By chance each sample has at least two values to take.
        Some(Fault { effect, evidence, p_value: 0.5f64.powi(ties.min(200) as i32), probability: SURE })
    };
    CHANNELS.into_iter().enumerate().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{Start, simulate};

    fn healthy() -> Recording {
        simulate(&nominal(), &condition(30.0, 800.0, 12_800), &Start::seeded(3)).unwrap()
    }

    fn clipped_at(level: f64, side: f64) -> Recording {
        let mut recording = healthy();
        let channel = recording.channels.iter_mut().find(|c| c.name == "ay").unwrap();
        channel.samples.iter_mut().for_each(|v| *v = side * (side * *v).min(level));
        recording
    }

    fn rms(recording: &Recording) -> f64 {
        let samples = &accelerations(recording)[1].unwrap().samples;
        (samples.iter().map(|v| v * v).sum::<f64>() / samples.len() as f64).sqrt()
    }

    #[test]
    fn null_noise_is_not_clipped() {
        let recording = healthy();
        let recordings = [recording];
        assert!(clipped(&recordings, &Limits::of(&recordings)).is_empty());
    }

    #[test]
    fn invariant_one_side_in_one_of_two_recordings_is_clipped_and_restored() {
        for side in [1.0, -1.0] {
            let level = 1.2 * rms(&healthy());
            let recordings = [healthy(), clipped_at(level, side)];
            let limits = Limits::of(&recordings);
            let faults = clipped(&recordings, &limits);
            assert_eq!(faults.len(), 1);
            let value = faults[0].effect.number(ParameterKey::Value).unwrap();
            assert!((value / level - 1.0).abs() < 1e-9, "{value}");
            let restored = limits[1].restored(&recordings[1]);
            let error = |r: &Recording| (rms(r) / rms(&recordings[0]) - 1.0).abs();
            assert!(error(&restored) < 0.5 * error(&recordings[1]), "{} {}", error(&restored), error(&recordings[1]));
            let again: Vec<f64> =
                accelerations(&restored)[1].unwrap().samples.iter().map(|v| limits[1].clamped(1, *v)).collect();
            assert_eq!(again, accelerations(&recordings[1])[1].unwrap().samples);
        }
    }
    /// Recordings of which none has enough samples at its limit by itself.
    #[test]
    fn invariant_a_limit_that_recordings_share_needs_few_samples_in_each() {
        let mut recordings =
            [0, 1, 2].map(|seed| simulate(&nominal(), &condition(30.0, 800.0, 12_800), &Start::seeded(seed)).unwrap());
        let ay = |recording: &Recording| accelerations(recording)[1].unwrap().samples.clone();
        let mut sorted = ay(&recordings[0]);
        sorted.sort_by(f64::total_cmp);
        let level = sorted[sorted.len() - 9];
        for recording in &mut recordings[..2] {
            let channel = recording.channels.iter_mut().find(|c| c.name == "ay").unwrap();
            channel.samples.iter_mut().for_each(|v| *v = v.min(level));
        }
        let limits = Limits::of(&recordings);
        let ties = [0, 1].map(|n| ay(&recordings[n]).iter().filter(|v| **v == level).count());
        assert!(ties.iter().all(|n| *n < TIES) && ties.iter().sum::<usize>() >= TIES, "{ties:?}");
        assert_eq!(clipped(&recordings, &limits)[0].effect.number(ParameterKey::Value), Some(level));
        assert!(limits[2].level(1).is_none());
        let alone = Limits::of(&recordings[1..]);
        assert!(clipped(&recordings[1..], &alone).is_empty());
    }
}
