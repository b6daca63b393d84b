//! From a rig and an operating condition to a recording.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use rayon::prelude::*;

use super::{
    bearing::{self, Impulse, Linear, Prepared, Signals, Tangent, Turning, Visited},
    config::{BearingRig, Model, Rig, Support},
    effect::Values,
    error::RigError,
    noise,
    plan::{Acquisition, DOFS, Plan, Scatter, Signal, Stage},
};
use crate::recording::{Channel, Recording, Source};

/// Under what the machine runs, and for how long it is recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatingCondition {
    /// Shaft speed, revolutions per second.
    pub shaft_hz: f64,
    /// F_load, N.
    pub load_n: f64,
    /// Samples per second.
    pub sample_rate_hz: f64,
    /// Samples.
    pub samples: usize,
}

impl OperatingCondition {
    /// Whether a time, s, is in the recording and at least `edge` samples from its ends.
    pub fn is_within(&self, time_s: f64, edge: usize) -> bool {
        let sample = time_s * self.sample_rate_hz;
        sample >= edge as f64 && sample + edge as f64 <= self.samples as f64
    }
}

/// What is not known about a run: where it starts, and its random parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// φ₀ at t = 0, rad: angle of ball 0.
    pub cage_angle0_rad: f64,
    /// ψ at t = 0, rad.
    pub shaft_angle0_rad: f64,
    /// Time that the rig runs from rest before t = 0, s.
    pub settle_s: f64,
    /// Seed of process force and sensor noise.
    pub seed: u64,
    /// Whether there is process force and sensor noise at all.
    pub noise: bool,
    /// Steps for each sample; `None` chooses them by the stiffest contact and the fastest effect.
    pub substeps: Option<usize>,
    /// What a process force that the run leaves out would add to its state: the run is then the mean over it, as far as the
    /// force laws that know of it go.
    pub scatter: Option<Scatter>,
}

impl Start {
    /// Settling time of [`Start::seeded`] and [`Start::silent`], s: the slowest mode of the reference rigs has decayed
    /// by e⁻³⁵.
    pub const SETTLE_S: f64 = 0.4;

    /// Random angles and noise, all by one seed.
    pub fn seeded(seed: u64) -> Self {
        let [cage_angle0_rad, shaft_angle0_rad] = noise::angles(seed);
        Self {
            cage_angle0_rad,
            shaft_angle0_rad,
            seed,
            noise: true,
            settle_s: Self::SETTLE_S,
            substeps: None,
            scatter: None,
        }
    }

    /// Random angles and noise for one run of a series: all runs differ, and so do those of another seed.
    pub fn of_series(seed: u64, index: usize) -> Self {
        Self::seeded(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(index as u64))
    }

    /// These angles, and nothing random.
    pub fn silent(cage_angle0_rad: f64, shaft_angle0_rad: f64) -> Self {
        Self { cage_angle0_rad, shaft_angle0_rad, noise: false, ..Self::seeded(0) }
    }
}

/// One run of [`simulate_many`].
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// The rig, a bearing's.
    pub rig: &'a Rig,
    /// Its operating condition.
    pub condition: OperatingCondition,
    /// Its start.
    pub start: Start,
}

/// Simulates one recording: channels `ax` and `ay` in m/s² where the rig's sensors sit, and `tacho`, 1 at each turn's
/// first sample. Same rig, condition and start give the same bits.
///
/// # Errors
///
/// A rig that [`Rig::check`] refuses or that is not a bearing's, an impossible condition, a run that diverges.
pub fn simulate(rig: &Rig, condition: &OperatingCondition, start: &Start) -> Result<Recording, RigError> {
    simulate_altered(rig, condition, start, &|_| ())
}

/// As [`simulate`], of a machine that is altered beyond what its rig says: for what the vocabulary has no name for.
///
/// # Errors
///
/// As [`simulate`].
pub fn simulate_altered(
    rig: &Rig,
    condition: &OperatingCondition,
    start: &Start,
    alter: &dyn Fn(&mut Plan),
) -> Result<Recording, RigError> {
    let run = Run { rig, condition: *condition, start: *start };
    let (prepared, chain) = prepare(&run, alter)?;
    // One run in, one result out.
    let signals = bearing::integrate(std::slice::from_ref(&prepared)).swap_remove(0);
    finish(&run, &prepared, &chain, signals)
}

