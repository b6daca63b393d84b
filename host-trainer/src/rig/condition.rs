//! Under what a rig runs, and from where a run starts.

use super::{noise, state::VelocityCovariance};

/// Under what the machine runs, and for how long it is recorded.
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

impl OperatingCondition {
    /// Whether a time, s, is in the recording and at least `edge` samples from its ends.
    pub fn is_within(&self, time_s: f64, edge: usize) -> bool {
        let sample = time_s * self.sample_rate_hz;
        sample >= edge as f64 && sample + edge as f64 <= self.samples as f64
    }
}

/// What is not known about a run: where it starts, and its random parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// φ₀ at t = 0, rad: angle of ball 0.
    pub cage_angle0_rad: f64,
    /// ψ at t = 0, rad.
    pub shaft_angle0_rad: f64,
    /// Time that the rig runs from rest before t = 0, s.
    pub settle_s: f64,
    /// Seed of process force and sensor noise.
    pub seed: u64,
    /// Whether there is process force and sensor noise at all.
    pub noise: bool,
    /// Steps for each sample; `None` chooses them by the stiffest contact and the fastest effect.
    pub substeps: Option<usize>,
    /// What a process force that the run leaves out would add to its state: the run is then the mean over it, as far as the
    /// force laws that know of it go.
    pub velocity_covariance: Option<VelocityCovariance>,
}

impl Start {
    /// Settling time of [`Start::seeded`] and [`Start::silent`], s: the slowest mode of the reference rigs has decayed
    /// by e⁻³⁵.
    pub const SETTLE_S: f64 = 0.4;

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
        }
    }

    /// Random angles and noise for one run of a series: all runs differ, and so do those of another seed.
    pub fn of_series(seed: u64, index: usize) -> Self {
        Self::seeded(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(index as u64))
    }

    /// These angles, and nothing random.
    pub fn noise_free(cage_angle0_rad: f64, shaft_angle0_rad: f64) -> Self {
        Self { cage_angle0_rad, shaft_angle0_rad, noise: false, ..Self::seeded(0) }
    }
}
