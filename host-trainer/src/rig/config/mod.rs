//! `rig.toml`: what the engineer knows of the machine.
//!
//! `key` says which keys there are and what they may hold, `read` and `write` turn a file into a [`Rig`] and back,
//! [`Rig::get`] and [`Rig::set`] reach a number by its dotted name, `outer.damping_n_s_per_m` or
//! `effect[1].depth_m` (counted from 1).

mod access;
mod effects;
mod key;
mod kind;
mod paths;
mod read;
mod rig_key;
#[cfg(test)]
mod tests;
mod write;

pub use effects::{EffectEntry, Value};
pub use key::{Domain, ModelKey};
pub use kind::RigKind;
pub use rig_key::RigKey;

use toml_edit::DocumentMut;

use super::{state, transfer_path::TransmissionPath};
use crate::signal::kinematics::Geometry;

/// A rig: the nominal machine, what is only guessed about it, and effects added to it.
#[derive(Clone, Debug)]
pub struct Rig {
    /// The machine.
    pub model: Machine,
    /// Sections and keys whose value is only a guess, as in the file.
    pub unknown: Vec<String>,
    /// `[[effect]]` tables, in their order.
    pub effects: Vec<EffectEntry>,
    /// `[[path]]` tables: the structure between rig and sensor, where it was identified; at most one a channel.
    pub paths: Vec<TransmissionPath>,
    /// The file, so that comments and layout are there when it is written back.
    document: DocumentMut,
}

impl PartialEq for Rig {
    /// Equal where the values are; comments and layout do not count.
    fn eq(&self, other: &Self) -> bool {
        self.model == other.model
            && self.unknown == other.unknown
            && self.effects == other.effects
            && self.paths == other.paths
    }
}

/// Parameters of the machine, nominal or altered by effects.
#[derive(Clone, Debug, PartialEq)]
pub enum Machine {
    /// `kind = "bearing-5dof"`.
    Bearing(BearingRig),
    /// `kind = "sdof"`.
    Sdof(SdofRig),
}

/// `kind = "bearing-5dof"`.
#[derive(Clone, Debug, PartialEq)]
pub struct BearingRig {
    /// The bearing.
    pub bearing: Bearing,
    /// Inner race and shaft, x_s and y_s.
    pub inner: Support,
    /// Outer race and housing, x_p and y_p.
    pub outer: Support,
    /// Resonator y_b on the housing; its spring and damper sit between the two.
    pub resonator: Support,
    /// Excitation.
    pub excitation: Excitation,
    /// Sensor.
    pub sensor: Sensor,
}

/// Geometry and contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Bearing {
    /// n_b.
    pub balls: usize,
    /// D_b, m.
    pub ball_diameter_m: f64,
    /// D_p, m.
    pub pitch_diameter_m: f64,
    /// α, rad.
    pub contact_angle_rad: f64,
    /// c, m: displacement at which the first ball touches.
    pub radial_clearance_m: f64,
    /// k_b, N/m^p.
    pub contact_stiffness_n_per_m1_5: f64,
    /// p.
    pub contact_exponent: f64,
}

impl Bearing {
    /// Geometry that the characteristic frequencies depend on.
    pub fn geometry(&self) -> Geometry {
        Geometry {
            balls: self.balls,
            ball_diameter_m: self.ball_diameter_m,
            pitch_diameter_m: self.pitch_diameter_m,
            contact_angle_rad: self.contact_angle_rad,
        }
    }
}

/// A mass on a spring and a damper, the same in each direction that it moves in.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// m, kg.
    pub mass_kg: f64,
    /// k, N/m.
    pub stiffness_n_per_m: f64,
    /// c, N s/m.
    pub damping_n_s_per_m: f64,
}

/// Excitation of the rig.
#[derive(Clone, Debug, PartialEq)]
pub struct Excitation {
    /// m e, kg m.
    pub unbalance_kg_m: f64,
    /// One-sided power spectral density of F_proc, N²/Hz.
    pub process_force_psd_n2_per_hz: f64,
}

/// Sensor of the rig.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// Standard deviation of the white noise in each sample, m/s².
    pub noise_std_m_per_s2: f64,
    /// Location of channel `ay`.
    pub vertical: Location,
    /// Location of channel `ax`.
    pub horizontal: Location,
}

/// A mass and direction that a sensor can measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// x_s.
    InnerX,
    /// y_s.
    InnerY,
    /// x_p.
    OuterX,
    /// y_p.
    OuterY,
    /// y_b.
    ResonatorY,
}

impl Location {
    /// All locations.
    pub const ALL: [Self; 5] = [Self::InnerX, Self::InnerY, Self::OuterX, Self::OuterY, Self::ResonatorY];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::InnerX => "inner-x",
            Self::InnerY => "inner-y",
            Self::OuterX => "outer-x",
            Self::OuterY => "outer-y",
            Self::ResonatorY => "resonator-y",
        }
    }

    /// The location of this name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|location| location.name() == name)
    }

    /// The degree of freedom, as [`state`] numbers them.
    pub fn dof(self) -> usize {
        match self {
            Self::InnerX => state::INNER_X,
            Self::InnerY => state::INNER_Y,
            Self::OuterX => state::OUTER_X,
            Self::OuterY => state::OUTER_Y,
            Self::ResonatorY => state::RESONATOR_Y,
        }
    }
}

/// `kind = "sdof"`: m q̈ + c q̇ + k g(q) = gain · u + gravity, g(q) = q or sin q.
#[derive(Clone, Debug, PartialEq)]
pub struct SdofRig {
    /// m, kg.
    pub mass_kg: f64,
    /// c, N s/m.
    pub damping_n_s_per_m: f64,
    /// k, N/m.
    pub stiffness_n_per_m: f64,
    /// Force for each unit of u, N.
    pub input_gain_n_per_unit: f64,
    /// The restoring force.
    pub restoring: Restoring,
    /// Constant force in the direction of +q, N.
    pub gravity_n: f64,
}

/// Restoring force of an sdof rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Restoring {
    /// k q.
    Linear,
    /// k sin q.
    Pendulum,
}

impl Restoring {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Pendulum => "pendulum",
        }
    }
}
