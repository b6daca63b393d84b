//! Effects: the causes that a machine can differ from its nominal rig by, one file each.
//!
//! A new effect is one file with a [`Definition`] and one line of the list at the end of this file, which makes it a
//! variant of [`EffectKind`]. The matches over [`EffectKind`] that decide how an effect is sought and drawn are
//! exhaustive, so the compiler lists what a new one still lacks. Parameters without a default
//! belong to the vocabulary; those with one (a phase, the place where friction acts) may be fitted but are not stated in
//! a diagnosis. theory, section 9, has the equations.

#[cfg(test)]
mod bearing_tests;
pub mod component;
pub mod course;
mod erf;
mod key;
mod library;
pub mod local_defect;
#[cfg(test)]
mod machine_tests;
#[cfg(test)]
mod registry_tests;
#[cfg(test)]
mod sensor_tests;
mod values;
mod waviness;

use std::fmt;

use component::Choices;
pub use key::ParameterKey;
pub use library::{Adds, LibraryTerms};
pub use values::Values;

use super::assembly::Assembly;
use super::config::{Domain, RigKind};

/// Definition of an effect: name, place in the rig, parameters, equation.
#[derive(Debug)]
pub struct Definition {
    /// Name in the vocabulary.
    pub name: &'static str,
    /// Kinds of rig that can have the effect.
    pub rigs: Rigs,
    /// Part of the model that the effect changes.
    pub site: Site,
    /// Persistence of the effect.
    pub timing: Timing,
    /// Rotation that the effect's phase is locked to.
    pub phase: Phase,
    /// True if the effect leaves the rig's linearisation as it is, so that noise passes through the rig unchanged.
    pub is_deterministic: bool,
    /// Parameters.
    pub parameters: &'static [Parameter],
    /// Terms that the effect adds to the library of a fit.
    pub library: LibraryTerms,
    /// Equation of the added term, in the rig's symbols.
    pub equation: fn(&Values) -> String,
    /// Adds the effect to an assembly; at zero strength nothing.
    pub apply: fn(&Values, &mut Assembly),
}

impl Definition {
    /// The parameter of this key.
    pub fn parameter(&self, key: ParameterKey) -> Option<&'static Parameter> {
        self.parameters.iter().find(|parameter| parameter.key == key)
    }
}

/// Kinds of rig that an effect exists for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rigs {
    /// The bearing rig only.
    Bearing,
    /// Bearing rig and rig of one degree of freedom.
    Both,
}

impl Rigs {
    /// Whether a rig of this kind can have the effect.
    pub fn include(self, kind: RigKind) -> bool {
        match (self, kind) {
            (Self::Both, _) | (Self::Bearing, RigKind::Bearing5Dof) => true,
            (Self::Bearing, RigKind::Sdof) => false,
        }
    }
}

/// Part of the model that an effect changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Site {
    /// Forces on degrees of freedom.
    Force,
    /// Contact of balls and races.
    Contact,
    /// Rotation of shaft and cage.
    Kinematics,
    /// Masses, springs, dampers and modes.
    Structure,
    /// Sensor, cable, converter and logger.
    Acquisition,
}

/// Persistence of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timing {
    /// Throughout every recording.
    Persistent,
    /// At a time of its own.
    Event,
}

/// Rotation that the phase of an effect is locked to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Shaft.
    Shaft,
    /// Cage.
    Cage,
    /// Spin of a ball.
    Ball,
    /// None.
    Free,
}

/// A parameter of an effect.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Name.
    pub key: ParameterKey,
    /// Unit; empty where it has none.
    pub unit: &'static str,
    /// Possible values.
    pub value_kind: ValueKind,
    /// Range of a search. Zero strength is outside if the scale is logarithmic.
    pub search_range: (f64, f64),
    /// Division of the range by a search.
    pub scale: Scale,
    /// Value where none is given; none for parameters of the vocabulary.
    pub default: ParameterDefault,
}

/// Possible values of a parameter.
#[derive(Clone, Copy, Debug)]
pub enum ValueKind {
    /// A number.
    Number(Domain),
    /// The name of a component or a channel.
    Name(Choices),
}

impl ValueKind {
    /// The domain of a number.
    pub fn number(self) -> Option<Domain> {
        match self {
            Self::Number(domain) => Some(domain),
            Self::Name(_) => None,
        }
    }

    /// For messages.
    pub fn describe(self, kind: RigKind) -> String {
        match self {
            Self::Number(domain) => domain.describe(),
            Self::Name(choices) => format!("one of {}", choices.names(kind).join(", ")),
        }
    }
}

/// Division of a range by a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// Evenly in the logarithm of the magnitude.
    Log,
    /// Every whole number, or every name.
    Each,
}

/// Default of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterDefault {
    /// No default: the parameter must be given.
    None,
    /// A number.
    Number(f64),
    /// A number for a bearing rig and a number for an sdof rig.
    ByKind(f64, f64),
    /// A name for a bearing rig; an sdof rig takes its first.
    Name(&'static str),
}

/// A value a parameter has where it is not given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DefaultValue {
    /// A number.
    Number(f64),
    /// A component's or channel's name.
    Name(&'static str),
}

impl Parameter {
    /// A number that must be given.
    pub const fn number(
        key: ParameterKey,
        unit: &'static str,
        domain: Domain,
        search_range: (f64, f64),
        scale: Scale,
    ) -> Self {
        Self { key, unit, value_kind: ValueKind::Number(domain), search_range, scale, default: ParameterDefault::None }
    }

