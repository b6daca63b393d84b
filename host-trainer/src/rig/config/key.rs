//! The keys of `rig.toml`, and what each may hold.

use std::fmt;

use super::{BearingRig, Location, Machine, Restoring, RigKind, SdofRig};

/// Domain of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Domain {
    /// Any number.
    Any,
    /// Above 0.
    Positive,
    /// 0 or above.
    NotNegative,
    /// 0 or below.
    NotPositive,
    /// A whole number from the first to the last.
    Whole(usize, usize),
    /// Above the first and below the second.
    Between(f64, f64),
}

impl Domain {
    /// Whether a number is finite and in the domain.
    pub fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Any => true,
                Self::Positive => value > 0.0,
                Self::NotNegative => value >= 0.0,
                Self::NotPositive => value <= 0.0,
                Self::Whole(low, high) => value.fract() == 0.0 && value >= low as f64 && value <= high as f64,
                Self::Between(low, high) => value > low && value < high,
            }
    }

    /// For messages.
    pub fn describe(self) -> String {
        match self {
            Self::Any => "a number".into(),
            Self::Positive => "a number above 0".into(),
            Self::NotNegative => "a number, not negative".into(),
            Self::NotPositive => "a number, not positive".into(),
            Self::Whole(low, high) => format!("a whole number from {low} to {high}"),
            Self::Between(low, high) => format!("a number between {low} and {high}"),
        }
    }
}

macro_rules! model_keys {
    ($($kind:ident = $name:literal, $domain:expr;)*) => {
        /// Name of a number of the machine.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum ModelKey {
            $(#[doc = concat!("`", $name, "`")] $kind,)*
        }

        impl ModelKey {
            /// All keys of both kinds of rig, in the order in which they are written.
            pub const ALL: &[Self] = &[$(Self::$kind),*];

            /// The name in files: `section.key`, or `key` where a rig has no sections.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => $name,)*
                }
            }

            /// Domain of the number.
            pub const fn domain(self) -> Domain {
                match self {
                    $(Self::$kind => $domain,)*
                }
            }
        }
    };
}

use Domain::{Any, Between, NotNegative, Positive, Whole};

model_keys! {
    Balls = "bearing.balls", Whole(1, 200);
    BallDiameter = "bearing.ball_diameter_m", Positive;
    PitchDiameter = "bearing.pitch_diameter_m", Positive;
    ContactAngle = "bearing.contact_angle_rad", Between(-1.6, 1.6);
    RadialClearance = "bearing.radial_clearance_m", Any;
    ContactStiffness = "bearing.contact_stiffness_n_per_m1_5", Positive;
    ContactExponent = "bearing.contact_exponent", Between(0.9, 4.0);
    InnerMass = "inner.mass_kg", Positive;
    InnerStiffness = "inner.stiffness_n_per_m", NotNegative;
    InnerDamping = "inner.damping_n_s_per_m", NotNegative;
    OuterMass = "outer.mass_kg", Positive;
    OuterStiffness = "outer.stiffness_n_per_m", NotNegative;
    OuterDamping = "outer.damping_n_s_per_m", NotNegative;
    ResonatorMass = "resonator.mass_kg", Positive;
    ResonatorStiffness = "resonator.stiffness_n_per_m", NotNegative;
    ResonatorDamping = "resonator.damping_n_s_per_m", NotNegative;
    Unbalance = "excitation.unbalance_kg_m", NotNegative;
    ProcessForce = "excitation.process_force_psd_n2_per_hz", NotNegative;
    SensorNoise = "sensor.noise_std_m_per_s2", NotNegative;
    Mass = "mass_kg", Positive;
    Damping = "damping_n_s_per_m", NotNegative;
    Stiffness = "stiffness_n_per_m", NotNegative;
    InputGain = "input_gain_n_per_unit", Any;
    Gravity = "gravity_n", Any;
}

/// Numbers of a rig of one degree of freedom that come last in [`ModelKey::ALL`].
const SDOF_NUMBERS: usize = 5;

impl ModelKey {
    /// Value where the file leaves the key out; `None` for a key that it must have.
    pub const fn default_value(self) -> Option<f64> {
        match self {
            Self::Damping | Self::Stiffness | Self::Gravity => Some(0.0),
            Self::InputGain => Some(1.0),
            _ => None,
        }
    }

    /// The key of this name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|key| key.name() == name)
    }
}

impl fmt::Display for ModelKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Texts of `kind = "bearing-5dof"`.
pub(super) const BEARING_TEXTS: &[&str] = &["sensor.vertical", "sensor.horizontal"];

/// Texts of `kind = "sdof"`.
pub(super) const SDOF_TEXTS: &[&str] = &["restoring"];

/// Text where the file leaves the key out; `None` for a key that it must have.
pub(super) fn default_text(key: &str) -> Option<&'static str> {
    (key == "restoring").then(|| Restoring::Linear.name())
}

impl Machine {
    /// Kind of the rig.
    pub fn kind(&self) -> RigKind {
        match self {
            Self::Bearing(_) => RigKind::Bearing5Dof,
            Self::Sdof(_) => RigKind::Sdof,
        }
    }