/// Simulates many runs side by side, on all threads of the current rayon pool; runs of equal counts (balls, samples,
/// steps) share vectors. Each gives the same bits as [`simulate`] alone.
///
/// # Errors
///
/// As [`simulate`], for the first run that fails.
pub fn simulate_many(runs: &[Run]) -> Result<Vec<Recording>, RigError> {
    simulate_all(runs)?.into_iter().collect()
}

/// As [`simulate_many`], with each run's own failure to diverge or not: a search may step where no rig can stand.
///
/// # Errors
///
/// A rig or condition that is refused before anything runs.
pub fn simulate_all(runs: &[Run]) -> Result<Vec<Result<Recording, RigError>>, RigError> {
    let mut chains = Vec::with_capacity(runs.len());
    let mut groups: BTreeMap<_, (Vec<usize>, Vec<Prepared>)> = BTreeMap::new();
    for (index, run) in runs.iter().enumerate() {
        let (prepared, chain) = prepare(run, &|_| ())?;
        let (indices, group) = groups.entry(prepared.shape()).or_default();
        indices.push(index);
        group.push(prepared);
        chains.push(chain);
    }
    let width = bearing::runs_per_vector();
    let pieces: Vec<_> =
        groups.values().flat_map(|(indices, group)| indices.chunks(width).zip(group.chunks(width))).collect();
    let mut results: Vec<_> = pieces
        .into_par_iter()
        .flat_map_iter(|(indices, group)| {
            let signals = bearing::integrate(group);
            let finished =
                indices.iter().zip(group).zip(signals).map(|((&index, prepared), signals)| {
                    (index, finish(&runs[index], prepared, &chains[index], signals))
                });
            finished.collect::<Vec<_>>()
        })
        .collect();
    results.sort_by_key(|(index, _)| *index);
    Ok(results.into_iter().map(|(_, result)| result).collect())
}

/// What the process force does to a rig.
pub struct RandomPart {
    /// Responses of `ax` and `ay` to 1 N during one sample, m/s², at moments that stand for all: their powers' mean counts.
    pub responses: Vec<[Vec<f64>; 2]>,
    /// What all of the force adds to the state.
    pub scatter: Scatter,
}

/// What the process force becomes in the random part of `ax` and `ay`, as [`bearing::response`](super::bearing) linearises
/// the rig, through the linear part of the output chain. The response ends where it has died away, after
/// `condition.samples` at most. Where the scatter is `known` of a rig that is nearly the same, force laws that are others in
/// noise count by the mean of their slopes in that: a tenth of the work, and enough for what is like in both rigs.
///
/// # Errors
///
/// As [`simulate`].
pub fn random_part(rig: &Rig, condition: &OperatingCondition, known: Option<Scatter>) -> Result<RandomPart, RigError> {
    rig.check()?;
    let plan = plan_of(rig);
    let machine = &bearing_of(&plan.machine)?;
    let impulse = |tangent: &Tangent| {
        Linear::new(machine, tangent, condition.sample_rate_hz).impulse(condition.samples, DECAYED, &[])
    };
    let mut impulses = if plan.forces.is_empty() {
        vec![impulse(&bearing::at_rest(machine, condition.load_n))]
    } else if let (true, Some(scatter)) = (plan.heeds_scatter, known) {
        let plan = plan_in(rig, Some(scatter));
        vec![impulse(&bearing::along(machine, &plan.forces, &few(&visited(rig, condition, known)?)))]
    } else if plan.heeds_scatter {
        in_scatter(rig, machine, condition, impulse)?
    } else {
        vec![impulse(&bearing::along(machine, &plan.forces, &visited(rig, condition, None)?))]
    };
    let scatter = scatter(machine, condition, &impulses);
    let chain: Vec<_> = in_order(plan).into_iter().filter(|(stage, _)| *stage <= Stage::Transducer).collect();
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
        let visited = visited(rig, condition, Some(scatter(machine, condition, &found)))?;
        let few = few(&visited);
        let tangent_in = |scatter: Scatter| {
            let plan = plan_in(rig, Some(scatter));
            (bearing::along(machine, &plan.forces, &few), plan.forces)
        };
        if round == 0 {
            for _ in 0..MEAN_ROUNDS {
                found = vec![impulse(&tangent_in(scatter(machine, condition, &found)).0)];
            }
        }
        let (tangent, forces) = tangent_in(scatter(machine, condition, &found));
        let damping = bearing::damping_along(machine, &forces, &visited, rate);
        let linear = Linear::new(machine, &tangent.undamped(), rate);
        let from = |n: usize| {
            let (before, after) = damping.split_at(n * damping.len() / moments);
            linear.impulse(condition.samples, DECAYED_AT_MOMENTS, after.iter().chain(before))
        };
        found = (0..moments).map(from).collect();
    }
    Ok(found)
}

