//! Degrees of freedom of a rig, and an instant of a run.

/// Degrees of freedom that a force can act on. An sdof rig uses only the first.
pub const DOFS: usize = 5;
/// x_s, inner race.
pub const INNER_X: usize = 0;
/// x_p, outer race and housing.
pub const OUTER_X: usize = 1;
/// y_s, inner race.
pub const INNER_Y: usize = 2;
/// y_p, outer race and housing.
pub const OUTER_Y: usize = 3;
/// y_b, resonator.
pub const RESONATOR_Y: usize = 4;
/// The mass of an sdof rig.
pub const MASS: usize = 0;

/// Covariance of the five velocities under the noise that a run leaves out, m²/s², theory (52).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityCovariance(pub [[f64; DOFS]; DOFS]);

/// An instant of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Instant {
    /// Time from the first sample, s; negative while settling.
    pub time_s: f64,
    /// Shaft angle ψ, rad.
    pub shaft_rad: f64,
    /// Shaft speed ω, rad/s.
    pub shaft_rad_per_s: f64,
    /// Angle of ball 0, φ₀, rad.
    pub cage_rad: f64,
}
