//! One run, ready for the kernel: the linear part as step matrices, everything else as numbers.

use std::f64::consts::TAU;

use super::SETTINGS;
use super::rest::rest_m;
use super::step::Step;
use crate::rig::{
    assembly::{Assembly, Force, Meeting, Profile, RandomForce},
    condition::{OperatingCondition, Start},
    config::BearingRig,
    noise,
    state::{DOFS, INNER_X, INNER_Y, Instant, OUTER_X, OUTER_Y, RESONATOR_Y},
};

use super::step::STATES;

/// Gravity of the 5-DoF rig, m/s², as in the reference trajectories: 3.4e-4 above the standard 9.80665.
pub const GRAVITY: f64 = 9.81;

/// Rotation of shaft and cage, theory (28).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turning {
    /// Shaft angle at t = 0, rad.
    pub shaft0: f64,
    /// Angle of ball 0 at t = 0, rad.
    pub cage0: f64,
    /// Shaft speed up to t = 0, rad/s.
    pub omega: f64,
    /// Change of the shaft speed per second from t = 0, as a fraction.
    pub rate: f64,
    /// Cage angle for each rad of the shaft.
    pub cage_per_shaft: f64,
}

impl Turning {
    /// Shaft angle ψ, rad.
    pub fn shaft(&self, time_s: f64) -> f64 {
        self.shaft0 + self.omega * (time_s + 0.5 * self.rate * time_s * time_s.max(0.0))
    }

    /// Shaft speed ω, rad/s.
    pub fn speed(&self, time_s: f64) -> f64 {
        self.omega * (1.0 + self.rate * time_s.max(0.0))
    }

    /// Angle of ball 0, φ₀, rad.
    pub fn cage(&self, time_s: f64) -> f64 {
        self.cage0 + self.cage_per_shaft * (self.shaft(time_s) - self.shaft0)
    }
}

/// A run with all numbers that the loop needs.
pub(in crate::rig) struct Prepared {
    pub balls: usize,
    /// Angle of each ball from an even spacing, rad; empty if they are even.
    pub balls_rad: Vec<f64>,
    pub settle: usize,
    pub samples: usize,
    pub preroll: usize,
    /// Also records the force on the outer race.
    pub path_force: bool,
    pub substeps: usize,
    pub sample_rate_hz: f64,
    pub turning: Turning,
    pub drifting: bool,
    pub(super) x: Step<4, 2>,
    pub(super) y: Step<6, 3>,
    pub measured: [[f64; STATES]; 2],
    pub direct: [[f64; DOFS]; 2],
    pub clearance: f64,
    pub stiffness: f64,
    pub exponent: f64,
    /// Displacements at the start of settling, m.
    pub rest_m: [f64; DOFS],
    pub inner_y: f64,
    pub resonator_y: f64,
    /// Unbalance m e, kg m.
    pub unbalance: f64,
    /// Process force, N, of each sample from the start of settling.
    pub process: Vec<f64>,
    /// Random forces of effects, N, of each sample from the start of settling; empty without any.
    pub random: Vec<[f64; DOFS]>,
    pub forces: Vec<Force>,
    pub profiles: Vec<Profile>,
    pub defects: Vec<Meeting>,
}

/// Properties that runs must share to go side by side.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(in crate::rig) struct Shape {
    balls: usize,
    settle: usize,
    samples: usize,
    preroll: usize,
    path_force: bool,
    substeps: usize,
    drifting: bool,
    hertzian: bool,
    pub hooks: bool,
}