    pub(super) fn keys(&self) -> &'static [ModelKey] {
        let (bearing, sdof) = ModelKey::ALL.split_at(ModelKey::ALL.len() - SDOF_NUMBERS);
        match self {
            Self::Bearing(_) => bearing,
            Self::Sdof(_) => sdof,
        }
    }

    pub(super) fn texts(&self) -> &'static [&'static str] {
        match self {
            Self::Bearing(_) => BEARING_TEXTS,
            Self::Sdof(_) => SDOF_TEXTS,
        }
    }

    /// Everything at 1, to be filled in key by key.
    pub(super) fn blank(kind: RigKind) -> Self {
        let support = || super::Support { mass_kg: 1.0, stiffness_n_per_m: 1.0, damping_n_s_per_m: 1.0 };
        match kind {
            RigKind::Bearing5Dof => Self::Bearing(BearingRig {
                bearing: super::Bearing {
                    balls: 1,
                    ball_diameter_m: 1.0,
                    pitch_diameter_m: 1.0,
                    contact_angle_rad: 1.0,
                    radial_clearance_m: 1.0,
                    contact_stiffness_n_per_m1_5: 1.0,
                    contact_exponent: 1.0,
                },
                inner: support(),
                outer: support(),
                resonator: support(),
                excitation: super::Excitation { unbalance_kg_m: 1.0, process_force_psd_n2_per_hz: 1.0 },
                sensor: super::Sensor {
                    noise_std_m_per_s2: 1.0,
                    vertical: Location::ResonatorY,
                    horizontal: Location::OuterX,
                },
            }),
            RigKind::Sdof => Self::Sdof(SdofRig {
                mass_kg: 1.0,
                damping_n_s_per_m: 1.0,
                stiffness_n_per_m: 1.0,
                input_gain_n_per_unit: 1.0,
                restoring: Restoring::Linear,
                gravity_n: 1.0,
            }),
        }
    }

    /// A number that is stored as one; `None` for a whole number, and for a key of the other kind of rig.
    pub(super) fn field(&mut self, key: ModelKey) -> Option<&mut f64> {
        match self {
            Self::Bearing(rig) => bearing_field(rig, key),
            Self::Sdof(rig) => sdof_field(rig, key),
        }
    }

    /// A text, as in the file.
    pub(super) fn text(&self, key: &str) -> Option<&'static str> {
        match (self, key) {
            (Self::Bearing(rig), "sensor.vertical") => Some(rig.sensor.vertical.name()),
            (Self::Bearing(rig), "sensor.horizontal") => Some(rig.sensor.horizontal.name()),
            (Self::Sdof(rig), "restoring") => Some(rig.restoring.name()),
            _ => None,
        }
    }

    /// Sets a text; the error is what is expected.
    pub(super) fn set_text(&mut self, key: &str, value: &str) -> Result<(), String> {
        match (self, key) {
            (Self::Bearing(rig), "sensor.vertical" | "sensor.horizontal") => {
                let names = Location::ALL.map(Location::name).join(", ");
                let location = Location::parse(value).ok_or_else(|| format!("one of {names}"))?;
                match key {
                    "sensor.vertical" => rig.sensor.vertical = location,
                    _ => rig.sensor.horizontal = location,
                }
                Ok(())
            }
            (Self::Sdof(rig), "restoring") => {
                let all = [Restoring::Linear, Restoring::Pendulum];
                let found = all.into_iter().find(|r| r.name() == value);
                rig.restoring = found.ok_or("\"linear\" or \"pendulum\"")?;
                Ok(())
            }
            _ => Err("another key".into()),
        }
    }
}

fn bearing_field(rig: &mut BearingRig, key: ModelKey) -> Option<&mut f64> {
    let BearingRig { bearing, inner, outer, resonator, excitation, sensor } = rig;
    Some(match key {
        ModelKey::BallDiameter => &mut bearing.ball_diameter_m,
        ModelKey::PitchDiameter => &mut bearing.pitch_diameter_m,
        ModelKey::ContactAngle => &mut bearing.contact_angle_rad,
        ModelKey::RadialClearance => &mut bearing.radial_clearance_m,
        ModelKey::ContactStiffness => &mut bearing.contact_stiffness_n_per_m1_5,
        ModelKey::ContactExponent => &mut bearing.contact_exponent,
        ModelKey::InnerMass => &mut inner.mass_kg,
        ModelKey::InnerStiffness => &mut inner.stiffness_n_per_m,
        ModelKey::InnerDamping => &mut inner.damping_n_s_per_m,
        ModelKey::OuterMass => &mut outer.mass_kg,
        ModelKey::OuterStiffness => &mut outer.stiffness_n_per_m,
        ModelKey::OuterDamping => &mut outer.damping_n_s_per_m,
        ModelKey::ResonatorMass => &mut resonator.mass_kg,
        ModelKey::ResonatorStiffness => &mut resonator.stiffness_n_per_m,
        ModelKey::ResonatorDamping => &mut resonator.damping_n_s_per_m,
        ModelKey::Unbalance => &mut excitation.unbalance_kg_m,
        ModelKey::ProcessForce => &mut excitation.process_force_psd_n2_per_hz,
        ModelKey::SensorNoise => &mut sensor.noise_std_m_per_s2,
        ModelKey::Balls
        | ModelKey::Mass
        | ModelKey::Damping
        | ModelKey::Stiffness
        | ModelKey::InputGain
        | ModelKey::Gravity => return None,
    })
}

fn sdof_field(rig: &mut SdofRig, key: ModelKey) -> Option<&mut f64> {
    Some(match key {
        ModelKey::Mass => &mut rig.mass_kg,
        ModelKey::Damping => &mut rig.damping_n_s_per_m,
        ModelKey::Stiffness => &mut rig.stiffness_n_per_m,
        ModelKey::InputGain => &mut rig.input_gain_n_per_unit,
        ModelKey::Gravity => &mut rig.gravity_n,
        _ => return None,
    })
}