    /// A component that must be given for a bearing rig.
    pub const fn component(choices: Choices) -> Self {
        let value_kind = ValueKind::Name(choices);
        Self {
            key: ParameterKey::Component,
            unit: "",
            value_kind,
            search_range: (0.0, 0.0),
            scale: Scale::Each,
            default: ParameterDefault::None,
        }
    }

    /// The channel that an effect of the sensor is in, usually all.
    pub const fn channel(usual: &'static str) -> Self {
        let parameter = Self::component(Choices::Channels).usually(ParameterDefault::Name(usual));
        Self { key: ParameterKey::Channel, ..parameter }
    }

    /// What excites a mode of the structure, usually the force along the sensor.
    pub const fn source() -> Self {
        let parameter = Self::component(Choices::Sources).usually(ParameterDefault::Name("along"));
        Self { key: ParameterKey::Source, ..parameter }
    }

    /// The course of a change, usually straight.
    pub const fn shape() -> Self {
        let parameter = Self::component(Choices::Shapes).usually(ParameterDefault::Name("straight"));
        Self { key: ParameterKey::Shape, ..parameter }
    }

    /// The symmetry of a law over the directions of a component, usually along each axis by itself.
    pub const fn symmetry() -> Self {
        let parameter = Self::component(Choices::Symmetries).usually(ParameterDefault::Name("axes"));
        Self { key: ParameterKey::Symmetry, ..parameter }
    }

    /// The saturation of a spring's nonlinear part, usually none: as a factor 1/(1 + s q²) of it.
    pub const fn saturation() -> Self {
        let range = (1e2, 1e14);
        let parameter = Self::number(ParameterKey::SaturationPerM2, "1/m²", Domain::NotNegative, range, Scale::Log);
        parameter.usually(ParameterDefault::Number(0.0))
    }

    /// The parameter with a default.
    pub const fn usually(mut self, usual: ParameterDefault) -> Self {
        self.default = usual;
        self
    }

    /// Whether a diagnosis states the parameter.
    pub fn in_vocabulary(&self) -> bool {
        self.default == ParameterDefault::None
    }

    /// Default for a rig of this kind.
    pub fn default_for(&self, kind: RigKind) -> Option<DefaultValue> {
        match (self.default, self.value_kind) {
            (_, ValueKind::Name(choices)) if kind == RigKind::Sdof => {
                choices.names(kind).first().map(|n| DefaultValue::Name(n))
            }
            (ParameterDefault::None, _) => None,
            (ParameterDefault::Number(number), _) => Some(DefaultValue::Number(number)),
            (ParameterDefault::ByKind(bearing, sdof), _) => {
                Some(DefaultValue::Number(if kind == RigKind::Sdof { sdof } else { bearing }))
            }
            (ParameterDefault::Name(name), _) => Some(DefaultValue::Name(name)),
        }
    }
}

macro_rules! registry {
    ($($kind:ident = $module:ident,)*) => {
        $(mod $module;)*

        /// An effect of the vocabulary.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum EffectKind {
            $(#[doc = concat!("`", stringify!($module), "`")] $kind,)*
        }

        impl EffectKind {
            /// All effects.
            pub const ALL: &[Self] = &[$(Self::$kind),*];

            /// The definition.
            pub fn definition(self) -> &'static Definition {
                match self {
                    $(Self::$kind => &$module::EFFECT,)*
                }
            }
        }
    };
}

registry! {
    OuterRaceDefect = outer_race_defect,
    InnerRaceDefect = inner_race_defect,
    BallDefect = ball_defect,
    OuterRaceWaviness = outer_race_waviness,
    InnerRaceWaviness = inner_race_waviness,
    Unbalance = unbalance,
    Misalignment = misalignment,
    ExcessClearance = excess_clearance,
    HardeningStiffness = hardening_stiffness,
    SofteningStiffness = softening_stiffness,
    AsymmetricStiffness = asymmetric_stiffness,
    StiffnessChange = stiffness_change,
    DampingChange = damping_change,
    MassChange = mass_change,
    CoulombFriction = coulomb_friction,
    ViscousFriction = viscous_friction,
    QuadraticDrag = quadratic_drag,
    EndStopContact = end_stop_contact,
    Backlash = backlash,
    ConstantForce = constant_force,
    RandomForce = random_force,
    StructuralResonance = structural_resonance,
    LoadStep = load_step,
    SpeedDrift = speed_drift,
    Shock = shock,
    CageSlip = cage_slip,
    ContactExponent = contact_exponent,
    LubricantFilm = lubricant_film,
    MainsInterference = mains_interference,
    SensorBias = sensor_bias,
    SensorGain = sensor_gain,
    TransverseSensitivity = transverse_sensitivity,
    SensorClipping = sensor_clipping,
    DroppedSamples = dropped_samples,
}

impl EffectKind {
    /// Whether a diagnosis may name the effect. The others exist in a rig only.
    pub const fn in_vocabulary(self) -> bool {
        !matches!(self, Self::LubricantFilm | Self::RandomForce | Self::TransverseSensitivity)
    }

    /// The effects that a diagnosis may name.
    pub fn vocabulary() -> impl Iterator<Item = Self> + Clone {
        Self::ALL.iter().copied().filter(|kind| kind.in_vocabulary())
    }

    /// The name in files.
    pub fn name(self) -> &'static str {
        self.definition().name
    }

    /// The effect of this name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.name() == name)
    }
}

impl fmt::Display for EffectKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
