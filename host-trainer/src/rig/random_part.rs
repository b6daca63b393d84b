//! Random part of a recording: response to the process force and to the random forces of effects, theory (51) and (52).
//!
//! The response is that of the rig linearised about its motion (theory (49) and (50)), through the linear part of the output
//! chain; as balls pass, the contact's slope changes, and responses begin at several angles of the cage. Force laws that
//! depend on the noise ([`Assembly::depends_on_velocity_noise`](super::assembly::Assembly)) are linearised about a run that is the mean over the
//! noise, instant by instant: noise escapes where the run slides and is stopped where it turns, so that the mean slope is no
//! measure of its power. The spectrum is then the mean of the squared responses to impulses at several instants.

use std::f64::consts::TAU;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use rayon::prelude::*;

use super::{
    assembly::{Acquisition, Assembly, RandomForce, Stage},
    bearing::{self, Changing, Impulse, Linear, Passing, Prepared, Tangent, Visited},
    condition::{OperatingCondition, Start},
    config::{BearingRig, Rig},
    error::RigError,
    settings::{IntegrationSettings, LinearisationSettings},
    simulate::{
        assemble, assemble_in_noise, bearing_under, diverged_at_s, fewest_substeps, output_chain, shortest_settling_s,
        side_by_side,
    },
    state::{DOFS, OUTER_X, OUTER_Y, VelocityCovariance},
};

const SETTINGS: LinearisationSettings = LinearisationSettings::DEFAULT;
const INTEGRATION: IntegrationSettings = IntegrationSettings::DEFAULT;

/// Response to a white force.
pub struct Driven {
    /// Variance of the force, N².
    pub variance_n2: f64,
    /// Responses of `ax` and `ay` to 1 N during one sample, m/s², at sampled instants of the run; S takes the mean of their
    /// powers.
    pub responses: Vec<[Vec<f64>; 2]>,
}

/// Random part of a rig's motion.
pub struct RandomPart {
    /// Response to the process force.
    pub process: Driven,
    /// Responses to the random forces of effects.
    pub effects: Vec<Driven>,
    /// Gain of the sensor noise of `ax` and `ay` on its way to the file.
    pub noise_gain: [f64; 2],
    /// Velocity covariance under all of these forces.
    pub scatter: VelocityCovariance,
}

/// Rig and condition of a random part.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// The rig.
    pub rig: &'a Rig,
    /// Operating condition.
    pub condition: OperatingCondition,
    /// Velocity covariance of a nearly equal rig, if known: force laws that depend on the noise then count by their mean
    /// slopes in it, which is much less work.
    pub known: Option<VelocityCovariance>,
}

/// Random parts of `ax` and `ay` of each rig, through the linear part of the output chain. A response ends where it has
/// decayed, after `condition.samples` at most.
///
/// # Errors
///
/// For each rig its own, as [`simulate`](super::simulate()).
pub fn random_parts(asked: &[Asked]) -> Vec<Result<RandomPart, RigError>> {
    asked.par_iter().zip(states(asked)).map(|(of, states)| random_part(of, states)).collect()
}

impl Asked<'_> {
    /// Known velocity covariance; `None` if no force law depends on it.
    fn heeded(&self, assembly: &Assembly) -> Option<VelocityCovariance> {
        self.known.filter(|_| assembly.depends_on_velocity_noise)
    }

    /// Run along which the rig is linearised once; `None` for a rig that is linearised otherwise, or refused.
    fn along(&self) -> Option<Ready<'_>> {
        self.rig.check().ok()?;
        let assembly = assemble(self.rig);
        let is_needed = !assembly.forces.is_empty() && (self.known.is_some() || !assembly.depends_on_velocity_noise);
        let along = Along {
            rig: self.rig,
            condition: &self.condition,
            scatter: self.heeded(&assembly),
            states: SETTINGS.states,
        };
        is_needed.then(|| along.ready().ok())?
    }
}

/// States along the runs of [`Asked::along`], side by side.
fn states(asked: &[Asked]) -> Vec<Option<Result<Vec<Visited>, RigError>>> {
    let (which, runs): (Vec<usize>, Vec<Ready>) =
        asked.iter().enumerate().filter_map(|(n, of)| Some((n, of.along()?))).unzip();
    let mut states: Vec<_> = asked.iter().map(|_| None).collect();
    which.into_iter().zip(visited(runs)).for_each(|(n, visited)| states[n] = Some(visited));
    states
}

