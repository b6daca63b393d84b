//! What a ball loses of its deflection over a local pit.
//!
//! A half sine over the pit's width, d(θ) = depth · cos(πθ/width) for |θ| < width/2: J. Liu, Y. Shao, T. C. Lim,
//! "Vibration analysis of ball bearings with a localized defect applying piecewise response function", Mechanism and
//! Machine Theory 56 (2012) 156–169, for pits no longer than the ball sinks into. The patch of contact, some 0.1 mm
//! long, rounds the edges of so shallow a pit: the rectangle of N. Sawalhi, R. B. Randall ("Simulating gear and bearing
//! interactions in the presence of faults, Part I", MSSP 22 (2008) 1924–1951) and the arcs of a ball that rolls over
//! sharp edges (the same, MSSP 25 (2011) 846–870) give several times the acceleration at high frequency.

use std::f64::consts::{PI, TAU};

/// A pit, by its depth in m and half its width in rad.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pit {
    depth: f64,
    half_width: f64,
}

impl Pit {
    pub(super) fn new(depth: f64, width: f64) -> Self {
        Self { depth, half_width: 0.5 * width }
    }

    /// Loss of deflection at an angle from its middle, m.
    pub(super) fn loss(&self, angle: f64) -> f64 {
        if angle.abs() < self.half_width { self.depth * (0.5 * PI * angle / self.half_width).cos() } else { 0.0 }
    }

    /// Adds the loss of every ball that is over a pit at angle `at`, ball 0 being at `cage`.
    pub(super) fn add(&self, at: f64, cage: f64, losses: &mut [f64]) {
        let balls = losses.len();
        let pitch = TAU / balls as f64;
        let place = (at - cage) / pitch;
        let nearest = place.round();
        // Balls to each side that a pit wider than their pitch reaches.
        let reach = (self.half_width / pitch + 0.5).floor().min(0.5 * (balls - 1) as f64) as i64;
        for offset in -reach..=reach {
            let ball = nearest + offset as f64;
            losses[ball.rem_euclid(balls as f64) as usize % balls] += self.loss((place - ball) * pitch);
        }
    }
}