impl Prepared {
    pub(in crate::rig) fn new(
        rig: &BearingRig,
        assembly: &mut Assembly,
        condition: &OperatingCondition,
        start: &Start,
    ) -> Self {
        let rate = condition.sample_rate_hz;
        let settle = (start.settle_s * rate).round() as usize;
        let samples = condition.samples + assembly.surplus;
        let substeps = start.substeps.unwrap_or_else(|| substeps(rig, assembly, condition));
        let h = 1.0 / (rate * substeps as f64);
        let (ax, ay) = (system_x(rig), system_y(rig));
        let mass = masses(rig);
        let x = Step::new(&ax, &[INNER_X, OUTER_X].map(|k| 1.0 / mass[k]), h);
        let y = Step::new(&ay, &[INNER_Y, OUTER_Y, RESONATOR_Y].map(|k| 1.0 / mass[k]), h);

        let sensors = [rig.sensor.horizontal, rig.sensor.vertical].map(|location| location.dof());
        let measured = sensors.map(|dof| {
            let mut row = [0.0; STATES];
            match dof {
                INNER_X | OUTER_X => row[..4].copy_from_slice(&ax[2 + dof]),
                _ => row[4..].copy_from_slice(&ay[3 + dof - INNER_Y]),
            }
            row
        });
        let direct = sensors.map(|dof| std::array::from_fn(|k| if k == dof { 1.0 / mass[k] } else { 0.0 }));

        let white = |stream: u64, force: &RandomForce| {
            noise::white(start.seed, stream, force.variance_n2(rate).sqrt(), settle + samples)
        };
        let force = process_force(rig);
        let is_driven = start.noise && force.psd_n2_per_hz > 0.0;
        let process = if is_driven { white(noise::PROCESS_FORCE, &force) } else { Vec::new() };
        let mut random = Vec::new();
        for (stream, force) in (noise::RANDOM_FORCE..).zip(&assembly.random_forces).filter(|_| start.noise) {
            random.resize(settle + samples, [0.0; DOFS]);
            for (sum, value) in random.iter_mut().zip(white(stream, force)) {
                sum.iter_mut().zip(force.direction).for_each(|(sum, share)| *sum += share * value);
            }
        }
        let mut profiles = std::mem::take(&mut assembly.profiles);
        profiles.extend(ball_sizes(rig.bearing.balls, start));
        let turning = Turning {
            shaft0: start.shaft_angle0_rad,
            cage0: start.cage_angle0_rad,
            omega: TAU * condition.shaft_hz,
            rate: assembly.speed_rate_per_s,
            cage_per_shaft: rig.bearing.geometry().orders().ftf * assembly.cage_factor,
        };
        let from_s = -(settle as f64) / rate;
        let from = Instant {
            time_s: from_s,
            shaft_rad: turning.shaft(from_s),
            shaft_rad_per_s: turning.speed(from_s),
            cage_rad: turning.cage(from_s),
        };
        let forces = std::mem::take(&mut assembly.forces);
        let rest_m = rest_m(rig, condition.load_n, &from, &forces);
        Self {
            balls: rig.bearing.balls,
            balls_rad: balls_rad(rig.bearing.balls, start),
            settle,
            samples,
            preroll: ((assembly.preroll_s * rate).ceil() as usize).min(settle),
            path_force: assembly.needs_path_force,
            substeps,
            sample_rate_hz: rate,
            turning,
            drifting: assembly.speed_rate_per_s != 0.0,
            x,
            y,
            measured,
            direct,
            clearance: rig.bearing.radial_clearance_m,
            stiffness: rig.bearing.contact_stiffness_n_per_m1_5,
            exponent: rig.bearing.contact_exponent,
            rest_m,
            inner_y: condition.load_n - rig.inner.mass_kg * GRAVITY,
            resonator_y: -rig.resonator.mass_kg * GRAVITY,
            unbalance: rig.excitation.unbalance_kg_m,
            process,
            random,
            forces,
            profiles,
            defects: std::mem::take(&mut assembly.defects),
        }
    }

    /// Instant `steps` steps after a sample's start, from the angles there and their gains over the sample.
    pub(super) fn moment(&self, angles0: [f64; 2], gains: [f64; 2], sample: usize, steps: f64) -> Instant {
        let fraction = steps / self.substeps as f64;
        let time_s = (sample as f64 - self.settle as f64 + fraction) / self.sample_rate_hz;
        Instant {
            time_s,
            shaft_rad: angles0[0] + fraction * gains[0],
            shaft_rad_per_s: self.turning.speed(time_s),
            cage_rad: angles0[1] + fraction * gains[1],
        }
    }

    /// Whether effects act by forces.
    pub(super) fn is_forced(&self) -> bool {
        !(self.forces.is_empty() && self.random.is_empty())
    }

    pub(in crate::rig) fn shape(&self) -> Shape {
        Shape {
            balls: self.balls,
            settle: self.settle,
            samples: self.samples,
            preroll: self.preroll,
            path_force: self.path_force,
            substeps: self.substeps,
            drifting: self.drifting,
            hertzian: self.exponent == 1.5,
            hooks: self.is_forced()
                || !(self.profiles.is_empty() && self.defects.is_empty() && self.balls_rad.is_empty()),
        }
    }
}

