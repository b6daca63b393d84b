//! Everything that can be the matter with a machine: the vocabulary of causes, one file each.
//!
//! A new effect is one file that holds a [`Definition`], and one line of the list at the end of this one. It says
//! what parameters it takes, what it does to a [`Plan`], and the term that it adds to the rig's equations.
//! Parameters of the vocabulary must be given; those with a default are of no interest in a diagnosis (a phase, the
//! place where a friction acts if nobody says) but a fit may need them.

#[cfg(test)]
mod bearing_tests;
pub mod component;
mod erf;
pub mod local_defect;
#[cfg(test)]
mod machine_tests;
#[cfg(test)]
mod registry_tests;
#[cfg(test)]
mod sensor_tests;
mod values;
mod waviness;

use component::Choices;
pub use values::Values;

use super::{assembly::Assembly, config::Domain};

/// An effect: what it is called, takes and does.
#[derive(Debug)]
pub struct Definition {
    /// Name in the vocabulary.
    pub name: &'static str,
    /// Kinds of rig that can have it.
    pub applies_to: Applies,
    /// Whether it only pushes or shapes and leaves the rig as it is for small motions, so that noise passes through the
    /// rig as without it.
    pub is_deterministic: bool,
    /// What it takes.
    pub parameters: &'static [Parameter],
    /// The term it adds, in the rig's symbols.
    pub equation: fn(&Values) -> String,
    /// Puts it into a plan. At zero strength it puts in nothing.
    pub apply: fn(&Values, &mut Assembly),
}

/// Kinds of rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Applies {
    /// `bearing-5dof`.
    Bearing,
    /// `bearing-5dof` and `sdof`.
    Both,
}

impl Applies {
    /// Whether a rig of this kind can have it.
    pub fn has(self, kind: &str) -> bool {
        match self {
            Self::Bearing => kind == "bearing-5dof",
            Self::Both => true,
        }
    }
}

/// Times as wide as where a search looks, from which on a number is far outside.
const FAR: f64 = 2.0;

/// A parameter of an effect.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Name in the vocabulary.
    pub name: &'static str,
    /// Unit; empty where it has none.
    pub unit: &'static str,
    /// What it can be.
    pub value_kind: ValueKind,
    /// Where a search looks, from and to. Zero strength is outside where the scale is logarithmic.
    pub search_range: (f64, f64),
    /// How a search divides that.
    pub scale: Scale,
    /// What it is where it is not given; [`Usual::Required`] for parameters of the vocabulary.
    pub default: ParameterDefault,
}

/// What a parameter can be.
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
    pub fn describe(self, kind: &str) -> String {
        match self {
            Self::Number(domain) => domain.describe(),
            Self::Name(choices) => format!("one of {}", choices.names(kind).join(", ")),
        }
    }
}

/// How a search divides a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// Evenly in the logarithm of the magnitude.
    Log,
    /// One whole number, or one name, after the other.
    Each,
}

/// What a parameter is where it is not given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterDefault {
    /// It must be given.
    Required,
    /// This number.
    Number(f64),
    /// This number for a bearing rig, and this for an sdof rig.
    ByKind(f64, f64),
    /// This name for a bearing rig; an sdof rig has its first.
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
        name: &'static str,
        unit: &'static str,
        domain: Domain,
        plausible: (f64, f64),
        scale: Scale,
    ) -> Self {
        Self {
            name,
            unit,
            value_kind: ValueKind::Number(domain),
            search_range: plausible,
            scale,
            default: ParameterDefault::Required,
        }
    }

    /// A component that must be given for a bearing rig.
    pub const fn component(choices: Choices) -> Self {
        let holds = ValueKind::Name(choices);
        Self {
            name: "component",
            unit: "",
            value_kind: holds,
            search_range: (0.0, 0.0),
            scale: Scale::Each,
            default: ParameterDefault::Required,
        }
    }

    /// The channel that an effect of the sensor is in, usually all.
    pub const fn channel(usual: &'static str) -> Self {
        let parameter = Self::component(Choices::Channels).usually(ParameterDefault::Name(usual));
        Self { name: "channel", ..parameter }
    }

    /// The same with a value for when it is not given.
    pub const fn usually(mut self, usual: ParameterDefault) -> Self {
        self.default = usual;
        self
    }

    /// Whether a value is not far outside of where a search looks. What has a dimension grows with the machine; what has none,
    /// such as a ratio or the share of a turn that a pit takes, does not.
    pub fn is_plausible(&self, value: f64) -> bool {
        let (low, high) = self.search_range;
        let of_any_machine = self.unit.is_empty() || matches!(self.value_kind, ValueKind::Number(Domain::Between(..)));
        let near = match self.scale {
            Scale::Log => (low / FAR..=high * FAR).contains(&value.abs()),
            Scale::Linear => {
                let beyond = 0.5 * (FAR - 1.0) * (high - low);
                (low - beyond..=high + beyond).contains(&value)
            }
            Scale::Each => true,
        };
        near || !of_any_machine
    }

    /// Whether a diagnosis states it.
    pub fn in_vocabulary(&self) -> bool {
        self.default == ParameterDefault::Required
    }

    /// What it is for a rig of this kind where it is not given.
    pub fn default_for(&self, kind: &str) -> Option<DefaultValue> {
        match (self.default, self.value_kind) {
            (_, ValueKind::Name(choices)) if kind == "sdof" => {
                choices.names(kind).first().map(|n| DefaultValue::Name(n))
            }
            (ParameterDefault::Required, _) => None,
            (ParameterDefault::Number(number), _) => Some(DefaultValue::Number(number)),
            (ParameterDefault::ByKind(bearing, sdof), _) => {
                Some(DefaultValue::Number(if kind == "sdof" { sdof } else { bearing }))
            }
            (ParameterDefault::Name(name), _) => Some(DefaultValue::Name(name)),
        }
    }
}

/// The effect of this name.
pub fn definition(name: &str) -> Option<&'static Definition> {
    REGISTRY.iter().copied().find(|definition| definition.name == name)
}

macro_rules! registry {
    ($($module:ident)*) => {
        $(mod $module;)*
        /// All effects.
        pub static REGISTRY: &[&Definition] = &[$(&$module::EFFECT),*];
    };
}

registry! {
    outer_race_defect
    inner_race_defect
    ball_defect
    outer_race_waviness
    inner_race_waviness
    unbalance
    misalignment
    excess_clearance
    hardening_stiffness
    softening_stiffness
    asymmetric_stiffness
    stiffness_change
    damping_change
    mass_change
    coulomb_friction
    viscous_friction
    quadratic_drag
    end_stop_contact
    backlash
    constant_force
    structural_resonance
    load_step
    speed_drift
    shock
    cage_slip
    contact_exponent
    mains_interference
    sensor_bias
    sensor_gain
    sensor_clipping
    dropped_samples
}
