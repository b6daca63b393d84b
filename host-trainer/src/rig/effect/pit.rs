//! What a ball loses of its deflection over a local pit.
//!
//! The ball rolls over the leading edge, drops along the arc that the edge lets it, stands at full depth where the pit
//! is wider than that takes, and climbs over the trailing edge: N. Sawalhi, R. B. Randall, "Simulating gear and bearing
//! interactions in the presence of faults, Part I", Mechanical Systems and Signal Processing 22 (2008) 1924–1951,
//! section 3.1; the arcs at entry and exit after the same authors, "Vibration response of spalled rolling element
//! bearings", MSSP 25 (2011) 846–870. A rectangle would be the limit of a ball of no size. With the edge a distance x
//! behind, the ball's centre has dropped by κ x²/2, κ being the curvature of ball against race.

use std::f64::consts::TAU;

use crate::rig::config::BearingRig;

/// A pit, by the half-width and the depth, with the curvature that rounds its edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pit {
    /// m.
    pub depth: f64,
    /// rad.
    pub half_width: f64,
    /// Drop for each rad² from the edge, m.
    pub drop: f64,
}

/// Which race a pit is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Race {
    Outer,
    Inner,
}

impl Pit {
    /// A pit in a race, its angle seen from the bearing's centre.
    pub(super) fn in_race(rig: &BearingRig, race: Race, depth: f64, width: f64) -> Self {
        let ball = 0.5 * rig.bearing.ball_diameter_m;
        let (radius, curvature) = match race {
            Race::Outer => {
                let radius = rig.bearing.geometry().outer_radius_m();
                (radius, 1.0 / ball - 1.0 / radius)
            }
            Race::Inner => {
                let radius = rig.bearing.geometry().inner_radius_m();
                (radius, 1.0 / ball + 1.0 / radius)
            }
        };
        Self { depth, half_width: 0.5 * width, drop: 0.5 * curvature * radius * radius }
    }

    /// A pit in a ball, its angle seen from the ball's centre; the race bridges it like a flat.
    pub(super) fn in_ball(rig: &BearingRig, depth: f64, width: f64) -> Self {
        Self { depth, half_width: 0.5 * width, drop: 0.25 * rig.bearing.ball_diameter_m }
    }

    /// Loss of deflection at an angle from its middle, m.
    pub(super) fn loss(&self, angle: f64) -> f64 {
        let inside = self.half_width - angle.abs();
        if inside <= 0.0 { 0.0 } else { self.depth.min(self.drop * inside * inside) }
    }

    /// Adds the loss of every ball that is over a pit at angle `at`, ball 0 being at `cage`.
    pub(super) fn add(&self, at: f64, cage: f64, losses: &mut [f64]) {
        let balls = losses.len();
        let pitch = TAU / balls as f64;
        let place = (at - cage) / pitch;
        let nearest = place.round();
        // Balls to each side that a pit wider than their pitch reaches.
        let reach = (self.half_width / pitch + 0.5).floor().min(0.5 * balls as f64) as i64;
        for offset in -reach..=reach {
            let ball = nearest + offset as f64;
            let loss = self.loss((place - ball) * pitch);
            losses[ball.rem_euclid(balls as f64) as usize % balls] += loss;
        }
    }
}
