//! What a run computes, and the places at which an effect can act on it.
//!
//! A plan starts as the nominal machine. Each effect changes it at one or more of these points:
//!
//! | point | for |
//! |---|---|
//! | [`Plan::machine`] | parameters before the run |
//! | [`Plan::speed_rate_per_s`], [`Plan::cage_factor`] | how shaft and cage turn |
//! | [`Plan::profiles`], [`Plan::pits`] | contact geometry: what each ball loses of its deflection |
//! | [`Plan::forces`] | forces on the degrees of freedom, of state, time and angles |
//! | [`Plan::signals`] | what happens between the machine and the file |

use std::f64::consts::TAU;

use super::config::{BearingRig, Machine};
use super::effect::local_defect::Passage;
use super::state::{DOFS, Instant, VelocityCovariance};

/// Adds forces in N to each degree of freedom, from positions in m and velocities in m/s.
pub type Force = Box<dyn Fn(&Instant, &[f64; DOFS], &[f64; DOFS], &mut [f64; DOFS]) + Send + Sync>;
/// Adds to each ball's loss of deflection, m: what its contact force law then has less of.
pub type Profile = Box<dyn Fn(&Instant, &mut [f64]) + Send + Sync>;
/// Adds the balls that meet a pit between two moments, a step apart.
pub type Meeting = Box<dyn Fn(&[Instant; 2], usize, &mut Vec<Passage>) + Send + Sync>;
/// Alters a signal.
pub type Signal = Box<dyn Fn(&Acquisition, &mut Vec<f64>) + Send + Sync>;

/// What a [`Signal`] knows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acquisition<'a> {
    /// The channel.
    pub channel: &'a str,
    /// Samples per second.
    pub sample_rate_hz: f64,
    /// Samples before t = 0 that the signal begins with.
    pub preroll: usize,
    /// Force that the bearing passes to the housing in the channel's direction, or the force on the mass of an sdof
    /// rig, N, at the signal's samples. Empty unless [`Plan::needs_path_force`].
    pub path_force: &'a [f64],
}

impl Acquisition<'_> {
    /// Time of a sample, s.
    pub fn time_s(&self, index: usize) -> f64 {
        (index as f64 - self.preroll as f64) / self.sample_rate_hz
    }
}

/// Where between machine and file a [`Signal`] acts. They are passed in this order, whatever the order of effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Between the mass that the rig knows and the sensor.
    Structure,
    /// The sensor. Its noise is added after it.
    Transducer,
    /// The structure between all that the rig has, its noise included, and the recording: a `[[path]]` of the file.
    Path,
    /// On the way to the converter.
    Cable,
    /// The converter's range.
    Converter,
    /// What keeps the samples. The only stage that sees the tachometer too.
    Logger,
}

/// A run with its effects.
pub struct Assembly {
    /// Parameters.
    pub machine: Machine,
    /// Of the noise that the run leaves out: a force law is then the mean over it.
    pub velocity_covariance: Option<VelocityCovariance>,
    /// Whether a force law is another where noise scatters the state.
    pub depends_on_velocity_noise: bool,
    /// Change of the shaft speed per second from t = 0, as a fraction.
    pub speed_rate_per_s: f64,
    /// Cage speed as a fraction of that of pure rolling.
    pub cage_factor: f64,
    /// Forces.
    pub forces: Vec<Force>,
    /// Contact geometry.
    pub profiles: Vec<Profile>,
    /// Contact geometry that a ball may be past in less than a step.
    pub defects: Vec<Meeting>,
    /// Output chain.
    pub signals: Vec<(Stage, Signal)>,
    /// Fastest rate that an effect brings, rad/s; the step is chosen by it and by [`Plan::turning_rad_per_s`].
    pub rate_rad_per_s: f64,
    /// The same as the shaft turns, rad for each rad of that.
    order: f64,
    /// Time that the output chain needs to settle, s.
    pub preroll_s: f64,
    /// Whether the output chain needs [`Acquisition::path_force`].
    pub needs_path_force: bool,
    /// Samples to take beyond those of the condition, for effects that lose some.
    pub surplus: usize,
}

impl Assembly {
    /// The nominal machine.
    pub fn new(machine: Machine) -> Self {
        Self {
            machine,
            velocity_covariance: None,
            depends_on_velocity_noise: false,
            speed_rate_per_s: 0.0,
            cage_factor: 1.0,
            forces: Vec::new(),
            profiles: Vec::new(),
            defects: Vec::new(),
            signals: Vec::new(),
            rate_rad_per_s: 0.0,
            order: 0.0,
            preroll_s: 0.0,
            needs_path_force: false,
            surplus: 0,
        }
    }

    /// The bearing rig, if it is one.
    pub fn bearing(&mut self) -> Option<&mut BearingRig> {
        match &mut self.machine {
            Machine::Bearing(rig) => Some(rig),
            Machine::Sdof(_) => None,
        }
    }

    /// Says that something in the run changes as fast as this, rad/s or 1/s.
    pub fn declare_rate(&mut self, rad_per_s: f64) {
        self.rate_rad_per_s = self.rate_rad_per_s.max(rad_per_s);
    }

    /// Says that something in the run changes as fast as this for each rad that the shaft turns.
    pub fn declare_order(&mut self, order: f64) {
        self.order = self.order.max(order);
    }

    /// Fastest rate that comes with the turning of a shaft, rad/s.
    pub fn turning_rad_per_s(&self, shaft_hz: f64) -> f64 {
        self.order * TAU * shaft_hz.abs()
    }

    /// Adds a force.
    pub fn force(
        &mut self,
        force: impl Fn(&Instant, &[f64; DOFS], &[f64; DOFS], &mut [f64; DOFS]) + Send + Sync + 'static,
    ) {
        self.forces.push(Box::new(force));
    }

    /// Adds a loss of deflection.
    pub fn profile(&mut self, profile: impl Fn(&Instant, &mut [f64]) + Send + Sync + 'static) {
        self.profiles.push(Box::new(profile));
    }

    /// Adds a pit.
    pub fn defect(&mut self, meeting: impl Fn(&[Instant; 2], usize, &mut Vec<Passage>) + Send + Sync + 'static) {
        self.defects.push(Box::new(meeting));
    }

    /// Adds an alteration of the signals.
    pub fn signal(&mut self, stage: Stage, signal: impl Fn(&Acquisition, &mut Vec<f64>) + Send + Sync + 'static) {
        self.signals.push((stage, Box::new(signal)));
    }
}
