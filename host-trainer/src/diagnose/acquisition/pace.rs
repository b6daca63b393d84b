//! Speed of a shaft that changes within recordings, as their tachometers show it.
//!
//! An even change is an effect of the rig, which the search finds. Recordings of another one are resampled to the constant mean speed,
//! so that whatever else they have is found as at that.

use super::{Fault, SURE};
use crate::recording::Recording;
use crate::rig::EffectEntry;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::signal::interpolate::{Interpolator, held};
use crate::signal::order::ShaftAngle;
use crate::stats::significance::two_sided;

/// Greatest standard deviation of a speed over its mean that is the wander of a drive: by hand.
pub const WANDER: f64 = 0.003;
/// Standard deviations of a healthy wander that this is. By hand.
const WANDER_Z: f64 = 3.0;
/// Share of the standard deviation that a straight line leaves of an even change. By hand.
const UNEVEN: f64 = 0.25;
/// Times at which a speed is read, and turns over which.
const TIMES: usize = 100;
const TURNS: f64 = 2.0;
/// Least share of the recordings whose speed changes.
const LEAST_SHARE: f64 = 0.5;

/// Speeds that change within recordings.
#[derive(Clone, Debug)]
pub struct Pace {
    /// The change as a fault.
    pub fault: Fault,
    /// Recordings with a tachometer, by their names.
    turning: Vec<(String, Turning)>,
}

/// Rotation of a shaft in a recording.
#[derive(Clone, Debug)]
struct Turning {
    angle: ShaftAngle,
    sample_rate_hz: f64,
    /// Turns at the first sample.
    start: f64,
    /// Mean speed, Hz.
    mean_hz: f64,
    samples: usize,
}

/// How a speed changes.
#[derive(Clone, Copy, Debug)]
struct Change {
    /// Standard deviation over the mean.
    std: f64,
    /// The same beside a straight line.
    uneven: f64,
    /// Slope of that, 1/s.
    rate_per_s: f64,
    /// Difference between the fastest and the slowest speed over the mean.
    range: f64,
}

impl Pace {
    /// Change of the speed in recordings with a tachometer, which are resampled to their mean speed; `None` if there is none, or an
    /// even one.
    pub fn even_out(recordings: &mut [Recording]) -> Option<Self> {
        let turning: Vec<(String, Turning)> =
            recordings.iter().filter_map(|r| Some((r.name(), Turning::of(r)?))).collect();
        let changes: Vec<Change> = turning.iter().map(|(_, turning)| turning.change()).collect();
        let changing = changes.iter().filter(|change| change.std > WANDER).count();
        let mean = |of: &dyn Fn(&Change) -> f64| changes.iter().map(of).sum::<f64>() / changes.len() as f64;
        let (std, uneven) = (mean(&|c| c.std), mean(&|c| c.uneven));
        if changing == 0 || (changing as f64) < LEAST_SHARE * recordings.len() as f64 || uneven < UNEVEN * std {
            return None;
        }
        let effect = EffectEntry::new(EffectKind::SpeedDrift, &[(ParameterKey::RatePerS, mean(&|c| c.rate_per_s))]);
        let evidence = format!(
            "The tachometer shows a speed that changes within {changing} of {} recordings, by {:.2} % from its lowest to its highest, and not evenly: a straight line leaves {:.0} % of its standard deviation.",
            recordings.len(),
            100.0 * mean(&|c| c.range),
            100.0 * uneven / std,
        );
        for recording in recordings.iter_mut() {
            let name = recording.name();
            if let Some((_, turning)) = turning.iter().find(|(of, _)| *of == name) {
                turning.even_out(recording);
            }
        }
        let fault = Fault { effect, evidence, p_value: two_sided(WANDER_Z * std / WANDER), probability: SURE };
        Some(Self { fault, turning })
    }

    /// Samples at the constant speed of the recording of that name as they are at its own; `None` if that has no tachometer.
    pub fn as_recorded(&self, recording: &str, samples: &[f64]) -> Option<Vec<f64>> {
        let (_, turning) = self.turning.iter().find(|(name, _)| name == recording)?;
        Some(resampled(samples, |i| turning.even_place(i)))
    }
}

impl Turning {
    /// Rotation by a recording's tachometer.
    fn of(recording: &Recording) -> Option<Self> {
        let sample_rate_hz = recording.sample_rate_hz;
        let angle = ShaftAngle::from_tacho(&recording.channel("tacho")?.samples, sample_rate_hz).ok()?;
        let [start, end] = [0.0, recording.duration_s()].map(|time_s| angle.turns(time_s));
        let mean_hz = (end - start) / recording.duration_s();
        Some(Self { angle, sample_rate_hz, start, mean_hz, samples: recording.len() })
    }

