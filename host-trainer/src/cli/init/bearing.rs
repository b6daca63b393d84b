//! Bearing of a new rig: of the catalogue, or by its numbers.

use crate::cli::Failure;
use crate::signal::bearings::{CATALOGUE, CatalogueBearing};
use crate::signal::kinematics::Geometry;

/// Bearing that the user named.
pub struct Chosen {
    /// Its geometry.
    pub geometry: Geometry,
    /// Where its numbers come from, a comment.
    source: String,
}

impl Chosen {
    /// Bearing of a designation, or of balls, ball and pitch diameter in mm, and contact angle in degrees.
    pub fn parse(text: &str) -> Result<Self, Failure> {
        if let Some(found) = CatalogueBearing::find(text) {
            let source = format!(
                "# {}, by {}.\n# Makers differ by up to 1 %: a data sheet goes before these numbers.",
                found.designation, found.source
            );
            return Ok(Self { geometry: found.geometry(), source });
        }
        let geometry = numbers(text).ok_or_else(|| {
            let known: Vec<&str> = CATALOGUE.iter().map(|bearing| bearing.designation).collect();
            Failure::Input(format!(
                "--bearing: found `{text}`, expected one of {}, or the data sheet's BALLS,BALL_MM,PITCH_MM[,CONTACT_DEGREES] \
                 such as 9,7.94,39.04",
                known.join(", ")
            ))
        })?;
        Ok(Self { geometry, source: "# By the numbers of --bearing.".into() })
    }

    /// Text of the rig.
    pub fn rig(&self) -> String {
        let orders = self.geometry.orders();
        let source = format!(
            "{}\n# Orders of the shaft: BPFO {:.4}, BPFI {:.4}, twice BSF {:.4}, FTF {:.4}.",
            self.source,
            orders.bpfo,
            orders.bpfi,
            orders.ball_strikes(),
            orders.ftf
        );
        // Diameters to 0.1 µm: what is beyond comes from the conversion of inches.
        let metres = |m: f64| format!("{:?}", (m * 1e7).round() / 1e7);
        include_str!("bearing-5dof.toml")
            .replace("{source}", &source)
            .replace("{balls}", &self.geometry.balls.to_string())
            .replace("{ball}", &metres(self.geometry.ball_diameter_m))
            .replace("{pitch}", &metres(self.geometry.pitch_diameter_m))
            .replace("{angle}", &format!("{:?}", self.geometry.contact_angle_rad))
    }
}

/// Geometry from its numbers; `None` unless the balls fit on the pitch circle.
fn numbers(text: &str) -> Option<Geometry> {
    let fields: Vec<f64> = text.split(',').map(|field| field.trim().parse().ok()).collect::<Option<_>>()?;
    let &[balls, ball_mm, pitch_mm, ref angle @ ..] = fields.as_slice() else { return None };
    let degrees = match angle {
        [] => 0.0,
        [degrees] => *degrees,
        _ => return None,
    };
    let whole = balls.fract() == 0.0 && (1.0..=200.0).contains(&balls);
    let fits = ball_mm > 0.0 && pitch_mm.is_finite() && balls * ball_mm < std::f64::consts::PI * pitch_mm;
    (whole && fits && (0.0..=90.0).contains(&degrees)).then(|| Geometry {
        balls: balls as usize,
        ball_diameter_m: 1e-3 * ball_mm,
        pitch_diameter_m: 1e-3 * pitch_mm,
        contact_angle_rad: degrees.to_radians(),
    })
}
