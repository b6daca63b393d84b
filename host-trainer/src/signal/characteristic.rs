//! Characteristic frequencies of shaft and bearing with their names, theory (27).

use serde::Serialize;

use crate::signal::kinematics::Geometry;

/// Kinematic family of a characteristic frequency.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// Turns of the shaft.
    Shaft,
    /// Turns of the cage: FTF.
    Cage,
    /// Ball passes of the outer race: BPFO.
    Outer,
    /// Ball passes of the inner race: BPFI, modulated once a turn of the shaft.
    Inner,
    /// Strikes of a defect on a ball: 2 × BSF, modulated once a turn of the cage.
    Ball,
}

impl Family {
    /// All families.
    pub const ALL: [Self; 5] = [Self::Shaft, Self::Cage, Self::Outer, Self::Inner, Self::Ball];

    /// Usual abbreviation of the first harmonic.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shaft => "shaft",
            Self::Cage => "FTF",
            Self::Outer => "BPFO",
            Self::Inner => "BPFI",
            Self::Ball => "2×BSF",
        }
    }
}

/// Speeds and geometry that fix all characteristic frequencies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speeds {
    /// Turns of the shaft a second.
    pub shaft_hz: f64,
    /// Bearing geometry, if known.
    pub geometry: Option<Geometry>,
    /// Slip of the cage below pure rolling, a fraction.
    pub slip: f64,
}

/// Coefficients A and B of a characteristic frequency, theory (27): `(shaft + cage·(1 − slip))·shaft_hz`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Law {
    /// Multiple of the shaft's speed.
    pub shaft: f64,
    /// Multiple of the cage's speed, in orders of the shaft at pure rolling.
    pub cage: f64,
}

impl Law {
    /// The frequency, Hz.
    pub fn frequency_hz(&self, shaft_hz: f64, slip: f64) -> f64 {
        (self.shaft + self.cage * (1.0 - slip)) * shaft_hz
    }

    fn and(self, times: f64, other: Self, times_other: f64) -> Self {
        let sum = |a: f64, b: f64| times * a + times_other * b;
        Self { shaft: sum(self.shaft, other.shaft), cage: sum(self.cage, other.cage) }
    }
}

impl Family {
    /// Law of the first harmonic; `None` if it needs a missing geometry.
    ///
    /// Slip slows ball passes of the outer race and quickens those of the inner; a ball rolls on the outer race.
    pub fn law(self, geometry: Option<&Geometry>) -> Option<Law> {
        if self == Self::Shaft {
            return Some(Law { shaft: 1.0, cage: 0.0 });
        }
        let geometry = geometry?;
        let (orders, balls) = (geometry.orders(), geometry.balls as f64);
        let (shaft, cage) = match self {
            Self::Shaft => (1.0, 0.0),
            Self::Cage => (0.0, orders.ftf),
            Self::Outer => (0.0, orders.bpfo),
            Self::Inner => (balls, -balls * orders.ftf),
            Self::Ball => (0.0, orders.ball_strikes()),
        };
        Some(Law { shaft, cage })
    }

    /// Family that modulates the impacts and spaces the sidebands.
    pub fn modulation(self) -> Self {
        if self == Self::Ball { Self::Cage } else { Self::Shaft }
    }
}

impl Speeds {
    /// First harmonic of a family, Hz; `None` if it needs a missing geometry.
    pub fn base_hz(&self, family: Family) -> Option<f64> {
        Some(family.law(self.geometry.as_ref())?.frequency_hz(self.shaft_hz, self.slip))
    }
}

/// A characteristic frequency.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Characteristic {
    /// Name, such as `BPFO`, `3×BPFI`, `BPFI − shaft`.
    pub name: String,
    /// Kinematic family.
    pub family: Family,
    /// Multiple of the family's first harmonic, from 1.
    pub harmonic: u32,
    /// Multiple of the modulation that is added.
    pub sideband: i32,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Dependence of the frequency on the speeds.
    #[serde(skip)]
    pub law: Law,
}

/// Harmonics of every family up to a frequency, in its order, with `sidebands` to either side of those of inner race
/// and ball; other families are not modulated.
pub fn list(speeds: &Speeds, up_to_hz: f64, harmonics: u32, sidebands: i32) -> Vec<Characteristic> {
    let mut out = Vec::new();
    for family in Family::ALL {
        let law = |family: Family| family.law(speeds.geometry.as_ref());
        let (Some(base), Some(apart)) = (law(family), law(family.modulation())) else { continue };
        let sidebands = if matches!(family, Family::Inner | Family::Ball) { sidebands } else { 0 };
        for (harmonic, sideband) in (1..=harmonics).flat_map(|h| (-sidebands..=sidebands).map(move |s| (h, s))) {
            let law = base.and(f64::from(harmonic), apart, f64::from(sideband));
            let frequency_hz = law.frequency_hz(speeds.shaft_hz, speeds.slip);
            if frequency_hz > 0.0 && frequency_hz <= up_to_hz {
                let name = name(family, harmonic, sideband);
                out.push(Characteristic { name, family, harmonic, sideband, frequency_hz, law });
            }
        }
    }
    out.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    out
}

fn name(family: Family, harmonic: u32, sideband: i32) -> String {
    let base = match (family, harmonic) {
        (Family::Ball, h) => format!("{}×BSF", 2 * h),
        (family, 1) => family.name().to_owned(),
        (family, h) => format!("{h}×{}", family.name()),
    };
    let modulation = if family == Family::Ball { "FTF" } else { "shaft" };
    let sign = if sideband < 0 { '−' } else { '+' };
    match sideband.unsigned_abs() {
        0 => base,
        1 => format!("{base} {sign} {modulation}"),
        n => format!("{base} {sign} {n}×{modulation}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mfpt(slip: f64) -> Speeds {
        let geometry =
            Geometry { balls: 8, ball_diameter_m: 0.005969, pitch_diameter_m: 0.031623, contact_angle_rad: 0.0 };
        Speeds { shaft_hz: 25.0, geometry: Some(geometry), slip }
    }

    #[test]
    fn literature_mfpts_published_frequencies_are_in_the_list() {
        let list = list(&mfpt(0.0), 1000.0, 3, 1);
        let at = |name: &str| list.iter().find(|c| c.name == name).unwrap_or_else(|| panic!("{name}")).frequency_hz;
        assert!((at("BPFO") - 81.125).abs() < 5e-3 && (at("2×BPFI") - 237.75).abs() < 1e-2);
        assert!((at("BPFI − shaft") - 93.875).abs() < 5e-3 && (at("FTF") - 81.125 / 8.0).abs() < 1e-3);
        assert!((at("4×BSF + FTF") - (2.0 * at("2×BSF") + at("FTF"))).abs() < 1e-9);
        assert!(list.windows(2).all(|w| w[0].frequency_hz <= w[1].frequency_hz));
    }

    #[test]
    fn invariant_slip_slows_passes_of_one_race_and_quickens_those_of_the_other() {
        let (pure, slipping) = (mfpt(0.0), mfpt(0.02));
        let change = |family| slipping.base_hz(family).unwrap() - pure.base_hz(family).unwrap();
        assert!(change(Family::Outer) < 0.0 && (change(Family::Outer) + change(Family::Inner)).abs() < 1e-9);
        assert_eq!(change(Family::Shaft), 0.0);
        let unknown = Speeds { geometry: None, ..pure };
        assert!(super::list(&unknown, 500.0, 4, 2).iter().all(|c| c.family == Family::Shaft));
    }
}
