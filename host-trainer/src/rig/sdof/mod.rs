//! The rig of one degree of freedom, driven by a recorded input, theory (42) and (43).
//!
//! Integrated by the classical Runge–Kutta method of order four with a step chosen from the fastest rate; where that is far
//! above the sample rate, as of steep friction or a mass of almost nothing, by an implicit method (`implicit`). Between its
//! samples the input is held ([`Interpolation::Hold`]), as a converter holds its command; [`Interpolation::Linear`] and
//! [`Interpolation::Smooth`] are for an input that was itself measured.

mod implicit;
#[cfg(test)]
mod tests;

use crate::recording::{Channel, Recording, Source};
use crate::rig::{
    assembly::{Acquisition, Force, Signal, Stage},
    config::{Machine, Restoring, Rig, SdofRig},
    error::RigError,
    settings::IntegrationSettings,
    simulate::{assemble, output_chain},
    state::{DOFS, Instant, MASS},
};

const SETTINGS: IntegrationSettings = IntegrationSettings::DEFAULT;

/// The input between its samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// The last sample's value until the next.
    #[default]
    Hold,
    /// A straight line from one sample to the next.
    Linear,
    /// A cubic with slopes of order four, for an input of some ten samples a period.
    Smooth,
}

impl Interpolation {
    /// Value at a part of the step after sample `k` of a signal.
    pub fn value(self, signal: &[f64], k: usize, part: f64) -> f64 {
        let last = signal.len() - 1;
        let at = |i: isize| signal[(k as isize + i).clamp(0, last as isize) as usize];
        let (from, to) = (at(0), at(1));
        match self {
            Self::Hold => from,
            Self::Linear => from + part * (to - from),
            Self::Smooth if k < 2 || k + 3 > last => from + part * (to - from),
            Self::Smooth => {
                let slope = |i: isize| (8.0 * (at(i + 1) - at(i - 1)) - (at(i + 2) - at(i - 2))) / 12.0;
                let (p, rise) = (part, to - from);
                let (a, b) = (slope(0) - rise, rise - slope(1));
                from + p * rise + p * (1.0 - p) * ((1.0 - p) * a + p * b)
            }
        }
    }
}

/// Start and input of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drive<'a> {
    /// Input u at each sample, in the unit of the rig's gain.
    pub input: &'a [f64],
    /// Samples per second.
    pub sample_rate_hz: f64,
    /// Position q at the first sample, m or rad.
    pub position: f64,
    /// Velocity q̇ at the first sample, m/s or rad/s.
    pub velocity: f64,
    /// Input between its samples.
    pub interpolation: Interpolation,
    /// Sample of the input at which the run begins.
    pub first: usize,
    /// Samples of the run; 0 runs to the end of the input.
    pub samples: usize,
}

impl Drive<'_> {
    /// Samples of the input that the run covers.
    fn range(&self) -> std::ops::Range<usize> {
        let rest = self.input.len().saturating_sub(self.first);
        let samples = if self.samples == 0 { rest } else { self.samples.min(rest) };
        self.first..self.first + samples
    }
}

/// Simulates an sdof rig over an input: channels `u`, `q`, `qd` and `qdd`, as many samples as the input has (fewer by
/// what a dropped-samples effect takes).
///
/// # Errors
///
/// A rig that [`Rig::check`] refuses or that is a bearing's, an impossible drive, a run that diverges.
pub fn simulate(rig: &Rig, drive: &Drive) -> Result<Recording, RigError> {
    let rate = drive.sample_rate_hz;
    let refuse = |field, found: String, expected| Err(RigError::BadCondition { field, found, expected });
    if !(rate.is_finite() && rate > 0.0) {
        return refuse("sample_rate_hz", rate.to_string(), "a positive number of Hz");
    }
    if drive.range().is_empty() || drive.input.iter().any(|u| !u.is_finite()) {
        return refuse("input", "no samples, or one that is not finite".into(), "finite samples, at least one");
    }
    rig.check()?;
    let mut assembly = assemble(rig);
    let Machine::Sdof(machine) = assembly.machine.clone() else {
        return refuse("rig.kind", "\"bearing-5dof\"".into(), "\"sdof\"");
    };
    let own = (machine.stiffness_n_per_m / machine.mass_kg).sqrt();
    let fastest = own.max(machine.damping_n_s_per_m / machine.mass_kg).max(assembly.rate_rad_per_s);
    let steps = |fastest: f64| (fastest / (rate * SETTINGS.sdof_rate_per_step)).ceil().max(1.0);
    let explicit = steps(fastest);
    let scheme = if explicit <= SETTINGS.sdof_max_steps {
        Scheme { substeps: explicit as usize, implicit: false }
    } else {
        let substeps = steps(own).clamp(SETTINGS.sdof_implicit_steps, SETTINGS.sdof_max_steps);
        Scheme { substeps: substeps as usize, implicit: true }
    };
    let law = Law { rig: machine, forces: std::mem::take(&mut assembly.forces) };
    let motion = law.run(drive, scheme)?;
    Ok(record(motion, drive, law.rig.mass_kg, &output_chain(assembly)))
}

