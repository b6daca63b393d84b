//! Elastohydrodynamic film between balls and races: the central thickness of B. J. Hamrock and D. Dowson, "Isothermal
//! elastohydrodynamic lubrication of point contacts, Part III: fully flooded results", J. Lubr. Technol. 99 (1977) 264–275.

use std::f64::consts::TAU;

use super::config::Bearing;
use super::settings::FilmSettings;

const SETTINGS: FilmSettings = FilmSettings::DEFAULT;

/// Lubricant at the temperature of the contact's inlet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lubricant {
    /// Dynamic viscosity at ambient pressure η₀, Pa s.
    pub viscosity_pa_s: f64,
    /// Pressure–viscosity coefficient, 1/Pa.
    pub pressure_viscosity_per_pa: f64,
}

impl Lubricant {
    /// Central thickness, m, on the inner and on the outer race, at the ball that bears most of a radial load, theory (110) and
    /// (111). Races of steel, fully flooded, isothermal; the outer race is at rest.
    pub fn thickness_m(&self, bearing: &Bearing, shaft_hz: f64, load_n: f64) -> [f64; 2] {
        let (ball, pitch) = (bearing.ball_diameter_m, bearing.pitch_diameter_m);
        let slope = bearing.contact_angle_rad.cos();
        let gamma = ball * slope / pitch;
        // Entrainment speed, the same on both races.
        let speed = 0.25 * TAU * shaft_hz.abs() * pitch * (1.0 - gamma * gamma);
        let most = SETTINGS.most_loaded * load_n.abs() / (bearing.balls as f64 * slope);
        let load = most.max(SETTINGS.least_load_n);
        let (modulus, conformity) = (SETTINGS.modulus_pa, SETTINGS.conformity);
        let across = conformity * ball / (2.0 * conformity - 1.0);
        [-1.0, 1.0].map(|side| {
            let along = 0.5 * ball * (1.0 + side * gamma);
            let ellipticity = 1.0339 * (across / along).powf(0.636);
            let u = self.viscosity_pa_s * speed / (modulus * along);
            let g = self.pressure_viscosity_per_pa * modulus;
            let w = load / (modulus * along * along);
            let shape = 1.0 - 0.61 * (-0.73 * ellipticity).exp();
            2.69 * along * u.powf(0.67) * g.powf(0.53) * w.powf(-0.067) * shape
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bearing of the example in B. J. Hamrock, "Fundamentals of Fluid Film Lubrication", NASA RP-1255 (1991): 9 balls of
    /// 12.7 mm between races of 52.291 and 77.706 mm, 8900 N, 400 rad/s, 0.04 Pa s, 2.3e-8 1/Pa.
    fn example() -> (Bearing, Lubricant) {
        let bearing = Bearing {
            balls: 9,
            ball_diameter_m: 12.7e-3,
            pitch_diameter_m: 65e-3,
            contact_angle_rad: 0.0,
            radial_clearance_m: 0.0,
            contact_stiffness_n_per_m1_5: 1e10,
            contact_exponent: 1.5,
        };
        (bearing, Lubricant { viscosity_pa_s: 0.04, pressure_viscosity_per_pa: 2.3e-8 })
    }

    /// Worked by hand: u 6.252 m/s, Q 4944 N, R_x 5.109 and 7.591 mm, k 9.43 and 7.33, U 2.227e-10 and 1.499e-10, G 5055, W
    /// 8.618e-4 and 3.905e-4.
    #[test]
    fn literature_the_film_of_a_ball_bearing_is_some_tenths_of_a_micrometre() {
        let (bearing, oil) = example();
        let [inner, outer] = oil.thickness_m(&bearing, 400.0 / TAU, 8900.0);
        assert!((inner / 6.904e-7 - 1.0).abs() < 2e-3 && (outer / 8.277e-7 - 1.0).abs() < 2e-3, "{inner} {outer}");
    }

    #[test]
    fn literature_the_film_grows_with_speed_and_viscosity_and_hardly_falls_with_load() {
        let (bearing, oil) = example();
        let of = |oil: Lubricant, hz: f64, load: f64| oil.thickness_m(&bearing, hz, load)[0];
        let base = of(oil, 30.0, 1000.0);
        assert!((of(oil, 60.0, 1000.0) / base - 2f64.powf(0.67)).abs() < 1e-9);
        let thick = Lubricant { viscosity_pa_s: 2.0 * oil.viscosity_pa_s, ..oil };
        assert!((of(thick, 30.0, 1000.0) / base - 2f64.powf(0.67)).abs() < 1e-9);
        assert!((of(oil, 30.0, 2000.0) / base - 2f64.powf(-0.067)).abs() < 1e-9);
        assert_eq!((of(oil, 0.0, 1000.0), of(oil, 30.0, 0.0).is_finite()), (0.0, true));
    }
}