fn random_part(of: &Asked, states: Option<Result<Vec<Visited>, RigError>>) -> Result<RandomPart, RigError> {
    let Asked { rig, condition, .. } = of;
    rig.check()?;
    let assembly = assemble(rig);
    let machine = &bearing_under(&assembly, condition)?;
    let driving = Driving::new(machine, &assembly, *condition);
    let forces = assemble_in_noise(rig, of.heeded(&assembly)).forces;
    let slopes = bearing::slopes_at_rest(machine, condition.load_n, &forces);
    let passing = Passing::new(machine, &slopes, driving.turn_rad);
    let impulses = match states {
        Some(states) => driving.impulses_as_balls_pass(&bearing::along(machine, &forces, &states?), &passing),
        None if assembly.depends_on_velocity_noise => in_scatter(rig, &driving, &passing)?,
        None => driving.impulses_as_balls_pass(&bearing::at_rest(&slopes), &passing),
    };
    let scatter = driving.scatter(&impulses);
    let chain: Vec<_> = output_chain(assembly).into_iter().filter(|(stage, _)| *stage <= Stage::Amplifier).collect();
    let sensed = |(channel, [along, across], [path_force, across_force]): (&str, [&[f64]; 2], [&[f64]; 2])| {
        let sample_rate_hz = condition.sample_rate_hz;
        let at = Acquisition { channel, sample_rate_hz, preroll: 1, path_force, across_force, across };
        let mut signal = along.to_vec();
        // The chain's output at rest is no response.
        let rest = vec![0.0; signal.len()];
        let mut offset = rest.clone();
        for (_, alter) in &chain {
            alter(&at, &mut signal);
            alter(&Acquisition { path_force: &rest, across_force: &rest, across: &rest, ..at }, &mut offset);
        }
        signal.iter().zip(offset).skip(at.preroll).map(|(value, offset)| value - offset).collect()
    };
    let response = |impulse: &Impulse| {
        // From rest: what the chain is given first it takes for the state before.
        let [ax, ay, fx, fy] = impulse.signals.each_ref().map(|signal| [&[0.0], signal.as_slice()].concat());
        [("ax", [&*ax, &*ay], [&*fx, &*fy]), ("ay", [&*ay, &*ax], [&*fy, &*fx])].map(sensed)
    };
    let driven = |(n, force): (usize, &RandomForce)| Driven {
        variance_n2: force.variance_n2(condition.sample_rate_hz),
        responses: impulses.iter().map(|of_instant| response(&of_instant[n])).collect(),
    };
    let mut effects: Vec<Driven> = driving.forces.iter().enumerate().map(driven).collect();
    let process = effects.remove(0);
    let noise_gain = ["ax", "ay"].map(|channel| {
        let sample_rate_hz = condition.sample_rate_hz;
        let at = Acquisition {
            channel,
            sample_rate_hz,
            preroll: 0,
            path_force: &[0.0],
            across_force: &[0.0],
            across: &[0.0],
        };
        let mut unit = vec![1.0];
        chain.iter().filter(|(stage, _)| *stage == Stage::Amplifier).for_each(|(_, alter)| alter(&at, &mut unit));
        unit[0]
    });
    Ok(RandomPart { process, effects, noise_gain, scatter })
}

/// White forces on a machine.
struct Driving<'m> {
    machine: &'m BearingRig,
    condition: OperatingCondition,
    /// Turn of the cage from one sample to the next, rad.
    turn_rad: f64,
    /// The process force first, then those of effects.
    forces: Vec<RandomForce>,
}

impl<'m> Driving<'m> {
    fn new(machine: &'m BearingRig, assembly: &Assembly, condition: OperatingCondition) -> Self {
        let process = bearing::process_force(machine);
        let forces = std::iter::once(process).chain(assembly.random_forces.iter().copied()).collect();
        let cage_per_shaft = machine.bearing.geometry().orders().ftf * assembly.cage_factor;
        let turn_rad = TAU * cage_per_shaft * condition.shaft_hz / condition.sample_rate_hz;
        Self { machine, condition, turn_rad, forces }
    }

