//! The machine as it runs: numbers of each degree of freedom, and laws that effects add.

use std::f64::consts::TAU;

use super::motion::{Moment, Pace};
use crate::rig::config::{BearingRig, Location};

/// Degrees of freedom.
pub const DOFS: usize = 5;
/// Inner race, horizontal.
pub const INNER_X: usize = 0;
/// Inner race, vertical, in the direction of the load.
pub const INNER_Y: usize = 1;
/// Outer race and housing, horizontal.
pub const OUTER_X: usize = 2;
/// Outer race and housing, vertical.
pub const OUTER_Y: usize = 3;
/// Resonator with the sensor, vertical.
pub const SENSOR_Y: usize = 4;

/// Gravity, m/s², as the contract's reference trajectories have it.
const GRAVITY: f64 = 9.81;

/// A number of each degree of freedom.
pub type Each = [f64; DOFS];
/// Adds forces, N, at an instant, from displacements, m, and velocities, m/s.
pub type Force = Box<dyn Fn(&Moment, &Each, &Each, &mut Each) + Send + Sync>;
/// Deflection, m, that a ball loses at an instant: ball from 0, its angle in space, rad.
pub type Loss = Box<dyn Fn(&Moment, usize, f64) -> f64 + Send + Sync>;
/// Alters the samples of a channel (0 is `ax`, 1 is `ay`, 2 the tachometer), given the sample rate, Hz.
pub type Signal = Box<dyn Fn(usize, f64, &mut Vec<f64>) + Send + Sync>;
/// Alters both acceleration channels together, given the sample rate, Hz.
pub type Both = Box<dyn Fn(f64, &mut [Vec<f64>; 2]) + Send + Sync>;

/// Point of the measuring chain, in the order of the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Before the sensor.
    Structure,
    /// In the sensor, with its noise.
    Sensor,
    /// In cable and amplifier.
    Cable,
    /// In the converter.
    Converter,
    /// In the logger, where the tachometer too is written.
    Logger,
}

/// Source that drives a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Force of the bearing on the housing, horizontal.
    ContactX,
    /// Force of the bearing on the housing, vertical.
    ContactY,
    /// Acceleration of the housing, horizontal.
    HousingX,
    /// Acceleration of the housing, vertical.
    HousingY,
    /// Random force on the housing.
    Process,
}

/// Mode of the structure beside the five degrees of freedom; it does not act back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Share of critical damping.
    pub damping_ratio: f64,
    /// Source.
    pub source: Source,
    /// Gain to each channel of its acceleration.
    pub gains: [f64; 2],
}

/// Machine of one recording.
pub struct Plant {
    /// Bearing, excitation and sensor; its supports are in `mass`, `stiffness` and `damping`.
    pub rig: BearingRig,
    /// Masses, kg.
    pub mass: Each,
    /// Springs, N/m, to the ground; of the resonator to the housing.
    pub stiffness: Each,
    /// Dampers, N s/m, to the ground; of the resonator to the housing.
    pub damping: Each,
    /// Constant forces, N.
    pub constant: Each,
    /// Unbalance against the shaft angle: cosine and sine part, kg m.
    pub unbalance: [f64; 2],
    /// Angle of each ball in the cage, rad.
    pub balls_rad: Vec<f64>,
    /// Rotation.
    pub pace: Pace,
    /// Load, N.
    pub load_n: f64,
    /// Force laws.
    pub forces: Vec<Force>,
    /// Losses of deflection.
    pub losses: Vec<Loss>,
    /// Modes.
    pub modes: Vec<Mode>,
    /// Fastest rate of any law, rad/s.
    pub fastest: f64,
    /// Alterations of the samples.
    pub signals: Vec<(Stage, Signal)>,
    /// Alterations of both channels, before all others.
    pub both: Vec<Both>,
    /// Samples beyond the recording's length that the logger loses.
    pub surplus: usize,
    /// Logarithmic colour of process force and of each sensor's noise, Np, by cosine of the frequency.
    pub colour: [Vec<f64>; 3],
    /// Factor of each sensor's noise.
    pub noise: [f64; 2],
    /// Offset of each sensor, m/s².
    pub offset: [f64; 2],
}

impl Plant {
    /// Machine as its drawing says, at a rotation and a load, N.
    pub fn of_rig(rig: &BearingRig, pace: Pace, load_n: f64) -> Self {
        let (inner, outer, sensor) = (&rig.inner, &rig.outer, &rig.resonator);
        let five = |a: f64, b: f64, c: f64| [a, a, b, b, c];
        let balls = rig.bearing.balls;
        Self {
            mass: five(inner.mass_kg, outer.mass_kg, sensor.mass_kg),
            stiffness: five(inner.stiffness_n_per_m, outer.stiffness_n_per_m, sensor.stiffness_n_per_m),
            damping: five(inner.damping_n_s_per_m, outer.damping_n_s_per_m, sensor.damping_n_s_per_m),
            constant: [0.0; DOFS],
            unbalance: [rig.excitation.unbalance_kg_m, 0.0],
            balls_rad: (0..balls).map(|j| TAU * j as f64 / balls as f64).collect(),
            pace,
            load_n,
            forces: Vec::new(),
            losses: Vec::new(),
            modes: Vec::new(),
            fastest: 0.0,
            signals: Vec::new(),
            both: Vec::new(),
            surplus: 0,
            colour: [Vec::new(), Vec::new(), Vec::new()],
            noise: [1.0; 2],
            offset: [0.0; 2],
            rig: rig.clone(),
        }
    }

    /// Speed of the cage over that of the shaft, without slip.
    pub fn cage_ratio(rig: &BearingRig) -> f64 {
        let bearing = &rig.bearing;
        0.5 * (1.0 - bearing.ball_diameter_m * bearing.contact_angle_rad.cos() / bearing.pitch_diameter_m)
    }

    /// Turns of a ball about its own axis for each turn of the shaft.
    pub fn spin_ratio(rig: &BearingRig) -> f64 {
        let bearing = &rig.bearing;
        let ratio = bearing.ball_diameter_m * bearing.contact_angle_rad.cos() / bearing.pitch_diameter_m;
        0.5 * bearing.pitch_diameter_m / bearing.ball_diameter_m * (1.0 - ratio * ratio)
    }

    /// Constant forces with load and gravity, N.
    pub fn standing_forces(&self) -> Each {
        let mut forces = self.constant;
        forces[INNER_Y] += self.load_n - self.mass[INNER_Y] * GRAVITY;
        forces[SENSOR_Y] -= self.mass[SENSOR_Y] * GRAVITY;
        forces
    }

    /// Degrees of freedom that the channels measure.
    pub fn measured(&self) -> [usize; 2] {
        [self.rig.sensor.horizontal, self.rig.sensor.vertical].map(|location| match location {
            Location::InnerX => INNER_X,
            Location::InnerY => INNER_Y,
            Location::OuterX => OUTER_X,
            Location::OuterY => OUTER_Y,
            Location::ResonatorY => SENSOR_Y,
        })
    }
}