    fn change(&self) -> Change {
        let duration_s = self.samples as f64 / self.sample_rate_hz;
        let half_s = 0.5 * TURNS / self.mean_hz;
        let time = |n: usize| half_s + (duration_s - 2.0 * half_s) * n as f64 / (TIMES - 1) as f64;
        let speed = |t: f64| (self.angle.turns(t + half_s) - self.angle.turns(t - half_s)) / TURNS;
        let times: Vec<f64> = (0..TIMES).map(time).collect();
        let speeds: Vec<f64> = times.iter().map(|t| speed(*t)).collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (mean_s, mean_speed) = (mean(&times), mean(&speeds));
        let each = || times.iter().map(|t| t - mean_s).zip(speeds.iter().map(|v| v / mean_speed - 1.0));
        let squares = each().map(|(t, _)| t * t).sum::<f64>();
        let rate_per_s = each().map(|(t, v)| t * v).sum::<f64>() / squares;
        let rms =
            |of: &dyn Fn(f64, f64) -> f64| (each().map(|(t, v)| of(t, v).powi(2)).sum::<f64>() / TIMES as f64).sqrt();
        let (low, high) = speeds.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(*v), high.max(*v)));
        Change {
            std: rms(&|_, v| v),
            uneven: rms(&|t, v| v - rate_per_s * t),
            rate_per_s,
            range: (high - low) / mean_speed,
        }
    }

    /// Sample of the recording at which the shaft is where it is at sample `even` of the one at constant speed.
    fn place(&self, even: usize) -> f64 {
        self.angle.time_s(self.start + self.mean_hz * even as f64 / self.sample_rate_hz) * self.sample_rate_hz
    }

    /// Inverse of [`Self::place`].
    fn even_place(&self, sample: usize) -> f64 {
        (self.angle.turns(sample as f64 / self.sample_rate_hz) - self.start) / self.mean_hz * self.sample_rate_hz
    }

    /// Resamples a recording to the constant mean speed; of the tachometer the time of each pulse.
    fn even_out(&self, recording: &mut Recording) {
        for channel in &mut recording.channels {
            channel.samples = match channel.name.as_str() {
                "tacho" => (0..self.samples).map(|i| self.pulse(i)).collect(),
                _ => resampled(&channel.samples, |i| self.place(i)),
            };
        }
        recording.shaft_hz = Some(self.mean_hz);
    }

    /// Tachometer at constant speed: a turn begins within the sample period before its pulse.
    fn pulse(&self, sample: usize) -> f64 {
        let turns = |samples: f64| (self.start + self.mean_hz * samples / self.sample_rate_hz).floor();
        f64::from(turns(sample as f64) > turns(sample as f64 - 1.0))
    }
}

/// Signal at other places, in samples.
fn resampled(samples: &[f64], place: impl Fn(usize) -> f64) -> Vec<f64> {
    let interpolator = Interpolator::new();
    (0..samples.len()).map(|i| interpolator.at(place(i), held(samples))).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::recording::Channel;
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{Start, simulate};

    /// Recordings of order 7 of a shaft whose angle in turns is a function of the time.
    fn turning(turns: impl Fn(f64) -> f64) -> Vec<Recording> {
        let mut recording = simulate(&nominal(), &condition(30.0, 500.0, 25_600), &Start::seeded(1)).unwrap();
        let at = |i: usize| turns(i as f64 / 25_600.0);
        for Channel { name, samples, .. } in &mut recording.channels {
            let is_tacho = name == "tacho";
            let value = |i: usize| match is_tacho {
                true => f64::from(i > 0 && at(i).floor() > at(i - 1).floor()),
                false => (TAU * 7.0 * at(i)).sin(),
            };
            *samples = (0..25_600).map(value).collect();
        }
        vec![recording]
    }

    /// A speed that rises by 1.2 % from 0.4 to 0.7 s: order 7 becomes a tone, and is as it was on the way back.
    #[test]
    fn a_shaft_that_changes_its_speed_unevenly_is_followed() {
        let risen_s = |t: f64| {
            let share = ((t - 0.4) / 0.3).clamp(0.0, 1.0);
            0.5 * (0.3 * share - 0.3 / PI * (PI * share).sin()) + (t - 0.7).max(0.0)
        };
        let recorded = turning(|t| 30.0 * (t + 0.012 * risen_s(t)));
        let mut recordings = recorded.clone();
        let pace = Pace::even_out(&mut recordings).unwrap();
        let rate = pace.fault.effect.number(ParameterKey::RatePerS).unwrap();
        assert!((0.012..0.022).contains(&rate), "{rate}");
        let hz = recordings[0].shaft_hz.unwrap();
        let even = &recordings[0].channels[0].samples;
        let start = Turning::of(&recorded[0]).unwrap().start;
        let off = |i: usize| (even[i] - (TAU * 7.0 * (start + hz * i as f64 / 25_600.0)).sin()).abs();
        let worst = (100..25_500).map(off).fold(0.0, f64::max);
        assert!(worst < 0.06, "{worst}");
        let back = pace.as_recorded(&recordings[0].name(), even).unwrap();
        let off = |i: usize| (back[i] - recorded[0].channels[0].samples[i]).abs();
        let worst = (100..25_500).map(off).fold(0.0, f64::max);
        assert!(worst < 1e-3, "{worst}");
        assert!(Pace::even_out(&mut recordings).is_none(), "even by now");
    }

    #[test]
    fn null_a_shaft_that_drifts_evenly_or_wanders_is_not() {
        let mut even = turning(|t| 30.0 * (t + 0.5 * 0.05 * t * t));
        let mut wandering = turning(|t| 30.0 * (t + 0.002 / TAU * (TAU * t).sin()));
        for recordings in [&mut even, &mut wandering] {
            let before = recordings.clone();
            assert!(Pace::even_out(recordings).is_none() && *recordings == before);
        }
    }
}