    /// Response of the linearised machine to each force.
    fn impulses(&self, tangent: &Tangent) -> Vec<Impulse> {
        let linear = Linear::new(self.machine, tangent, self.condition.sample_rate_hz, 1);
        self.impulses_of(&linear, SETTINGS.decay, std::iter::repeat(Changing::default()))
    }

    /// The same at several angles of the cage, whose balls change the slope of the contact: what that carries from one direction and
    /// frequency to others is most of the noise where the force has no direct way.
    fn impulses_as_balls_pass(&self, tangent: &Tangent, passing: &Passing) -> Vec<Vec<Impulse>> {
        if passing.is_constant() {
            return vec![self.impulses(tangent)];
        }
        let linear = Linear::new(self.machine, tangent, self.condition.sample_rate_hz, 1);
        let angles = SETTINGS.passing_angles;
        let from = |n: usize| {
            let cage_rad = passing.pitch_rad() * n as f64 / angles as f64;
            let changing = passing.from(cage_rad).map(|contact| Changing { contact, ..Changing::default() });
            self.impulses_of(&linear, SETTINGS.decay_of_many, changing)
        };
        (0..angles).map(from).collect()
    }

    /// Responses to each force with what [`Linear::impulse`] takes.
    fn impulses_of<'d>(
        &self,
        linear: &Linear,
        decayed: f64,
        changing: impl Iterator<Item = Changing<'d>> + Clone,
    ) -> Vec<Impulse> {
        let of = |(n, force): (usize, &RandomForce)| {
            let mut impulse = linear.impulse(&force.direction, self.condition.samples, decayed, changing.clone());
            // An effect's own force goes through the structure to the sensor, the process force does not.
            let [_, _, fx, fy] = &mut impulse.signals;
            for (signal, dof) in [(fx, OUTER_X), (fy, OUTER_Y)].into_iter().filter(|_| n > 0) {
                signal.iter_mut().take(1).for_each(|first| *first += force.direction[dof]);
            }
            impulse
        };
        self.forces.iter().enumerate().map(of).collect()
    }

    /// Velocity covariance under all forces, mean over instants, theory (52).
    fn scatter(&self, impulses: &[Vec<Impulse>]) -> VelocityCovariance {
        let mut mean = [[0.0; DOFS]; DOFS];
        for (force, impulse) in impulses.iter().flat_map(|of_instant| self.forces.iter().zip(of_instant)) {
            let power = force.variance_n2(self.condition.sample_rate_hz);
            let pairs = mean.iter_mut().flatten().zip(impulse.velocities.iter().flatten());
            pairs.for_each(|(sum, one)| *sum += power * one / impulses.len() as f64);
        }
        VelocityCovariance(mean)
    }
}

/// Impulse responses at instants of a rig whose force laws depend on the noise: slopes follow from the velocity covariance,
/// and that from the slopes.
fn in_scatter(rig: &Rig, driving: &Driving, passing: &Passing) -> Result<Vec<Vec<Impulse>>, RigError> {
    let Driving { machine, condition, .. } = driving;
    let rate = condition.sample_rate_hz;
    let mut found = vec![driving.impulses(&bearing::at_rest(&bearing::slopes_at_rest(machine, condition.load_n, &[])))];
    for (round, moments) in SETTINGS.instants.into_iter().enumerate() {
        let along = Along { rig, condition, scatter: Some(driving.scatter(&found)), states: condition.samples };
        // One run in, one result out.
        let visited = visited(vec![along.ready()?]).swap_remove(0)?;
        let few = subset(&visited);
        let tangent_in = |scatter: VelocityCovariance| {
            let assembly = assemble_in_noise(rig, Some(scatter));
            (bearing::along(machine, &assembly.forces, &few), assembly.forces)
        };
        if round == 0 {
            for _ in 0..SETTINGS.mean_rounds {
                found = vec![driving.impulses(&tangent_in(driving.scatter(&found)).0)];
            }
        }
        let (tangent, forces) = tangent_in(driving.scatter(&found));
        let (damping, steps) = bearing::damping_along(machine, &forces, &visited, rate);
        let linear = Linear::new(machine, &tangent.undamped(), rate, steps);
        let from = |n: usize| {
            let start = n * damping.len() / moments;
            let (before, after) = damping.split_at(start);
            let cage_rad = visited.get(start).map_or(0.0, |(at, ..)| at.cage_rad);
            let both = after.iter().chain(before).cycle().map(Some).zip(passing.from(cage_rad));
            let changing = both.map(|(damping, contact)| Changing { damping, contact });
            driving.impulses_of(&linear, SETTINGS.decay_of_many, changing)
        };
        found = (0..moments).map(from).collect();
    }
    Ok(found)
}