/// Some hundred of visited states.
fn few(visited: &[Visited]) -> Vec<Visited> {
    visited.iter().step_by((visited.len() / LINEARISED_AT).max(1)).copied().collect()
}

/// Whether a force law of the rig is another where noise scatters the state.
pub fn heeds_scatter(rig: &Rig) -> bool {
    plan_of(rig).heeds_scatter
}

/// What all of the process force scatters the velocities by, at the mean over moments.
fn scatter(machine: &BearingRig, condition: &OperatingCondition, impulses: &[Impulse]) -> Scatter {
    let power = 0.5 * machine.excitation.process_force_psd_n2_per_hz * condition.sample_rate_hz;
    let mut mean = [[0.0; DOFS]; DOFS];
    for impulse in impulses {
        let pairs = mean.iter_mut().flatten().zip(impulse.velocities.iter().flatten());
        pairs.for_each(|(sum, one)| *sum += power * one / impulses.len() as f64);
    }
    Scatter(mean)
}

/// A response ends where it has come down to this share of its greatest, one of many earlier.
const DECAYED: f64 = 1e-9;
const DECAYED_AT_MOMENTS: f64 = 1e-4;
/// Rounds from scatter to slopes and back along one run by its mean slopes, where heavy friction halves the logarithm of what
/// is wrong with the scatter each time; then moments of a run, twice.
const MEAN_ROUNDS: usize = 4;
const MOMENTS: [usize; 2] = [8, 16];

/// Steps for each sample that are enough where errors of 1e-5 m/s² do not matter, as beside any real noise: the linear
/// modes are exact at any step, the contact follows at one step a sample, and only an effect can be too fast for that.
pub fn fewest_substeps(rig: &Rig, scatter: Option<Scatter>, sample_rate_hz: f64) -> usize {
    let plan = plan_in(rig, scatter);
    (plan.rate_rad_per_s / (sample_rate_hz * FASTEST_PER_STEP)).ceil().clamp(1.0, MOST_SUBSTEPS) as usize
}

/// Time from rest that is enough where what is left of the start may be a ten-thousandth of the noise: some time constants
/// of the mass that is damped least.
pub fn shortest_settling_s(rig: &Rig) -> f64 {
    let Some(rig) = rig.bearing() else { return Start::SETTLE_S };
    let rate = |s: &Support| 0.5 * s.damping_n_s_per_m / s.mass_kg;
    let least = rate(&rig.inner).min(rate(&rig.outer)).min(rate(&rig.resonator));
    (TIME_CONSTANTS / least.max(1e-9)).clamp(0.02, Start::SETTLE_S)
}

/// e⁻¹² is 6e-6.
const TIME_CONSTANTS: f64 = 12.0;

/// What is faster than so many steps a sample follow is not seen at the sample rate: a search that makes an impact ever
/// shorter must not take ever longer.
const MOST_SUBSTEPS: f64 = 8.0;

/// Rate of an effect times step that an explicit method of order four follows, inside its stability limit of 2.7.
const FASTEST_PER_STEP: f64 = 1.2;

