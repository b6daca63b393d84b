//! Parameters as an engineer says them: keys that end in an SI unit as words, with a prefix on the unit.

use super::format::{significant, with_interval};

/// Endings of keys, with the unit in which a report states them, its factor, and whether it takes a prefix.
const UNITS: [(&str, &str, f64, bool); 22] = [
    ("_n_per_unit", "N per unit of u", 1.0, false),
    ("_n_s2_per_m2", "N s²/m²", 1.0, true),
    ("_n_per_m3", "N/m³", 1.0, true),
    ("_n_per_m1_5", "N/m^1.5", 1.0, true),
    ("_n2_per_hz", "N²/Hz", 1.0, false),
    ("_n_per_m2", "N/m²", 1.0, true),
    ("_n_s_per_m", "N s/m", 1.0, true),
    ("_m_per_s2", "m/s²", 1.0, true),
    ("_m_per_s", "m/s", 1.0, true),
    ("_n_per_m", "N/m", 1.0, true),
    ("_per_pa", "1/Pa", 1.0, false),
    ("_pa_s", "Pa s", 1.0, true),
    ("_kg_m2", "kg m²", 1.0, false),
    ("_kg_m", "g mm", 1e6, false),
    ("_n_s", "N s", 1.0, true),
    ("_per_s", "1/s", 1.0, false),
    ("_rad", "°", 180.0 / std::f64::consts::PI, false),
    ("_hz", "Hz", 1.0, false),
    ("_kg", "kg", 1.0, false),
    ("_m", "m", 1.0, true),
    ("_n", "N", 1.0, true),
    ("_s", "s", 1.0, true),
];

/// Keys of whole numbers.
const COUNTS: [&str; 2] = ["count", "lobes"];

/// Prefixes of units from 1e−9 on, in steps of a thousand.
const PREFIXES: [&str; 8] = ["n", "µ", "m", "", "k", "M", "G", "T"];

/// Name and unit in which a report states a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedUnit {
    /// Name in words, without the unit.
    pub name: String,
    /// Unit with its prefix; empty for a number without one.
    pub unit: String,
    /// Factor from SI to that unit.
    pub factor: f64,
}

impl NamedUnit {
    /// NamedUnit of a key such as `depth_m`, its prefix that of a value in SI: between 1 and 1000 with it, if it takes one.
    pub fn new(key: &str, value: f64) -> Self {
        let words = |name: &str| name.replace(['_', '.'], " ");
        let ending = UNITS.iter().find_map(|unit| Some((key.strip_suffix(unit.0)?, unit)));
        let Some((name, (_, unit, factor, takes_prefix))) = ending else {
            return Self { name: words(key), unit: String::new(), factor: 1.0 };
        };
        let thousands = (value.abs().log10() / 3.0 + 1e-12).floor();
        let thousands = if *takes_prefix && thousands.is_finite() { thousands.clamp(-3.0, 4.0) as i32 } else { 0 };
        Self {
            name: words(name),
            unit: format!("{}{unit}", PREFIXES[(thousands + 3) as usize]),
            factor: factor * 1000f64.powi(-thousands),
        }
    }

    /// Cells of a table: the name with its unit, the value before, the value, and its 95 % interval.
    pub fn row(&self, before: f64, value: f64, interval95: [f64; 2]) -> [String; 4] {
        let (text, interval) = self.texts(value, Some(interval95));
        let name = if self.unit.is_empty() { self.name.clone() } else { format!("{}, {}", self.name, self.unit) };
        [name, significant(self.factor * before, 4), text, interval]
    }

    /// A value and its 95 % interval, in SI, as texts in this unit, to the digits of the interval; of a whole number without decimals.
    pub fn texts(&self, value: f64, interval95: Option<[f64; 2]>) -> (String, String) {
        if interval95.is_none() && COUNTS.contains(&self.name.as_str()) {
            return (format!("{value:.0}"), "–".into());
        }
        with_interval(self.factor * value, interval95.map(|ends| ends.map(|end| self.factor * end)))
    }
}

/// Parameter in a sentence, such as `depth 2.6 µm` or `angle 30.0°`.
pub fn in_words(key: &str, value: f64, interval95: Option<[f64; 2]>) -> String {
    let named = NamedUnit::new(key, value);
    let (number, _) = named.texts(value, interval95);
    format!("{} {number} {}", named.name, named.unit).trim_end().replace(" °", "°")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_have_their_unit_with_a_prefix() {
        let said = |key, value| in_words(key, value, None);
        assert_eq!(said("depth_m", 2.6e-6), "depth 2.600 µm");
        assert_eq!(in_words("depth_m", 2.6e-6, Some([2.5e-6, 2.7e-6])), "depth 2.60 µm");
        assert_eq!(said("stiffness_n_per_m", 1.25e8), "stiffness 125.0 MN/m");
        assert_eq!(said("stiffness_n_per_m", 1000.0), "stiffness 1.000 kN/m");
        assert_eq!(said("phase_y_rad", std::f64::consts::FRAC_PI_2), "phase y 90.00°");
        assert_eq!(said("frequency_hz", 1500.0), "frequency 1500 Hz");
        assert_eq!(said("unbalance_kg_m", 2e-5), "unbalance 20.00 g mm");
        assert_eq!(said("viscosity_pa_s", 0.05), "viscosity 50.00 mPa s");
        assert_eq!(said("duration_s", 0.0), "duration 0 s");
        assert_eq!(said("force_n", -2500.0), "force −2.500 kN");
        assert_eq!(said("outer.stiffness_n_per_m", 1e7), "outer stiffness 10.00 MN/m");
        assert_eq!(said("damping_ratio", 0.03), "damping ratio 0.03000");
        assert_eq!(said("lobes", 8.0), "lobes 8");
        let row = NamedUnit::new("outer.stiffness_n_per_m", 1.25e7).row(1e7, 1.25e7, [1.2e7, 1.3e7]);
        assert_eq!(row, ["outer stiffness, MN/m", "10.00", "12.5", "12.0 to 13.0"]);
    }
}