/// Some hundred of the visited states.
fn subset(visited: &[Visited]) -> Vec<Visited> {
    visited.iter().step_by((visited.len() / SETTINGS.states).max(1)).copied().collect()
}

/// Whether a force law of the rig depends on the noise of the velocities.
pub fn depends_on_velocity_noise(rig: &Rig) -> bool {
    assemble(rig).depends_on_velocity_noise
}

/// Short run along which a rig is linearised: with its noise, or without if the velocity covariance is given.
#[derive(Clone, Copy)]
struct Along<'r> {
    rig: &'r Rig,
    condition: &'r OperatingCondition,
    scatter: Option<VelocityCovariance>,
    /// States that are kept, those of all samples at most.
    states: usize,
}

/// A run that is ready, and the states that it will have visited.
struct Ready<'r> {
    along: Along<'r>,
    prepared: Prepared,
    kept: Arc<Mutex<Vec<Visited>>>,
}

impl<'r> Along<'r> {
    fn ready(self) -> Result<Ready<'r>, RigError> {
        self.in_steps(fewest_substeps(self.rig, self.scatter, self.condition))
    }

    fn in_steps(self, substeps: usize) -> Result<Ready<'r>, RigError> {
        let Self { rig, condition, scatter, states } = self;
        let samples = condition.samples.min((SETTINGS.run_s * condition.sample_rate_hz) as usize).max(1);
        let substeps = Some(substeps);
        let seeded = Start::seeded(SETTINGS.seed);
        let settle_s = SETTINGS.settle_s.min(shortest_settling_s(rig));
        let start = Start { substeps, velocity_covariance: scatter, noise: scatter.is_none(), settle_s, ..seeded };
        let mut assembly = assemble_in_noise(rig, scatter);
        let kept: Arc<Mutex<Vec<Visited>>> = Arc::default();
        let keep = Arc::clone(&kept);
        let interval_s = samples as f64 / condition.sample_rate_hz / states.min(samples) as f64;
        // Read four times a step: too often for a lock.
        let next = AtomicU64::new(0.0f64.to_bits());
        assembly.force(move |at, q, v, _| {
            let due_s = f64::from_bits(next.load(Ordering::Relaxed));
            if at.time_s >= due_s
                && let Ok(mut keep) = keep.lock()
            {
                next.store((due_s + interval_s).to_bits(), Ordering::Relaxed);
                keep.push((*at, *q, *v));
            }
        });
        let machine = bearing_under(&assembly, condition)?;
        let condition = OperatingCondition { samples, ..*condition };
        Ok(Ready { along: self, prepared: Prepared::new(&machine, &mut assembly, &condition, &start), kept })
    }
}

/// Visited states of runs, side by side.
fn visited(runs: Vec<Ready>) -> Vec<Result<Vec<Visited>, RigError>> {
    let (prepared, rest): (Vec<_>, Vec<_>) = runs.into_iter().map(|run| (run.prepared, (run.along, run.kept))).unzip();
    side_by_side(prepared, |n, prepared, signals| {
        let (along, kept) = &rest[n];
        match diverged_at_s(&signals, prepared, along.condition.sample_rate_hz) {
            // A force may be stiffer than where its steps are counted for.
            Some(_) if prepared.substeps < INTEGRATION.most_finer_steps => {
                visited(vec![along.in_steps(INTEGRATION.finer * prepared.substeps)?]).swap_remove(0)
            }
            Some(time_s) => Err(RigError::Diverged { time_s }),
            None => Ok(kept.lock().map(|mut kept| std::mem::take(&mut *kept)).unwrap_or_default()),
        }
    })
}
