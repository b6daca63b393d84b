//! Terms of the library: what each effect of the vocabulary adds to the force, or to the sensor's signal.
//!
//! Strengths are linear and fitted; nonlinear parameters of a term (the gap of a stop, the width of a play, the velocity at
//! which friction turns over, a mode's frequency) are searched over a grid within the range of the data, each value a
//! [`Variant`].

use crate::identify::force_balance::equation::Parameter;
use crate::rig::EffectEntry;
use crate::rig::effect::{EffectKind, ParameterKey};

/// Meaning of a fitted coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Meaning {
    /// Strength of the effect: this parameter.
    Strength(ParameterKey),
    /// Stiffness of the spring, which the rig has already: its stated one, N/m.
    Spring(f64),
    /// Change of a parameter of the rig.
    Change(Parameter),
    /// Sensor gain less 1.
    Gain,
    /// Gain of a mode between mass and sensor.
    Mode,
}

/// Range that a coefficient must be in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sign {
    /// Positive: the force dissipates, or pushes back.
    Positive,
    /// Either.
    Any,
    /// Within two values.
    Within(f64, f64),
}

impl Sign {
    /// Whether a coefficient is in the range.
    pub fn holds(self, value: f64) -> bool {
        match self {
            Self::Positive => value > 0.0,
            Self::Any => true,
            Self::Within(low, high) => (low..high).contains(&value),
        }
    }
}

/// State that a missing force depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Position q.
    Position,
    /// Velocity q̇.
    Velocity,
    /// Acceleration q̈.
    Acceleration,
    /// Time t.
    Time,
    /// None: the sensor's signal, not a force.
    Sensor,
}

impl State {
    /// Symbol in `diagnosis.json`.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Position | Self::Sensor => "q",
            Self::Velocity => "q̇",
            Self::Acceleration => "q̈",
            Self::Time => "t",
        }
    }
}

/// Candidate cause.
#[derive(Clone, Debug)]
pub struct Term {
    /// Effect.
    pub kind: EffectKind,
    /// Meaning of the coefficient.
    pub meaning: Meaning,
    /// Range of the coefficient.
    pub sign: Sign,
    /// State that the force depends on.
    pub state: State,
    /// Grid of nonlinear parameters.
    pub variants: Vec<Variant>,
}

/// Term with its nonlinear parameters fixed.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Effect at unit strength.
    pub entry: EffectEntry,
    /// Column of the term.
    pub column: usize,
}

impl Variant {
    /// Whether it is a spring whose nonlinear part saturates.
    pub fn saturates(&self) -> bool {
        self.entry.number(ParameterKey::SaturationPerM2).is_some_and(|saturation| saturation > 0.0)
    }
}

/// Part of the diagnosis of a rig of one degree of freedom that seeks an effect.
#[cfg(test)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SoughtBy {
    /// The library: it has a term of the effect.
    Library,
    /// The coefficient of another effect's term, by its sign or size.
    Other(EffectKind),
    /// The tests of the samples themselves.
    Acquisition,
}

/// Part of the diagnosis that seeks an effect; `None` where a rig of one degree of freedom cannot have it. The match is
/// exhaustive, so that no effect is silently never sought.
#[cfg(test)]
pub fn sought_by(kind: EffectKind) -> Option<SoughtBy> {
    Some(match kind {
        EffectKind::OuterRaceDefect
        | EffectKind::InnerRaceDefect
        | EffectKind::BallDefect
        | EffectKind::OuterRaceWaviness
        | EffectKind::InnerRaceWaviness
        | EffectKind::Unbalance
        | EffectKind::Misalignment
        | EffectKind::ExcessClearance
        | EffectKind::SpeedDrift
        | EffectKind::CageSlip
        | EffectKind::ContactExponent
        | EffectKind::LubricantFilm
        | EffectKind::RandomForce
        | EffectKind::TransverseSensitivity => return None,
        EffectKind::HardeningStiffness
        | EffectKind::AsymmetricStiffness
        | EffectKind::StiffnessChange
        | EffectKind::DampingChange
        | EffectKind::MassChange
        | EffectKind::CoulombFriction
        | EffectKind::QuadraticDrag
        | EffectKind::EndStopContact
        | EffectKind::Backlash
        | EffectKind::ConstantForce
        | EffectKind::StructuralResonance
        | EffectKind::LoadStep
        | EffectKind::SensorGain => SoughtBy::Library,
        EffectKind::SofteningStiffness => SoughtBy::Other(EffectKind::HardeningStiffness),
        EffectKind::ViscousFriction => SoughtBy::Other(EffectKind::DampingChange),
        EffectKind::SensorBias => SoughtBy::Other(EffectKind::ConstantForce),
        EffectKind::MainsInterference | EffectKind::SensorClipping | EffectKind::Shock | EffectKind::DroppedSamples => {
            SoughtBy::Acquisition
        }
    })
}
