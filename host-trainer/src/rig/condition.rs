//! Operating condition of a rig, and start of a run.

use super::{noise, settings::IntegrationSettings, state::VelocityCovariance};

/// Operating condition of a machine, and length of its recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatingCondition {
    /// Shaft speed, revolutions per second.
    pub shaft_hz: f64,
    /// F_load, N.
    pub load_n: f64,
    /// Samples per second.
    pub sample_rate_hz: f64,
    /// Samples.
    pub samples: usize,
}

/// Unknowns of a run: angles at its start, and its random parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// φ₀ at t = 0, rad: angle of ball 0.
    pub cage_angle0_rad: f64,
    /// Shaft angle ψ at t = 0, rad.
    pub shaft_angle0_rad: f64,
    /// Time that the rig runs from rest before t = 0, s.
    pub settle_s: f64,
    /// Seed of process force and sensor noise.
    pub seed: u64,
    /// Whether there is process force and sensor noise at all.
    pub noise: bool,
    /// Steps for each sample; `None` chooses them by the stiffest contact and the fastest effect.
    pub substeps: Option<usize>,
    /// Velocity covariance of the process force that a noise-free run leaves out: force laws that depend on it take their
    /// mean over it, theory (46) and (47).
    pub velocity_covariance: Option<VelocityCovariance>,
    /// Standard deviation of a ball's angle in the cage from an even spacing, rad; the angles follow from the seed. Waviness and
    /// local defects meet the balls at even angles.
    pub ball_std_rad: f64,
    /// Standard deviation of a ball's diameter, m; the diameters follow from the seed.
    pub ball_std_m: f64,
}

impl Start {
    /// Settling time of [`Start::seeded`] and [`Start::noise_free`], s.
    pub const SETTLE_S: f64 = IntegrationSettings::DEFAULT.settle_s;

    /// Random angles and noise, all by one seed.
    pub fn seeded(seed: u64) -> Self {
        let [cage_angle0_rad, shaft_angle0_rad] = noise::angles(seed);
        Self {
            cage_angle0_rad,
            shaft_angle0_rad,
            seed,
            noise: true,
            settle_s: Self::SETTLE_S,
            substeps: None,
            velocity_covariance: None,
            ball_std_rad: 0.0,
            ball_std_m: 0.0,
        }
    }

    /// Random angles and noise for one run of a series: all runs differ, and so do those of another seed.
    pub fn of_series(seed: u64, index: usize) -> Self {
        Self::seeded(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(index as u64))
    }

    /// Given angles of cage and shaft, rad, without noise.
    pub fn noise_free(cage_angle0_rad: f64, shaft_angle0_rad: f64) -> Self {
        Self { cage_angle0_rad, shaft_angle0_rad, noise: false, ..Self::seeded(0) }
    }
}
