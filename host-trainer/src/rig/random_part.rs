//! What the process force becomes in the random part of a recording.
//!
//! The response of the rig linearised about its motion ([`bearing::response`](super::bearing)), through the linear part of the
//! output chain. Force laws whose slopes change so fast that noise makes other laws of them
//! ([`Plan::heeds_scatter`](super::assembly::Plan)) are linearised about a run that is the mean over the noise, and moment by
//! moment: noise escapes where the run slides and is stopped where it turns, so that the mean of the slopes says little of its
//! power. The recording's spectrum is then the mean of the squared responses to impulses at all moments.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use rayon::prelude::*;

use super::{
    assembly::{Acquisition, Assembly, Stage},
    bearing::{self, Impulse, Linear, Prepared, Tangent, Visited},
    condition::{OperatingCondition, Start},
    config::{BearingRig, Rig},
    error::RigError,
    simulate::{
        assemble, assemble_in_noise, bearing_of, fewest_substeps, output_chain, shortest_settling_s, side_by_side,
    },
    state::{DOFS, VelocityCovariance},
};

/// The rig is linearised over this long, after this long, at so many states, with the noise of this seed.
const LINEARISED_OVER_S: f64 = 0.15;
const LINEARISED_AFTER_S: f64 = 0.2;
const LINEARISED_AT: usize = 300;
const LINEARISED_WITH: u64 = 1;

/// A response ends where it has come down to this share of its greatest, one of many earlier.
const DECAYED: f64 = 1e-9;
const DECAYED_AT_MOMENTS: f64 = 1e-4;
/// Rounds from scatter to slopes and back along one run by its mean slopes, where heavy friction halves the logarithm of what
/// is wrong with the scatter each time; then moments of a run, twice.
const MEAN_ROUNDS: usize = 4;
const MOMENTS: [usize; 2] = [8, 16];

/// What the process force does to a rig.
pub struct RandomPart {
    /// Responses of `ax` and `ay` to 1 N during one sample, m/s², at moments that stand for all: their powers' mean counts.
    pub responses: Vec<[Vec<f64>; 2]>,
    /// What all of the force adds to the state.
    pub scatter: VelocityCovariance,
}

/// A rig whose random part is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// The rig.
    pub rig: &'a Rig,
    /// Its operating condition.
    pub condition: OperatingCondition,
    /// The scatter, where it is known of a rig that is nearly the same: force laws that are others in noise then count by the
    /// mean of their slopes in that. That is much less work, and enough for what is alike in both rigs.
    pub known: Option<VelocityCovariance>,
}

/// What the process force becomes in the random part of `ax` and `ay` of each, as [`bearing::response`](super::bearing)
/// linearises a rig, through the linear part of the output chain. A response ends where it has died away, after
/// `condition.samples` at most.
///
/// # Errors
///
/// As [`simulate`](super::simulate()), of each its own.
pub fn random_parts(asked: &[Asked]) -> Vec<Result<RandomPart, RigError>> {
    asked.par_iter().zip(states(asked)).map(|(of, states)| random_part(of, states)).collect()
}

impl Asked<'_> {
    /// The scatter that is known, where force laws are others in it.
    fn heeded(&self, plan: &Assembly) -> Option<VelocityCovariance> {
        self.known.filter(|_| plan.depends_on_velocity_noise)
    }

    /// The run along which it is linearised without more ado; nothing of one that is linearised otherwise, or refused.
    fn along(&self) -> Option<Along> {
        self.rig.check().ok()?;
        let plan = assemble(self.rig);
        let is_needed = !plan.forces.is_empty() && (self.known.is_some() || !plan.depends_on_velocity_noise);
        is_needed.then(|| Along::new(self.rig, &self.condition, self.heeded(&plan), LINEARISED_AT).ok())?
    }
}

/// States along those runs, side by side.
fn states(asked: &[Asked]) -> Vec<Option<Result<Vec<Visited>, RigError>>> {
    let (which, runs): (Vec<usize>, Vec<Along>) =
        asked.iter().enumerate().filter_map(|(n, of)| Some((n, of.along()?))).unzip();
    let mut states: Vec<_> = asked.iter().map(|_| None).collect();
    which.into_iter().zip(visited(runs)).for_each(|(n, visited)| states[n] = Some(visited));
    states
}

fn random_part(of: &Asked, states: Option<Result<Vec<Visited>, RigError>>) -> Result<RandomPart, RigError> {
    let Asked { rig, condition, .. } = of;
    rig.check()?;
    let plan = assemble(rig);
    let machine = &bearing_of(&plan.machine)?;
    let impulse = |tangent: &Tangent| {
        Linear::new(machine, tangent, condition.sample_rate_hz, 1).impulse(condition.samples, DECAYED, &[])
    };
    let mut impulses = match states {
        Some(states) => {
            let forces = assemble_in_noise(rig, of.heeded(&plan)).forces;
            vec![impulse(&bearing::along(machine, &forces, &states?))]
        }
        None if plan.depends_on_velocity_noise => in_scatter(rig, machine, condition, impulse)?,
        None => vec![impulse(&bearing::at_rest(machine, condition.load_n))],
    };
    let scatter = scatter(machine, condition, &impulses);
    let chain: Vec<_> = output_chain(plan).into_iter().filter(|(stage, _)| *stage <= Stage::Transducer).collect();
    let sensed = |(channel, mut signal, path_force): (&str, Vec<f64>, Vec<f64>)| {
        let at = Acquisition { channel, sample_rate_hz: condition.sample_rate_hz, preroll: 0, path_force: &path_force };
        // What the chain adds to nothing at all is no response.
        let rest = vec![0.0; signal.len()];
        let mut offset = rest.clone();
        for (_, alter) in &chain {
            alter(&at, &mut signal);
            alter(&Acquisition { path_force: &rest, ..at }, &mut offset);
        }
        signal.iter_mut().zip(offset).for_each(|(value, offset)| *value -= offset);
        signal
    };
    let responses = impulses.iter_mut().map(|impulse| {
        let [ax, ay, fx, fy] = std::mem::take(&mut impulse.signals);
        [("ax", ax, fx), ("ay", ay, fy)].map(sensed)
    });
    Ok(RandomPart { responses: responses.collect(), scatter })
}