/// States of a short run, where the rig is linearised: some hundred of one with its noise; where what that scatters is given,
/// every sample's of one without.
fn visited(rig: &Rig, condition: &OperatingCondition, scatter: Option<Scatter>) -> Result<Vec<Visited>, RigError> {
    let samples = condition.samples.min((LINEARISED_OVER_S * condition.sample_rate_hz) as usize).max(1);
    let substeps = Some(fewest_substeps(rig, scatter, condition.sample_rate_hz));
    let seeded = Start::seeded(LINEARISED_WITH);
    let settle_s = LINEARISED_AFTER_S.min(shortest_settling_s(rig));
    let start = Start { substeps, scatter, noise: scatter.is_none(), settle_s, ..seeded };
    let run = Run { rig, condition: OperatingCondition { samples, ..*condition }, start };
    let mut plan = plan_in(rig, scatter);
    let kept: Arc<Mutex<Vec<Visited>>> = Arc::default();
    let keep = Arc::clone(&kept);
    let count = if scatter.is_some() { samples } else { LINEARISED_AT };
    let interval_s = samples as f64 / condition.sample_rate_hz / count as f64;
    let next = Mutex::new(0.0);
    plan.force(move |at, q, v, _| {
        if let (Ok(mut next), Ok(mut keep)) = (next.lock(), keep.lock())
            && at.time_s >= *next
        {
            *next += interval_s;
            keep.push((*at, *q, *v));
        }
    });
    let machine = bearing_of(&plan.machine)?;
    let prepared = Prepared::new(&machine, &mut plan, &run.condition, &run.start);
    bearing::integrate(&[prepared]);
    let visited = kept.lock().map(|mut kept| std::mem::take(&mut *kept)).unwrap_or_default();
    match visited.iter().find(|(_, q, v)| q.iter().chain(v).any(|x| !x.is_finite())) {
        Some((at, ..)) => Err(RigError::Diverged { time_s: at.time_s }),
        None => Ok(visited),
    }
}

/// A transmission path starts this long before the recording: until an impulse is down to this share.
const SETTLED: f64 = 1e-3;
const LONGEST_SETTLING_S: f64 = 0.2;

/// The rig is linearised over this long, after this long, at so many states, with the noise of this seed.
const LINEARISED_OVER_S: f64 = 0.15;
const LINEARISED_AFTER_S: f64 = 0.2;
const LINEARISED_AT: usize = 300;
const LINEARISED_WITH: u64 = 1;

