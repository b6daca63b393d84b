//! Units of stored samples, and which columns they apply to.

use std::fmt;

/// One g in m/s² (the standard value, CGPM 1901).
pub const STANDARD_GRAVITY: f64 = 9.80665;

/// Unit in which a file stores accelerations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unit {
    /// Metres per second squared, the unit of all recordings in memory.
    #[default]
    MetrePerSecondSquared,
    /// Multiples of [`STANDARD_GRAVITY`].
    StandardGravity,
}

impl Unit {
    /// Unit from its text, `g` or `m/s^2`; `None` for any other.
    pub fn parse(text: &str) -> Option<Self> {
        match text {
            "m/s^2" => Some(Self::MetrePerSecondSquared),
            "g" => Some(Self::StandardGravity),
            _ => None,
        }
    }

    /// Factor to m/s².
    pub fn factor(self) -> f64 {
        match self {
            Self::MetrePerSecondSquared => 1.0,
            Self::StandardGravity => STANDARD_GRAVITY,
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::MetrePerSecondSquared => "m/s^2",
            Self::StandardGravity => "g",
        })
    }
}

/// Physical quantity of a column, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    /// An acceleration in the unit that the file or its manifest states.
    Acceleration,
    /// An acceleration whose name states the unit (`ay_m_s2`, `ax_g`).
    AccelerationIn(Unit),
    /// Anything else: never converted.
    Other,
}

impl Quantity {
    /// Quantity of the columns of this name; by default an acceleration.
    pub(super) fn from_name(name: &str) -> Self {
        const PLAIN: [&str; 5] = ["tacho", "u", "q", "qd", "qdd"];
        const OTHER_UNIT: [&str; 7] = ["_rad", "_n", "_m", "_m_s", "_s", "_hz", "_rpm"];
        if PLAIN.contains(&name) {
            Self::Other
        } else if name.ends_with("_m_s2") {
            Self::AccelerationIn(Unit::MetrePerSecondSquared)
        } else if name.ends_with("_g") {
            Self::AccelerationIn(Unit::StandardGravity)
        } else if OTHER_UNIT.iter().any(|unit| name.ends_with(unit)) {
            Self::Other
        } else {
            Self::Acceleration
        }
    }
}

/// Whether a channel of this name is an acceleration in m/s².
pub fn is_acceleration(name: &str) -> bool {
    Quantity::from_name(name) != Quantity::Other
}

/// Default location of a column: those of the 5-DoF rig's two sensors.
pub(super) fn default_location(name: &str) -> Option<&'static str> {
    match name.strip_suffix("_m_s2").or_else(|| name.strip_suffix("_g")).unwrap_or(name) {
        "ax" => Some("outer-x"),
        "ay" => Some("resonator-y"),
        _ => None,
    }
}
