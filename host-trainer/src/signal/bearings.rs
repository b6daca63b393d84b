//! Catalogue of bearings by designation: what their characteristic frequencies depend on.
//!
//! Only bearings whose geometry a public source states. ISO 15 standardises bore, outside diameter and width, not what
//! is inside: makers differ by up to 1 % in the ratio of ball to pitch diameter, and a data sheet goes before this table.

use crate::signal::kinematics::Geometry;

/// A bearing of the catalogue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CatalogueBearing {
    /// Basic designation, without maker, seals and clearance.
    pub designation: &'static str,
    /// Bore and outside diameter, mm (ISO 15); `None` where no standard fixes them.
    pub bore_and_outside_mm: Option<[f64; 2]>,
    /// Rolling elements of a row.
    pub balls: usize,
    /// Diameter of a rolling element, mm.
    pub ball_mm: f64,
    /// Pitch diameter, mm.
    pub pitch_mm: f64,
    /// Contact angle, degrees.
    pub contact_angle_deg: f64,
    /// Source of the geometry.
    pub source: &'static str,
}

const INCH_MM: f64 = 25.4;

const fn bearing(
    designation: &'static str,
    bore_and_outside_mm: Option<[f64; 2]>,
    (balls, ball_mm, pitch_mm, contact_angle_deg): (usize, f64, f64, f64),
    source: &'static str,
) -> CatalogueBearing {
    CatalogueBearing { designation, bore_and_outside_mm, balls, ball_mm, pitch_mm, contact_angle_deg, source }
}

const CWRU: &str = "Case Western Reserve University Bearing Data Center, \"Bearing information\"";
const LEE: &str = "Lee and others, vibration dataset with various bearing types under compound machine faults, Data in Brief (2024), table 2";
const THUAN: &str = "balls: Thuan, Hong, BMC Research Notes 16 (2023) 138; pitch: mean of bore and outside diameter";

/// The catalogue, by designation.
pub const CATALOGUE: &[CatalogueBearing] = &[
    bearing("6203", Some([17.0, 40.0]), (8, 0.2656 * INCH_MM, 1.122 * INCH_MM, 0.0), CWRU),
    bearing("6204", Some([20.0, 47.0]), (8, 7.94, 34.57, 0.0), LEE),
    bearing("6205", Some([25.0, 52.0]), (9, 0.3126 * INCH_MM, 1.537 * INCH_MM, 0.0), CWRU),
    bearing("6207", Some([35.0, 72.0]), (9, 11.0, 53.5, 0.0), THUAN),
    bearing("6208", Some([40.0, 80.0]), (9, 12.0, 60.0, 0.0), THUAN),
    bearing(
        "6209",
        Some([45.0, 85.0]),
        (9, 12.7, 65.0, 0.0),
        "Harris, Kotzalas, Rolling Bearing Analysis, 5th edition, the 209 bearing of the examples of chapter 2",
    ),
    bearing(
        "6804",
        Some([20.0, 32.0]),
        (13, 3.5, 25.6, 0.0),
        "NSK 6804DD, PHM 2012 challenge (PRONOSTIA), appendix A.1",
    ),
    bearing(
        "203KD",
        Some([17.0, 40.0]),
        (8, 6.77, 28.5, 0.0),
        "Fafnir, Sehri and others, Data in Brief 49 (2023), table 2",
    ),
    bearing("30204", Some([20.0, 47.0]), (15, 6.2, 35.8, 12.6), LEE),
    bearing("ER10K", None, (8, 0.3125 * INCH_MM, 1.319 * INCH_MM, 0.0), "MB, PHM 2009 challenge, apparatus page"),
    bearing("ER16K", None, (9, 7.94, 38.52, 0.0), "MB, Huang, Baddour, Data in Brief 21 (2018) 1745"),
    bearing("N204", Some([20.0, 47.0]), (11, 7.5, 34.0, 0.0), LEE),
    bearing("NJ204", Some([20.0, 47.0]), (11, 7.5, 34.0, 0.0), LEE),
    bearing(
        "NU2205",
        Some([25.0, 52.0]),
        (13, 7.5, 39.0, 0.0),
        "FAG NU2205-E-XL-TVP2, report of the Lenze-MB recordings",
    ),
    bearing("UER204", Some([20.0, 47.0]), (8, 7.92, 34.55, 0.0), "LDK, parameter table of the XJTU-SY recordings"),
    bearing(
        "ZA2115",
        None,
        (16, 0.331 * INCH_MM, 2.815 * INCH_MM, 15.17),
        "Rexnord, Qiu and others, Journal of Sound and Vibration 289 (2006) 1066",
    ),
];

impl CatalogueBearing {
    /// The bearing of a designation such as `6205`, `SKF 6205-2RS1/C3` or `6205ZZ`; `None` if it is not in the catalogue.
    pub fn find(text: &str) -> Option<&'static Self> {
        let text = text.to_uppercase();
        let joined: String = text.chars().filter(char::is_ascii_alphanumeric).collect();
        // `62052` is no 6205; seals and clearances begin with a letter, or are set off.
        let is = |word: &str, bearing: &Self| {
            word.strip_prefix(bearing.designation).is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_digit()))
        };
        let words = || text.split(|c: char| !c.is_ascii_alphanumeric()).chain([joined.as_str()]);
        CATALOGUE.iter().find(|bearing| words().any(|word| is(word, bearing)))
    }

    /// Geometry in m and rad.
    pub fn geometry(&self) -> Geometry {
        Geometry {
            balls: self.balls,
            ball_diameter_m: 1e-3 * self.ball_mm,
            pitch_diameter_m: 1e-3 * self.pitch_mm,
            contact_angle_rad: self.contact_angle_deg.to_radians(),
        }
    }
}
