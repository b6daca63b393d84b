//! The keys of `rig.toml`, and what each may hold.

use super::{BearingRig, Location, Machine, Restoring, SdofRig};

/// What a number may be.
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
    /// Whether a finite number is in it.
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

/// A number of the model.
pub(super) struct Key {
    /// `section.key`, or `key`.
    pub name: &'static str,
    /// What it may be.
    pub domain: Domain,
}

const fn key(name: &'static str, domain: Domain) -> Key {
    Key { name, domain }
}

use Domain::{Any, Between, NotNegative, Positive, Whole};

/// Numbers of `kind = "bearing-5dof"`, in the order in which they are written.
pub(super) const BEARING: &[Key] = &[
    key("bearing.balls", Whole(1, 200)),
    key("bearing.ball_diameter_m", Positive),
    key("bearing.pitch_diameter_m", Positive),
    key("bearing.contact_angle_rad", Between(-1.6, 1.6)),
    key("bearing.radial_clearance_m", Any),
    key("bearing.contact_stiffness_n_per_m1_5", Positive),
    key("bearing.contact_exponent", Between(0.9, 4.0)),
    key("inner.mass_kg", Positive),
    key("inner.stiffness_n_per_m", NotNegative),
    key("inner.damping_n_s_per_m", NotNegative),
    key("outer.mass_kg", Positive),
    key("outer.stiffness_n_per_m", NotNegative),
    key("outer.damping_n_s_per_m", NotNegative),
    key("resonator.mass_kg", Positive),
    key("resonator.stiffness_n_per_m", NotNegative),
    key("resonator.damping_n_s_per_m", NotNegative),
    key("excitation.unbalance_kg_m", NotNegative),
    key("excitation.process_force_psd_n2_per_hz", NotNegative),
    key("sensor.noise_std_m_per_s2", NotNegative),
];

/// Texts of `kind = "bearing-5dof"`.
pub(super) const BEARING_TEXTS: &[&str] = &["sensor.vertical", "sensor.horizontal"];

/// Numbers of `kind = "sdof"`.
pub(super) const SDOF: &[Key] = &[
    key("mass_kg", Positive),
    key("damping_n_s_per_m", NotNegative),
    key("stiffness_n_per_m", NotNegative),
    key("input_gain_n_per_unit", Any),
    key("gravity_n", Any),
];

/// Texts of `kind = "sdof"`.
pub(super) const SDOF_TEXTS: &[&str] = &["restoring"];

impl Machine {
    /// The name in files.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Bearing(_) => "bearing-5dof",
            Self::Sdof(_) => "sdof",
        }
    }

    pub(super) fn keys(&self) -> &'static [Key] {
        match self {
            Self::Bearing(_) => BEARING,
            Self::Sdof(_) => SDOF,
        }
    }

    pub(super) fn texts(&self) -> &'static [&'static str] {
        match self {
            Self::Bearing(_) => BEARING_TEXTS,
            Self::Sdof(_) => SDOF_TEXTS,
        }
    }

    /// Everything at 1, to be filled in key by key.
    pub(super) fn blank(kind: &str) -> Option<Self> {
        let support = || super::Support { mass_kg: 1.0, stiffness_n_per_m: 1.0, damping_n_s_per_m: 1.0 };
        match kind {
            "bearing-5dof" => Some(Self::Bearing(BearingRig {
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
            })),
            "sdof" => Some(Self::Sdof(SdofRig {
                mass_kg: 1.0,
                damping_n_s_per_m: 1.0,
                stiffness_n_per_m: 1.0,
                input_gain_n_per_unit: 1.0,
                restoring: Restoring::Linear,
                gravity_n: 1.0,
            })),
            _ => None,
        }
    }

    /// A number that is stored as one.
    pub(super) fn field(&mut self, key: &str) -> Option<&mut f64> {
        match self {
            Self::Bearing(rig) => bearing_field(rig, key),
            Self::Sdof(rig) => Some(match key {
                "mass_kg" => &mut rig.mass_kg,
                "damping_n_s_per_m" => &mut rig.damping_n_s_per_m,
                "stiffness_n_per_m" => &mut rig.stiffness_n_per_m,
                "input_gain_n_per_unit" => &mut rig.input_gain_n_per_unit,
                "gravity_n" => &mut rig.gravity_n,
                _ => return None,
            }),
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

fn bearing_field<'a>(rig: &'a mut BearingRig, key: &str) -> Option<&'a mut f64> {
    let (section, key) = key.split_once('.')?;
    let support = match section {
        "inner" => &mut rig.inner,
        "outer" => &mut rig.outer,
        "resonator" => &mut rig.resonator,
        _ => {
            let bearing = &mut rig.bearing;
            return Some(match (section, key) {
                ("bearing", "ball_diameter_m") => &mut bearing.ball_diameter_m,
                ("bearing", "pitch_diameter_m") => &mut bearing.pitch_diameter_m,
                ("bearing", "contact_angle_rad") => &mut bearing.contact_angle_rad,
                ("bearing", "radial_clearance_m") => &mut bearing.radial_clearance_m,
                ("bearing", "contact_stiffness_n_per_m1_5") => &mut bearing.contact_stiffness_n_per_m1_5,
                ("bearing", "contact_exponent") => &mut bearing.contact_exponent,
                ("excitation", "unbalance_kg_m") => &mut rig.excitation.unbalance_kg_m,
                ("excitation", "process_force_psd_n2_per_hz") => &mut rig.excitation.process_force_psd_n2_per_hz,
                ("sensor", "noise_std_m_per_s2") => &mut rig.sensor.noise_std_m_per_s2,
                _ => return None,
            });
        }
    };
    Some(match key {
        "mass_kg" => &mut support.mass_kg,
        "stiffness_n_per_m" => &mut support.stiffness_n_per_m,
        "damping_n_s_per_m" => &mut support.damping_n_s_per_m,
        _ => return None,
    })
}
