//! Sought numbers of a rig, on the scale of a search.

use super::settings::SearchSettings;
use crate::rig::config::Domain;
use crate::rig::config::ModelKey;
use crate::rig::config::RigKey;
use crate::rig::effect::ParameterKey;
use crate::rig::{Rig, RigError};

/// A number of a rig by its dotted name, on a scale whose steps are about 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinate {
    /// Name, such as `outer.mass_kg` or `effect[1].depth_m`.
    pub key: RigKey,
    /// Relation of value and coordinate.
    pub scale: Scale,
    /// Whether D depends on it.
    pub moves_mean: bool,
    /// Whether S depends on it.
    pub moves_variance: bool,
}

/// Numbers of the rig that move only S: density of the process force, standard deviation of the sensor.
pub const NOISE: [RigKey; 2] = [RigKey::Model(ModelKey::ProcessForce), RigKey::Model(ModelKey::SensorNoise)];

/// Step of a difference quotient in a coordinate.
const STEP: f64 = SearchSettings::DEFAULT.coordinate_step;
/// Step of a difference quotient in an angle, rad.
pub const ANGLE_STEP: f64 = SearchSettings::DEFAULT.angle_step_rad;

/// Relation of a value and its coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// Logarithm, value = sign · eᵘ: for numbers with a sign and no size of their own.
    Log {
        /// 1 or −1.
        sign: f64,
    },
    /// Multiple, value = u · unit.
    Linear {
        /// A step that matters, in the value's unit.
        unit: f64,
    },
}

impl Coordinate {
    /// Coordinate of the number of a key, from its present value: logarithmic if the number has a sign and is not 0,
    /// otherwise linear in the unit that the key ends in, or in the value itself if that is greater.
    ///
    /// `None` for an unknown key or a whole number.
    pub fn for_key(rig: &Rig, key: impl Into<RigKey>) -> Option<Self> {
        let key = key.into();
        let value = rig.get(key)?;
        let signed = matches!(rig.domain(key)?, Domain::Positive | Domain::NotNegative | Domain::NotPositive);
        let scale = match rig.domain(key)? {
            Domain::Whole(..) => return None,
            _ if signed && value != 0.0 => Scale::Log { sign: value.signum() },
            _ => Scale::Linear { unit: unit(key.quantity(), value) },
        };
        let steady = rig.effect_of(key).is_some_and(|effect| effect.definition().is_deterministic);
        Some(Self {
            key,
            scale,
            moves_mean: !NOISE.contains(&key) && !matches!(key, RigKey::Effect { key: ParameterKey::PsdN2PerHz, .. }),
            moves_variance: !steady && key != RigKey::Model(ModelKey::Unbalance),
        })
    }

    /// Step of a difference quotient. An effect's angle takes the step of the shaft's: the two can be distinguished only if
    /// both quotients err alike.
    pub fn step(&self) -> f64 {
        if self.key.quantity().ends_with("_rad") { ANGLE_STEP } else { STEP }
    }

    /// Coordinate of a value.
    pub fn to_coordinate(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Log { sign } => (value * sign).max(f64::MIN_POSITIVE).ln(),
            Scale::Linear { unit } => value / unit,
        }
    }

    /// Value at a coordinate.
    pub fn to_value(&self, coordinate: f64) -> f64 {
        match self.scale {
            Scale::Log { sign } => sign * coordinate.exp(),
            Scale::Linear { unit } => coordinate * unit,
        }
    }

    /// Puts the value into a rig.
    ///
    /// # Errors
    /// A value out of the range of the key.
    pub fn put(&self, rig: &mut Rig, coordinate: f64) -> Result<(), RigError> {
        rig.set(self.key, self.to_value(coordinate))
    }
}

/// Step that matters in a number that may be 0, by the unit in its key; for a large number, the number itself. Angles and
/// times have no size.
fn unit(key: &str, value: f64) -> f64 {
    const UNITS: [(&str, f64); 8] = [
        ("clearance_m", 1e-6),
        ("_n_per_m", 1e6),
        ("_n_s_per_m", 100.0),
        ("_n_per_m2", 1e11),
        ("_n_per_m3", 1e16),
        ("_kg_m", 1e-4),
        ("_n", 10.0),
        ("_m", 1e-6),
    ];
    let least = UNITS.iter().find(|(end, _)| key.ends_with(end)).map_or(1.0, |(_, unit)| *unit);
    let sizeless = ["_rad", "_s"].iter().any(|end| key.ends_with(end));
    if sizeless { least } else { least.max(value.abs()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::EffectEntry;
    use crate::rig::config::RigKey;
    use crate::rig::effect::{EffectKind, ParameterKey};
    use crate::rig::test_support::nominal;

    #[test]
    fn what_is_large_is_searched_in_steps_of_its_own_size_and_an_angle_is_not() {
        let entry = EffectEntry::new(
            EffectKind::StructuralResonance,
            &[(ParameterKey::Gain, -12.0), (ParameterKey::FrequencyHz, 2000.0)],
        );
        let wavy = EffectEntry::new(
            EffectKind::InnerRaceWaviness,
            &[(ParameterKey::AmplitudeM, 1e-7), (ParameterKey::Lobes, 5.0), (ParameterKey::PhaseRad, 3.0)],
        );
        let rig = nominal().with_effect(entry).with_effect(wavy);
        let scale = |key: RigKey| Coordinate::for_key(&rig, key).unwrap().scale;
        assert_eq!(scale(RigKey::Effect { index: 0, key: ParameterKey::Gain }), Scale::Linear { unit: 12.0 });
        assert_eq!(scale(RigKey::Effect { index: 0, key: ParameterKey::FrequencyHz }), Scale::Log { sign: 1.0 });
        assert_eq!(scale(RigKey::Effect { index: 1, key: ParameterKey::PhaseRad }), Scale::Linear { unit: 1.0 });
    }
}
