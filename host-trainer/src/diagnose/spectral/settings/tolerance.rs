//! Settings of what every machine has within the tolerances of its make, load and drive.

use serde::Serialize;

use crate::diagnose::acquisition::WANDER;

/// Settings of what every machine has within the tolerances of its make, load and drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ToleranceSettings {
    /// Gain below the best, in nats, within which an error of the load is preferred.
    pub load_nats: f64,
    /// The same as a share of the best gain.
    pub load_share_of_gain: f64,
    /// Greatest constant force over the load that is an error of the stated load, or of its direction.
    pub load_share: f64,
    /// Greatest relative error of a mass or stiffness, and of a damping, that is stated. By hand: what a scale, a drawing and a test of
    /// its modes are right by.
    pub stated: [f64; 2],
    /// Lobes up to which a race's waviness is its roundness. By hand: rings are out of round by how they were held.
    pub round_lobes: f64,
    /// Greatest amplitude of it that is within the tolerance of its make, m: by hand, half the 1 µm from peak to peak of rings of
    /// ordinary precision.
    pub round_m: f64,
    /// Greatest amplitude of waviness with more lobes that is the finish of a race, m. False ones of choosing seed 60 had 16 and 19 nm, the
    /// least true one of choosing seeds 35 nm.
    pub wave_m: f64,
    /// Greatest depth of a local defect that is the finish of a race or ball, m: by hand, the roughness of a honed race. A healthy
    /// machine of another hand had 12 nm; defects of choosing seeds 83 and 84 were found as of 15 nm, which is finish
    /// still, 30 and 46 nm.
    pub finish_m: f64,
    /// Greatest standard deviation of a drifting speed over its mean that is the wander of a drive.
    pub wander: f64,
}

impl ToleranceSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        load_nats: 20.0,
        load_share_of_gain: 0.03,
        load_share: 0.025,
        stated: [0.01, 0.05],
        round_lobes: 3.0,
        round_m: 5e-7,
        wave_m: 3e-8,
        finish_m: 2e-8,
        wander: WANDER,
    };
}