/// Angles of balls from an even spacing, rad, 0 on average, which is an angle of the cage; empty if they are even.
fn balls_rad(balls: usize, start: &Start) -> Vec<f64> {
    if start.ball_std_rad == 0.0 {
        return Vec::new();
    }
    let angles = noise::white(start.seed, noise::BALLS, start.ball_std_rad, balls);
    let mean = angles.iter().sum::<f64>() / balls as f64;
    angles.into_iter().map(|angle| angle - mean).collect()
}

/// What a thicker ball adds to the deflection of its contacts, as a loss; `None` if the balls are alike.
fn ball_sizes(balls: usize, start: &Start) -> Option<Profile> {
    if start.ball_std_m == 0.0 {
        return None;
    }
    let sizes = noise::white(start.seed, noise::BALL_SIZES, start.ball_std_m, balls);
    let mean = sizes.iter().sum::<f64>() / balls as f64;
    Some(Box::new(move |_, losses| losses.iter_mut().zip(&sizes).for_each(|(loss, size)| *loss -= size - mean)))
}

/// The process force of a rig, on the outer race in y.
pub(in crate::rig) fn process_force(rig: &BearingRig) -> RandomForce {
    let mut direction = [0.0; DOFS];
    direction[OUTER_Y] = 1.0;
    RandomForce { direction, psd_n2_per_hz: rig.excitation.process_force_psd_n2_per_hz }
}

pub(super) fn masses(rig: &BearingRig) -> [f64; DOFS] {
    [rig.inner.mass_kg, rig.outer.mass_kg, rig.inner.mass_kg, rig.outer.mass_kg, rig.resonator.mass_kg]
}

/// Matrix A of ż = A z for x_s, x_p and their velocities, without contact: theory (31) and (33).
pub(super) fn system_x(rig: &BearingRig) -> [[f64; 4]; 4] {
    let (s, p) = (&rig.inner, &rig.outer);
    [
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [-s.stiffness_n_per_m / s.mass_kg, 0.0, -s.damping_n_s_per_m / s.mass_kg, 0.0],
        [0.0, -p.stiffness_n_per_m / p.mass_kg, 0.0, -p.damping_n_s_per_m / p.mass_kg],
    ]
}

/// Matrix A of ż = A z for y_s, y_p, y_b and their velocities, without contact: theory (32), (34) and (35).
pub(super) fn system_y(rig: &BearingRig) -> [[f64; 6]; 6] {
    let (s, p, r) = (&rig.inner, &rig.outer, &rig.resonator);
    let (k, c) = (r.stiffness_n_per_m, r.damping_n_s_per_m);
    let inner = [-s.stiffness_n_per_m, 0.0, 0.0, -s.damping_n_s_per_m, 0.0, 0.0].map(|v| v / s.mass_kg);
    let outer = [0.0, -(p.stiffness_n_per_m + k), k, 0.0, -(p.damping_n_s_per_m + c), c].map(|v| v / p.mass_kg);
    let resonator = [0.0, k, -k, 0.0, c, -c].map(|v| v / r.mass_kg);
    let unit = |i: usize| std::array::from_fn(|j| f64::from(u8::from(i == j)));
    [unit(3), unit(4), unit(5), inner, outer, resonator]
}

/// Steps a sample from the contact's frequency at its operating deflection, theory (41). Linear modes are exact at any step.
fn substeps(rig: &BearingRig, assembly: &Assembly, condition: &OperatingCondition) -> usize {
    let contact = contact_rad_per_s(rig, condition);
    let fastest = assembly.rate_rad_per_s.max(assembly.turning_rad_per_s(condition.shaft_hz));
    let steps_per_s = (contact / SETTINGS.contact_rate_per_step).max(fastest / SETTINGS.effect_rate_per_step);
    (steps_per_s / condition.sample_rate_hz).ceil().clamp(1.0, SETTINGS.max_steps) as usize
}

/// Frequency of the contact at its operating deflection, rad/s.
pub(in crate::rig) fn contact_rad_per_s(rig: &BearingRig, condition: &OperatingCondition) -> f64 {
    let bearing = &rig.bearing;
    // All the load on one ball: as stiff as the contact gets at rest.
    let deflection =
        (condition.load_n.abs() / bearing.contact_stiffness_n_per_m1_5).powf(1.0 / bearing.contact_exponent);
    let slope = bearing.contact_exponent
        * bearing.contact_stiffness_n_per_m1_5
        * deflection.powf(bearing.contact_exponent - 1.0);
    (slope * (1.0 / rig.inner.mass_kg + 1.0 / rig.outer.mass_kg)).sqrt()
}
