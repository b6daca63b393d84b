//! Clipping: samples that pile up at the greatest or least value of a recording.

use super::{Fault, SURE};
use crate::identify::likelihood::observed::{CHANNELS, accelerations};
use crate::recording::Recording;
use crate::rig::EffectEntry;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::signal::surrogate::autoregression::Autoregression;

/// Minimum count of samples at the limit of a clipped channel; noise has one, or a few by rounding.
const TIES: usize = 12;
/// Samples at a limit over those at the next value, of a coarse converter near its limit, from which they pile up there.
const PILE: usize = 3;
/// Difference of two values that are one, as a share of them.
const TIE: f64 = 1e-6;

/// Least and greatest value that a sensor shows in each channel of a recording, m/s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits([[f64; 2]; 2]);

impl Limits {
    /// Limits of a recording where its samples pile up, infinite elsewhere.
    pub fn of(recording: &Recording) -> Self {
        Self(accelerations(recording).map(|found| {
            let samples = found.map_or(&[][..], |channel| &channel.samples);
            [piled(samples, -1.0).unwrap_or(f64::NEG_INFINITY), piled(samples, 1.0).unwrap_or(f64::INFINITY)]
        }))
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

/// Value of the greatest sample on a side, where many are exactly there and few at the next value: a coarse converter has nearly
/// as many at both.
fn piled(samples: &[f64], side: f64) -> Option<f64> {
    let top = samples.iter().map(|v| side * v).fold(f64::NEG_INFINITY, f64::max);
    let count = |level: f64| samples.iter().filter(|v| is_at(level, side * **v)).count();
    let below = samples.iter().map(|v| side * v).filter(|v| !is_at(top, *v)).fold(f64::NEG_INFINITY, f64::max);
    let ties = count(top);
    (ties >= TIES && ties > PILE * count(below)).then_some(side * top)
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
        assert!(clipped(std::slice::from_ref(&recording), &[Limits::of(&recording)]).is_empty());
    }

    #[test]
    fn invariant_one_side_in_one_of_two_recordings_is_clipped_and_restored() {
        for side in [1.0, -1.0] {
            let level = 1.2 * rms(&healthy());
            let recordings = [healthy(), clipped_at(level, side)];
            let limits = [0, 1].map(|n| Limits::of(&recordings[n]));
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
}
