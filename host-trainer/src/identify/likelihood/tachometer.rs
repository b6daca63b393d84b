//! Tachometer's reading of the shaft's angle at a recording's first sample: the last term of theory (54).
//!
//! A pulse is the first sample of a turn, so that the shaft's angle is known to a part of a sample, whatever the machine does.
//! The likelihood takes it as a normally distributed measurement.

use std::f64::consts::TAU;

use super::settings::TachometerSettings;
use crate::recording::Recording;
use crate::signal::order::ShaftAngle;

const SETTINGS: TachometerSettings = TachometerSettings::DEFAULT;

/// Shaft angle at the first sample by the tachometer, with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    shaft_rad: f64,
    deviation_rad: f64,
    /// Share of its speed that the shaft gains a second.
    pub gains_per_s: f64,
}

impl Reading {
    /// Reading of the channel `tacho`; `None` without one, or if its pulses are not one a turn at about `shaft_hz`.
    pub fn from_recording(recording: &Recording, shaft_hz: f64) -> Option<Self> {
        let rate = recording.sample_rate_hz;
        let angle = ShaftAngle::from_tacho(&recording.channel("tacho")?.samples, rate).ok()?;
        let ratio = angle.mean_hz() / shaft_hz;
        let half_s = 0.5 * recording.duration_s();
        let [start, middle, end] = [0.0, 1.0, 2.0].map(|k| angle.turns(k * half_s));
        let reading = Self {
            shaft_rad: TAU * start,
            deviation_rad: SETTINGS.std_samples * TAU * shaft_hz / rate,
            gains_per_s: (end - 2.0 * middle + start) / (shaft_hz * half_s * half_s),
        };
        (1.0 / SETTINGS.max_speed_ratio..SETTINGS.max_speed_ratio).contains(&ratio).then_some(reading)
    }

    /// Read angle, plus whole turns, nearest to `shaft_rad`, rad.
    pub fn next_to(self, shaft_rad: f64) -> f64 {
        shaft_rad - self.off(shaft_rad)
    }

    /// Difference of an angle from the reading, rad, at most half a turn either way.
    pub fn off(self, shaft_rad: f64) -> f64 {
        (shaft_rad - self.shaft_rad + 0.5 * TAU).rem_euclid(TAU) - 0.5 * TAU
    }

    /// Negative log-likelihood −ln L of an angle, without constants.
    pub fn neg_log_likelihood(self, shaft_rad: f64) -> f64 {
        0.5 * (self.off(shaft_rad) / self.deviation_rad).powi(2)
    }

    /// Slope of [`Reading::neg_log_likelihood`].
    pub fn gradient(self, shaft_rad: f64) -> f64 {
        self.off(shaft_rad) * self.information()
    }

    /// Curvature of [`Reading::neg_log_likelihood`].
    pub fn information(self) -> f64 {
        self.deviation_rad.powi(-2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::effect::{EffectKind, ParameterKey};
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{EffectEntry, Rig, Run, Start, simulate_many};

    fn recording(rig: &Rig) -> Recording {
        let start = Start { shaft_angle0_rad: 1.9, ..Start::seeded(3) };
        simulate_many(&[Run { rig, condition: condition(30.0, 500.0, 25_600), start }]).unwrap().remove(0)
    }

    #[test]
    fn the_angle_at_the_first_sample_and_a_drift_are_read() {
        let reading = Reading::from_recording(&recording(&nominal()), 30.0).unwrap();
        assert!(reading.off(1.9).abs() < TAU * 30.0 / 25_600.0, "{reading:?}");
        assert!(reading.gains_per_s.abs() < 1e-3, "{reading:?}");
        assert!((reading.next_to(1.9 + 5.0 * TAU) - 1.9 - 5.0 * TAU).abs() < 0.01);
        let drift = EffectEntry::new(EffectKind::SpeedDrift, &[(ParameterKey::RatePerS, 0.04)]);
        let reading = Reading::from_recording(&recording(&nominal().with_effect(drift)), 30.0).unwrap();
        assert!((reading.gains_per_s / 0.04 - 1.0).abs() < 0.02, "{reading:?}");
    }

    #[test]
    fn what_is_no_pulse_a_turn_is_not_read() {
        let mut recording = recording(&nominal());
        assert_eq!(Reading::from_recording(&recording, 60.0), None);
        recording.channels.retain(|c| c.name != "tacho");
        assert_eq!(Reading::from_recording(&recording, 30.0), None);
    }
}