/// What a run's signals pass through.
struct Chain {
    noise_std: f64,
    locations: [&'static str; 2],
    signals: Vec<(Stage, Signal)>,
}

fn prepare(run: &Run, alter: &dyn Fn(&mut Plan)) -> Result<(Prepared, Chain), RigError> {
    let OperatingCondition { shaft_hz, load_n, sample_rate_hz, samples } = run.condition;
    let refuse =
        |field, found: f64, expected| Err(RigError::BadCondition { field, found: found.to_string(), expected });
    if !(sample_rate_hz.is_finite() && sample_rate_hz > 0.0) {
        return refuse("sample_rate_hz", sample_rate_hz, "a positive number of Hz");
    }
    if !(shaft_hz.is_finite() && shaft_hz >= 0.0) {
        return refuse("shaft_hz", shaft_hz, "a number of Hz, not negative");
    }
    if !load_n.is_finite() {
        return refuse("load_n", load_n, "a number of N");
    }
    if samples == 0 {
        return refuse("samples", 0.0, "at least 1");
    }
    if !(run.start.settle_s.is_finite() && run.start.settle_s >= 0.0) {
        return refuse("settle_s", run.start.settle_s, "a number of s, not negative");
    }
    if run.start.substeps == Some(0) {
        return refuse("substeps", 0.0, "at least 1");
    }
    run.rig.check()?;
    if let Some(path) = run.rig.paths.iter().find(|path| (path.sample_rate_hz / sample_rate_hz - 1.0).abs() > 1e-6) {
        return Err(RigError::BadCondition {
            field: "sample_rate_hz",
            found: format!("{sample_rate_hz} and a path of the rig for {}", path.sample_rate_hz),
            expected: "one rate; the path between rig and sensor was identified at it",
        });
    }
    let mut plan = plan_in(run.rig, run.start.scatter);
    alter(&mut plan);
    let rig = bearing_of(&plan.machine)?;
    let prepared = Prepared::new(&rig, &mut plan, &run.condition, &run.start);
    let chain = chain(&rig, &run.start, plan);
    Ok((prepared, chain))
}

/// The machine of a model, a bearing's.
///
/// # Errors
///
/// That it is another kind's.
pub fn bearing_of(model: &Model) -> Result<BearingRig, RigError> {
    match model {
        Model::Bearing(rig) => Ok(rig.clone()),
        Model::Sdof(_) => Err(RigError::BadCondition {
            field: "rig.kind",
            found: "\"sdof\"".into(),
            expected: "\"bearing-5dof\"; an sdof rig is driven by a recorded input",
        }),
    }
}

fn chain(rig: &BearingRig, start: &Start, plan: Plan) -> Chain {
    let noise_std = if start.noise { rig.sensor.noise_std_m_per_s2 } else { 0.0 };
    let locations = [rig.sensor.horizontal.name(), rig.sensor.vertical.name()];
    Chain { noise_std, locations, signals: in_order(plan) }
}

/// The output chain from machine to file.
pub(super) fn in_order(plan: Plan) -> Vec<(Stage, Signal)> {
    let mut signals = plan.signals;
    signals.sort_by_key(|(stage, _)| *stage);
    signals
}

/// The rig's machine with its effects put in.
pub(crate) fn plan_of(rig: &Rig) -> Plan {
    plan_in(rig, None)
}

/// The same where noise that is left out scatters the state.
fn plan_in(rig: &Rig, scatter: Option<Scatter>) -> Plan {
    let mut plan = Plan { scatter, ..Plan::new(rig.model.clone()) };
    for entry in &rig.effects {
        if let Some(values) = Values::new(entry, rig.model.kind()) {
            (values.definition().apply)(&values, &mut plan);
        }
    }
    for path in &rig.paths {
        let settle = path.settles_within(SETTLED, (path.sample_rate_hz * LONGEST_SETTLING_S) as usize);
        plan.preroll_s = plan.preroll_s.max(settle as f64 / path.sample_rate_hz);
        let path = path.clone();
        plan.signal(Stage::Path, move |at, signal| {
            if at.channel == path.channel {
                path.filter(signal);
            }
        });
    }
    plan
}

fn finish(run: &Run, prepared: &Prepared, chain: &Chain, signals: Signals) -> Result<Recording, RigError> {
    let OperatingCondition { shaft_hz, load_n, sample_rate_hz, samples } = run.condition;
    let preroll = prepared.preroll;
    if let Some(bad) = signals.iter().filter_map(|s| s.iter().position(|v| !v.is_finite())).min() {
        return Err(RigError::Diverged { time_s: (bad as f64 - preroll as f64) / sample_rate_hz });
    }
    let mut channels = Vec::with_capacity(3);
    let [ax, ay, fx, fy] = signals;
    for (index, (name, mut signal, path_force)) in [("ax", ax, &fx), ("ay", ay, &fy)].into_iter().enumerate() {
        let at = Acquisition { channel: name, sample_rate_hz, preroll, path_force };
        let (sensor, rest): (Vec<_>, Vec<_>) = chain.signals.iter().partition(|(stage, _)| *stage <= Stage::Transducer);
        for (_, alter) in sensor {
            alter(&at, &mut signal);
        }
        if chain.noise_std > 0.0 {
            let seed_of = noise::SENSOR + index as u64;
            let noise = noise::white(run.start.seed, seed_of, chain.noise_std, signal.len());
            // From the first sample on, then before it, so that a longer preroll does not change what is recorded.
            let in_time = signal.len() - preroll;
            let (before, recorded) = signal.split_at_mut(preroll);
            recorded.iter_mut().zip(&noise).for_each(|(value, noise)| *value += noise);
            before.iter_mut().zip(&noise[in_time..]).for_each(|(value, noise)| *value += noise);
        }
        for (_, alter) in rest {
            alter(&at, &mut signal);
        }
        signal.drain(..preroll);
        signal.truncate(samples);
        channels.push(Channel { name: name.into(), location: Some(chain.locations[index].into()), samples: signal });
    }
    let mut tacho = tachometer(&prepared.turning, sample_rate_hz, prepared.samples);
    for (_, alter) in chain.signals.iter().filter(|(stage, _)| *stage == Stage::Logger) {
        alter(&Acquisition { channel: "tacho", sample_rate_hz, preroll: 0, path_force: &[] }, &mut tacho);
    }
    tacho.truncate(samples);
    channels.push(Channel { name: "tacho".into(), location: None, samples: tacho });
    Ok(Recording {
        source: Source::default(),
        channels,
        sample_rate_hz,
        shaft_hz: Some(shaft_hz),
        load_n: Some(load_n),
        ..Recording::default()
    })
}

/// 1 at each turn's first sample.
fn tachometer(turning: &Turning, sample_rate_hz: f64, samples: usize) -> Vec<f64> {
    let turn = |sample: f64| (turning.shaft(sample / sample_rate_hz) / std::f64::consts::TAU).floor();
    let mut before = turn(-1.0);
    let mark = |sample| {
        let now = turn(sample as f64);
        let first = f64::from(u8::from(now != before));
        before = now;
        first
    };
    (0..samples).map(mark).collect()
}
