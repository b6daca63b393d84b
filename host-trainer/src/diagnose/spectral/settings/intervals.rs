//! Settings of the intervals.

use serde::Serialize;

use crate::rig::effect::{EffectKind, ParameterKey};

/// Settings of the intervals: standard deviations of what a form that is not quite the rig's moves an estimate by. Chosen on
/// `evaluate`, seeds 43 (`real`) and 44 (`exact`), every fourth case, and 53 to 56 (`exact` and `real`), every second, by the
/// errors of right causes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct IntervalSettings {
    /// Of a strength or a damping, as a share of it.
    pub strength: f64,
    /// Of a defect's depth, as a share of it.
    pub depth: f64,
    /// Of a defect's width, as a share of it.
    pub width: f64,
    /// Of a waviness's amplitude, as a share of it.
    pub waviness: f64,
    /// Of an angle, rad.
    pub angle_rad: f64,
    /// The same by one sensor alone, of the angle from the load. Chosen on the outer races of seeds 53 to 58, each channel alone.
    pub angle_of_one_rad: f64,
    /// Of a mass, stiffness, frequency or an exponent, as a share of it.
    pub number: f64,
    /// Of a mode's damping ratio, as a share of it: what excites it is not known.
    pub damping_ratio: f64,
    /// Of a sensor's gain, as a share of it: the noise of the machine has a level of its own.
    pub gain: f64,
    /// Of the cage's slip: that of a healthy machine is not known.
    pub slip: f64,
    /// Factor either way at which an interval ends: a number that is not known to two decades is not known. By hand.
    pub unknown_factor: f64,
}

impl IntervalSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        strength: 0.04,
        depth: 0.2,
        width: 0.3,
        waviness: 0.15,
        angle_rad: 0.02,
        angle_of_one_rad: 0.18,
        number: 0.01,
        damping_ratio: 0.25,
        gain: 0.05,
        slip: 0.0015,
        unknown_factor: 100.0,
    };

    /// Standard deviation of a parameter at a value by the form of its effect.
    pub fn form_error(&self, kind: EffectKind, key: ParameterKey, value: f64) -> f64 {
        use ParameterKey::{
            AmplitudeM, AngleRad, DampingRatio, DepthM, Exponent, Fraction, FrequencyHz, Value, WidthRad,
        };
        let share = match key {
            AngleRad => return self.angle_rad,
            Fraction => return self.slip,
            DepthM => self.depth,
            WidthRad => self.width,
            AmplitudeM => self.waviness,
            DampingRatio => self.damping_ratio,
            Value if kind == EffectKind::SensorGain => self.gain,
            Value if kind == EffectKind::DampingChange => self.strength,
            Exponent | FrequencyHz | Value => self.number,
            _ => self.strength,
        };
        share * value.abs()
    }

    /// Whether an interval is one of a number that is not known.
    pub fn is_of_unknown(&self, [from, to]: [f64; 2]) -> bool {
        let widest = self.unknown_factor.powi(2);
        from * to > 0.0 && (to / from).max(from / to) > 0.99 * widest
    }
}