/// Impulses at moments of a rig whose force laws are other laws in noise. Their slopes follow from the scatter, and that from
/// the slopes.
fn in_scatter(
    rig: &Rig,
    machine: &BearingRig,
    condition: &OperatingCondition,
    impulse: impl Fn(&Tangent) -> Impulse,
) -> Result<Vec<Impulse>, RigError> {
    let rate = condition.sample_rate_hz;
    let mut found = vec![impulse(&bearing::at_rest(machine, condition.load_n))];
    for (round, moments) in MOMENTS.into_iter().enumerate() {
        let now = Some(scatter(machine, condition, &found));
        // One run in, one result out.
        let visited = visited(vec![Along::new(rig, condition, now, condition.samples)?]).swap_remove(0)?;
        let few = subset(&visited);
        let tangent_in = |scatter: VelocityCovariance| {
            let plan = assemble_in_noise(rig, Some(scatter));
            (bearing::along(machine, &plan.forces, &few), plan.forces)
        };
        if round == 0 {
            for _ in 0..MEAN_ROUNDS {
                found = vec![impulse(&tangent_in(scatter(machine, condition, &found)).0)];
            }
        }
        let (tangent, forces) = tangent_in(scatter(machine, condition, &found));
        let (damping, steps) = bearing::damping_along(machine, &forces, &visited, rate);
        let linear = Linear::new(machine, &tangent.undamped(), rate, steps);
        let from = |n: usize| {
            let (before, after) = damping.split_at(n * damping.len() / moments);
            linear.impulse(condition.samples, DECAYED_AT_MOMENTS, after.iter().chain(before))
        };
        found = (0..moments).map(from).collect();
    }
    Ok(found)
}

/// Some hundred of visited states.
fn subset(visited: &[Visited]) -> Vec<Visited> {
    visited.iter().step_by((visited.len() / LINEARISED_AT).max(1)).copied().collect()
}

/// Whether a force law of the rig is another where noise scatters the state.
pub fn depends_on_velocity_noise(rig: &Rig) -> bool {
    assemble(rig).depends_on_velocity_noise
}

/// What all of the process force scatters the velocities by, the mean over moments.
fn scatter(machine: &BearingRig, condition: &OperatingCondition, impulses: &[Impulse]) -> VelocityCovariance {
    let power = 0.5 * machine.excitation.process_force_psd_n2_per_hz * condition.sample_rate_hz;
    let mut mean = [[0.0; DOFS]; DOFS];
    for impulse in impulses {
        let pairs = mean.iter_mut().flatten().zip(impulse.velocities.iter().flatten());
        pairs.for_each(|(sum, one)| *sum += power * one / impulses.len() as f64);
    }
    VelocityCovariance(mean)
}

/// A short run along which a rig is linearised: with its noise, or without where what that scatters is given.
struct Along {
    prepared: Prepared,
    kept: Arc<Mutex<Vec<Visited>>>,
}

impl Along {
    /// So many states of it are kept, those of all samples at most.
    fn new(
        rig: &Rig,
        condition: &OperatingCondition,
        scatter: Option<VelocityCovariance>,
        states: usize,
    ) -> Result<Self, RigError> {
        let samples = condition.samples.min((LINEARISED_OVER_S * condition.sample_rate_hz) as usize).max(1);
        let substeps = Some(fewest_substeps(rig, scatter, condition));
        let seeded = Start::seeded(LINEARISED_WITH);
        let settle_s = LINEARISED_AFTER_S.min(shortest_settling_s(rig));
        let start = Start { substeps, velocity_covariance: scatter, noise: scatter.is_none(), settle_s, ..seeded };
        let mut plan = assemble_in_noise(rig, scatter);
        let kept: Arc<Mutex<Vec<Visited>>> = Arc::default();
        let keep = Arc::clone(&kept);
        let interval_s = samples as f64 / condition.sample_rate_hz / states.min(samples) as f64;
        // What is looked at four times a step is no lock's to keep.
        let next = AtomicU64::new(0.0f64.to_bits());
        plan.force(move |at, q, v, _| {
            let due_s = f64::from_bits(next.load(Ordering::Relaxed));
            if at.time_s >= due_s
                && let Ok(mut keep) = keep.lock()
            {
                next.store((due_s + interval_s).to_bits(), Ordering::Relaxed);
                keep.push((*at, *q, *v));
            }
        });
        let machine = bearing_of(&plan.machine)?;
        let condition = OperatingCondition { samples, ..*condition };
        Ok(Self { prepared: Prepared::new(&machine, &mut plan, &condition, &start), kept })
    }
}

/// States of runs, side by side.
fn visited(runs: Vec<Along>) -> Vec<Result<Vec<Visited>, RigError>> {
    let (prepared, kept): (Vec<_>, Vec<_>) = runs.into_iter().map(|run| (run.prepared, run.kept)).unzip();
    side_by_side(prepared, |n, _, _| {
        let states = kept[n].lock().map(|mut kept| std::mem::take(&mut *kept)).unwrap_or_default();
        match states.iter().find(|(_, q, v)| q.iter().chain(v).any(|x| !x.is_finite())) {
            Some((at, ..)) => Err(RigError::Diverged { time_s: at.time_s }),
            None => Ok(states),
        }
    })
}
