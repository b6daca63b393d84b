//! Assembly of a run, and the points at which an effect can act on it.
//!
//! An assembly starts as the nominal machine. Each effect changes it at one or more of these points:
//!
//! | point | for |
//! |---|---|
//! | [`Assembly::machine`] | parameters before the run |
//! | [`Assembly::speed_rate_per_s`], [`Assembly::cage_factor`] | rotation of shaft and cage, theory (28) |
//! | [`Assembly::profiles`], [`Assembly::defects`] | contact geometry: each ball's loss of deflection, theory (29) |
//! | [`Assembly::forces`] | forces on the degrees of freedom, of state, time and angles |
//! | [`Assembly::random_forces`] | white forces on them |
//! | [`Assembly::signals`] | acquisition chain from machine to file, theory (38) |

use std::f64::consts::TAU;

use super::config::{BearingRig, Machine};
use super::effect::local_defect::Passage;
use super::film::Lubricant;
use super::state::{DOFS, Instant, VelocityCovariance};

/// Adds forces in N to each degree of freedom, from positions in m and velocities in m/s.
pub type Force = Box<dyn Fn(&Instant, &[f64; DOFS], &[f64; DOFS], &mut [f64; DOFS]) + Send + Sync>;
/// Adds to each ball's loss of deflection, m, which is subtracted before the contact law.
pub type Profile = Box<dyn Fn(&Instant, &mut [f64]) + Send + Sync>;
/// Adds the balls that meet a local defect between two instants, a step apart.
pub type Meeting = Box<dyn Fn(&[Instant; 2], usize, &mut Vec<Passage>) + Send + Sync>;
/// Alters a signal.
pub type Signal = Box<dyn Fn(&Acquisition, &mut Vec<f64>) + Send + Sync>;

/// White force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomForce {
    /// Force on each degree of freedom for 1 N.
    pub direction: [f64; DOFS],
    /// One-sided power spectral density, N²/Hz.
    pub psd_n2_per_hz: f64,
}

impl RandomForce {
    /// Variance of the force where each value is held over a sample, N²: white up to half the sample rate.
    pub fn variance_n2(&self, sample_rate_hz: f64) -> f64 {
        0.5 * self.psd_n2_per_hz * sample_rate_hz
    }
}

/// Context of a [`Signal`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acquisition<'a> {
    /// The channel.
    pub channel: &'a str,
    /// Samples per second.
    pub sample_rate_hz: f64,
    /// Samples before t = 0 that the signal begins with.
    pub preroll: usize,
    /// Force on the outer race in the channel's direction at the signal's samples, N: contact and effects, without the
    /// process force; of an sdof rig the force on the mass. Empty unless [`Assembly::needs_path_force`].
    pub path_force: &'a [f64],
    /// The same across the channel's direction; empty for an sdof rig.
    pub across_force: &'a [f64],
    /// Acceleration of the rig across the channel's direction, m/s²; empty for an sdof rig.
    pub across: &'a [f64],
}

impl Acquisition<'_> {
    /// Time of a sample, s.
    pub fn time_s(&self, index: usize) -> f64 {
        (index as f64 - self.preroll as f64) / self.sample_rate_hz
    }
}

/// Stage between machine and file at which a [`Signal`] acts. Stages are passed in this order, whatever the order of
/// effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Structure between the rig's mass and the sensor.
    Structure,
    /// Sensor; sensor noise is added after it.
    Transducer,
    /// Amplifier of signal and noise.
    Amplifier,
    /// Transmission path of the signal, noise included: a `[[path]]` of the file.
    Path,
    /// Cable to the converter.
    Cable,
    /// Converter with its range.
    Converter,
    /// Logger of the samples; the only stage that sees the tachometer too.
    Logger,
}

/// Machine of a run with its effects.
pub struct Assembly {
    /// Parameters.
    pub machine: Machine,
    /// Lubricant of the contacts; `None` for dry ones.
    pub lubricant: Option<Lubricant>,
    /// Velocity covariance of the noise that the run leaves out; a force law is then the mean over it.
    pub velocity_covariance: Option<VelocityCovariance>,
    /// Whether a force law depends on [`Assembly::velocity_covariance`].
    pub depends_on_velocity_noise: bool,
    /// Change of the shaft speed per second from t = 0, as a fraction.
    pub speed_rate_per_s: f64,
    /// Cage speed as a fraction of that of pure rolling.
    pub cage_factor: f64,
    /// Forces.
    pub forces: Vec<Force>,
    /// White forces beside the process force.
    pub random_forces: Vec<RandomForce>,
    /// Contact geometry.
    pub profiles: Vec<Profile>,
    /// Local defects, which a ball may pass in less than a step.
    pub defects: Vec<Meeting>,
    /// Output chain.
    pub signals: Vec<(Stage, Signal)>,
    /// Fastest rate of an effect, rad/s; together with [`Assembly::turning_rad_per_s`] it sets the step.
    pub rate_rad_per_s: f64,
    /// Fastest rate of an effect that turns with the shaft, rad per rad of the shaft.
    order: f64,
    /// Time that the output chain needs to settle, s.
    pub preroll_s: f64,
    /// Whether the output chain needs [`Acquisition::path_force`].
    pub needs_path_force: bool,
    /// Samples beyond those of the condition, for effects that drop some.
    pub surplus: usize,
}

impl Assembly {
    /// Assembly of the nominal machine.
    pub fn new(machine: Machine) -> Self {
        Self {
            machine,
            lubricant: None,
            velocity_covariance: None,
            depends_on_velocity_noise: false,
            speed_rate_per_s: 0.0,
            cage_factor: 1.0,
            forces: Vec::new(),
            random_forces: Vec::new(),
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

    /// Bearing rig; `None` for an sdof rig.
    pub fn bearing(&mut self) -> Option<&mut BearingRig> {
        match &mut self.machine {
            Machine::Bearing(rig) => Some(rig),
            Machine::Sdof(_) => None,
        }
    }

    /// Declares a rate of the run, rad/s or 1/s.
    pub fn declare_rate(&mut self, rad_per_s: f64) {
        self.rate_rad_per_s = self.rate_rad_per_s.max(rad_per_s);
    }

    /// Declares a rate per rad of the shaft.
    pub fn declare_order(&mut self, order: f64) {
        self.order = self.order.max(order);
    }

    /// Fastest rate of what turns with the shaft, rad/s.
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

    /// Adds a local defect.
    pub fn defect(&mut self, meeting: impl Fn(&[Instant; 2], usize, &mut Vec<Passage>) + Send + Sync + 'static) {
        self.defects.push(Box::new(meeting));
    }

    /// Adds an alteration of the signals.
    pub fn signal(&mut self, stage: Stage, signal: impl Fn(&Acquisition, &mut Vec<f64>) + Send + Sync + 'static) {
        self.signals.push((stage, Box::new(signal)));
    }
}
