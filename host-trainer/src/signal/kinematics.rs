//! Characteristic frequencies of a rolling bearing from its geometry (pure rolling, outer race at rest), theory (26).
//!
//! Formulas: R. B. Randall, J. Antoni, "Rolling element bearing diagnostics — A tutorial", Mechanical
//! Systems and Signal Processing 25 (2011) 485–520, equations (1) to (4).

/// Geometry of a rolling bearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// Rolling elements, n_b.
    pub balls: usize,
    /// Diameter of a rolling element D_b, m.
    pub ball_diameter_m: f64,
    /// Diameter of the circle through their centres D_p, m.
    pub pitch_diameter_m: f64,
    /// Contact angle α from the radial plane, rad.
    pub contact_angle_rad: f64,
}

/// Characteristic frequencies in orders of the shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orders {
    /// Cage (fundamental train frequency).
    pub ftf: f64,
    /// Ball passes of the outer race.
    pub bpfo: f64,
    /// Ball passes of the inner race.
    pub bpfi: f64,
    /// Turns of a ball about its own axis; a defect on it strikes a race twice a turn, see [`Orders::ball_strikes`].
    pub bsf: f64,
}

impl Geometry {
    /// Ratio γ = D_b cos α / D_p.
    pub fn ratio(&self) -> f64 {
        self.ball_diameter_m * self.contact_angle_rad.cos() / self.pitch_diameter_m
    }

    /// Characteristic orders, theory (26).
    pub fn orders(&self) -> Orders {
        let ratio = self.ratio();
        let balls = self.balls as f64;
        Orders {
            ftf: 0.5 * (1.0 - ratio),
            bpfo: 0.5 * balls * (1.0 - ratio),
            bpfi: 0.5 * balls * (1.0 + ratio),
            bsf: 0.5 * self.pitch_diameter_m / self.ball_diameter_m * (1.0 - ratio * ratio),
        }
    }
}

impl Orders {
    /// Number of balls: the outer race is passed by each once a turn of the cage.
    pub fn balls(&self) -> usize {
        (self.bpfo / self.ftf).round().max(1.0) as usize
    }

    /// Strikes of a defect on a ball, inner and outer race in turn: 2 × BSF.
    pub fn ball_strikes(&self) -> f64 {
        2.0 * self.bsf
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inches(balls: usize, ball: f64, pitch: f64, contact_angle_rad: f64) -> Orders {
        let (ball_diameter_m, pitch_diameter_m) = (ball * 0.0254, pitch * 0.0254);
        Geometry { balls, ball_diameter_m, pitch_diameter_m, contact_angle_rad }.orders()
    }

    /// Case Western Reserve University Bearing Data Center, "Bearing information": defect frequencies as multiples
    /// of the running speed. Their rolling-element frequency is that of the strikes, 2 × BSF.
    #[test]
    fn literature_cwru_bearings() {
        let drive_end = inches(9, 0.3126, 1.537, 0.0);
        let fan_end = inches(8, 0.2656, 1.122, 0.0);
        for (got, published) in [
            (drive_end.bpfi, 5.4152),
            (drive_end.bpfo, 3.5848),
            (drive_end.ftf, 0.39828),
            (drive_end.ball_strikes(), 4.7135),
            (fan_end.bpfi, 4.9469),
            (fan_end.bpfo, 3.0530),
            (fan_end.ftf, 0.3817),
            (fan_end.ball_strikes(), 3.9874),
        ] {
            assert!((got - published).abs() < 4e-4, "{got} beside {published}");
        }
    }

    /// MFPT "Condition Based Maintenance Fault Database" (Bechhoefer): NICE bearing, 8 rollers of 0.235 in on
    /// 1.245 in. BPFO 81.125 Hz and BPFI 118.875 Hz at 25 Hz are quoted wherever the set is used.
    #[test]
    fn literature_mfpt_bearing() {
        let orders = inches(8, 0.235, 1.245, 0.0);
        assert!((orders.bpfo * 25.0 - 81.125).abs() < 5e-3, "{orders:?}");
        assert!((orders.bpfi * 25.0 - 118.875).abs() < 5e-3, "{orders:?}");
    }

    #[test]
    fn invariant_ball_passes_add_up() {
        for contact_angle_rad in [0.0, 0.26, 0.7] {
            let orders = inches(11, 0.3, 1.6, contact_angle_rad);
            // Each ball passes each race once for each turn of shaft against cage, or of cage.
            assert!((orders.bpfo + orders.bpfi - 11.0).abs() < 1e-12);
            assert!((orders.bpfo - 11.0 * orders.ftf).abs() < 1e-12);
        }
        // A steeper contact turns the cage faster.
        assert!(inches(11, 0.3, 1.6, 0.7).ftf > inches(11, 0.3, 1.6, 0.0).ftf);
    }
}