/// Steps between two samples.
#[derive(Clone, Copy, Debug)]
struct Scheme {
    substeps: usize,
    implicit: bool,
}

/// The equation of motion.
struct Law {
    rig: SdofRig,
    forces: Vec<Force>,
}

impl Law {
    /// Acceleration q̈.
    fn acceleration(&self, time_s: f64, u: f64, q: f64, v: f64) -> f64 {
        let rig = &self.rig;
        let restoring = match rig.restoring {
            Restoring::Linear => q,
            Restoring::Pendulum => q.sin(),
        };
        let mut force = rig.input_gain_n_per_unit * u + rig.gravity_n
            - rig.damping_n_s_per_m * v
            - rig.stiffness_n_per_m * restoring;
        if !self.forces.is_empty() {
            let at = Instant { time_s, ..Instant::default() };
            let (mut positions, mut velocities, mut sum) = ([0.0; DOFS], [0.0; DOFS], [0.0; DOFS]);
            (positions[MASS], velocities[MASS]) = (q, v);
            for effect in &self.forces {
                effect(&at, &positions, &velocities, &mut sum);
            }
            force += sum[MASS];
        }
        force / rig.mass_kg
    }

    /// q, q̇ and q̈ at each sample.
    fn run(&self, drive: &Drive, scheme: Scheme) -> Result<[Vec<f64>; 3], RigError> {
        let substeps = scheme.substeps;
        let h = 1.0 / (drive.sample_rate_hz * substeps as f64);
        let (mut q, mut v) = (drive.position, drive.velocity);
        let mut out = [(); 3].map(|()| Vec::with_capacity(drive.range().len()));
        for (count, sample) in drive.range().enumerate() {
            let time = count as f64 / drive.sample_rate_hz;
            let u = |place: f64| drive.interpolation.value(drive.input, sample, place / substeps as f64);
            let mut a = self.acceleration(time, drive.input[sample], q, v);
            if !(q.is_finite() && a.is_finite()) {
                return Err(RigError::Diverged { time_s: time });
            }
            for (signal, value) in out.iter_mut().zip([q, v, a]) {
                signal.push(value);
            }
            for substep in 0..substeps {
                let place = substep as f64;
                let t = time + place * h;
                if scheme.implicit {
                    let inputs = [u(place + implicit::GAMMA), u(place + 1.0)];
                    [q, v, a] = self.implicit_step(t, inputs, h, [q, v], a);
                    continue;
                }
                let (first, middle, last) = (u(place), u(place + 0.5), u(place + 1.0));
                let (v1, a1) = (v, self.acceleration(t, first, q, v));
                let half = t + 0.5 * h;
                let (v2, a2) = (v + 0.5 * h * a1, self.acceleration(half, middle, q + 0.5 * h * v1, v + 0.5 * h * a1));
                let (v3, a3) = (v + 0.5 * h * a2, self.acceleration(half, middle, q + 0.5 * h * v2, v + 0.5 * h * a2));
                let (v4, a4) = (v + h * a3, self.acceleration(t + h, last, q + h * v3, v + h * a3));
                q += h / 6.0 * (v1 + 2.0 * (v2 + v3) + v4);
                v += h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4);
            }
        }
        Ok(out)
    }
}

fn record(motion: [Vec<f64>; 3], drive: &Drive, mass: f64, signals: &[(Stage, Signal)]) -> Recording {
    let path_force: Vec<f64> = motion[2].iter().map(|a| a * mass).collect();
    let [q, qd, qdd] = motion;
    let channels = [("u", drive.input[drive.range()].to_vec()), ("q", q), ("qd", qd), ("qdd", qdd)];
    let channels = channels.into_iter().map(|(name, mut samples)| {
        let at = Acquisition {
            channel: name,
            sample_rate_hz: drive.sample_rate_hz,
            preroll: 0,
            path_force: &path_force,
            across_force: &[],
            across: &[],
        };
        // The input is a command, no sensor's signal; only the logger sees it.
        let seen = signals.iter().filter(|(stage, _)| name != "u" || *stage == Stage::Logger);
        seen.for_each(|(_, alter)| alter(&at, &mut samples));
        Channel { name: name.into(), location: None, samples }
    });
    Recording {
        source: Source::default(),
        channels: channels.collect(),
        sample_rate_hz: drive.sample_rate_hz,
        ..Recording::default()
    }
}
