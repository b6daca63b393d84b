//! From a rig and an operating condition to a recording.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::{
    assembly::{Acquisition, Assembly, Signal, Stage},
    bearing::{self, Prepared, Signals, Turning, contact_rad_per_s},
    condition::{OperatingCondition, Start},
    config::{BearingRig, Machine, Rig, Support},
    effect::Values,
    error::RigError,
    noise,
    settings::IntegrationSettings,
    state::VelocityCovariance,
};
use crate::recording::{Channel, Recording, Source};

const SETTINGS: IntegrationSettings = IntegrationSettings::DEFAULT;

/// One run of [`simulate_many`].
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// The rig, a bearing's.
    pub rig: &'a Rig,
    /// Operating condition.
    pub condition: OperatingCondition,
    /// Start of the run.
    pub start: Start,
}

/// Simulates one recording, theory (28) to (41): channels `ax` and `ay` in m/s² where the rig's sensors sit, and `tacho`,
/// 1 at each turn's first sample. Same rig, condition and start give the same bits.
///
/// # Errors
///
/// A rig that [`Rig::check`] refuses or that is not a bearing's, an impossible condition, a run that diverges.
///
/// # Examples
///
/// ```
/// use ballrace::rig::{OperatingCondition, Rig, Start, simulate};
///
/// let rig = Rig::parse(include_str!("../../benches/rig.toml"), "rig.toml".as_ref())?;
/// let condition = OperatingCondition { shaft_hz: 30.0, load_n: 500.0, sample_rate_hz: 25_600.0, samples: 1000 };
/// let recording = simulate(&rig, &condition, &Start::seeded(1))?;
/// assert_eq!(recording.channel("ay").unwrap().samples.len(), 1000);
/// # Ok::<(), ballrace::rig::RigError>(())
/// ```
pub fn simulate(rig: &Rig, condition: &OperatingCondition, start: &Start) -> Result<Recording, RigError> {
    simulate_altered(rig, condition, start, &|_| ())
}

/// Simulates one recording as [`simulate`], of an assembly altered by `alter`: for effects outside the vocabulary.
///
/// # Errors
///
/// As [`simulate`].
pub fn simulate_altered(
    rig: &Rig,
    condition: &OperatingCondition,
    start: &Start,
    alter: &dyn Fn(&mut Assembly),
) -> Result<Recording, RigError> {
    let mut run = Run { rig, condition: *condition, start: *start };
    loop {
        let (prepared, chain) = prepare(&run, alter)?;
        // One run in, one result out.
        let signals = bearing::integrate(std::slice::from_ref(&prepared)).swap_remove(0);
        match finish(&run, &prepared, &chain, signals) {
            // A force may be stiffer at the start than where its steps are counted for.
            Err(RigError::Diverged { .. })
                if start.substeps.is_none() && prepared.substeps < SETTINGS.most_finer_steps =>
            {
                run.start.substeps = Some(SETTINGS.finer * prepared.substeps);
            }
            ended => return ended,
        }
    }
}

/// Simulates many runs side by side, on all threads of the current rayon pool; runs of equal counts (balls, samples,
/// steps) share vectors. Each gives the same bits as [`simulate`] alone.
///
/// # Errors
///
/// As [`simulate`], for the first run that fails.
pub fn simulate_many(runs: &[Run]) -> Result<Vec<Recording>, RigError> {
    let ended = |(made, run): (Result<Recording, RigError>, &Run)| match made {
        Err(RigError::Diverged { .. }) => simulate(run.rig, &run.condition, &run.start),
        other => other,
    };
    simulate_all(runs)?.into_iter().zip(runs).map(ended).collect()
}

/// Simulates as [`simulate_many`], with a result of its own for each run that diverges: a search may step to an impossible
/// rig.
///
/// # Errors
///
/// A rig or condition that is refused before anything runs.
pub fn simulate_all(runs: &[Run]) -> Result<Vec<Result<Recording, RigError>>, RigError> {
    let (prepared, chains): (Vec<_>, Vec<_>) =
        runs.iter().map(|run| prepare(run, &|_| ())).collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
    Ok(side_by_side(prepared, |n, prepared, signals| finish(&runs[n], prepared, &chains[n], signals)))
}

/// Integrates runs, those of one shape side by side, and passes each with its index to `end` in the same thread; results
/// in the runs' order.
pub(super) fn side_by_side<T: Send>(
    runs: Vec<Prepared>,
    end: impl Fn(usize, &Prepared, Signals) -> T + Send + Sync,
) -> Vec<T> {
    let mut groups: BTreeMap<_, (Vec<usize>, Vec<Prepared>)> = BTreeMap::new();
    for (index, run) in runs.into_iter().enumerate() {
        let (indices, group) = groups.entry(run.shape()).or_default();
        indices.push(index);
        group.push(run);
    }
    let width = bearing::runs_per_vector();
    let pieces: Vec<_> =
        groups.values().flat_map(|(indices, group)| indices.chunks(width).zip(group.chunks(width))).collect();
    let mut results: Vec<_> = pieces
        .into_par_iter()
        .flat_map_iter(|(indices, group)| {
            let signals = bearing::integrate(group);
            let ended = indices.iter().zip(group).zip(signals);
            ended.map(|((&index, run), signals)| (index, end(index, run, signals))).collect::<Vec<_>>()
        })
        .collect();
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// Steps a sample for errors up to 1e-5 m/s², far below real noise (after theory (41)): linear modes are exact at any
/// step, the contact of most bearings follows at one step a sample, only a stiff one or an effect can be too fast for that.
pub fn fewest_substeps(rig: &Rig, scatter: Option<VelocityCovariance>, condition: &OperatingCondition) -> usize {
    let mut assembly = assemble_in_noise(rig, scatter);
    let steps =
        |rate: f64, per_step: f64, most: f64| (rate / (condition.sample_rate_hz * per_step)).ceil().clamp(1.0, most);
    let turning = assembly.turning_rad_per_s(condition.shaft_hz);
    let contact = assembly.bearing().map_or(0.0, |machine| contact_rad_per_s(machine, condition));
    let (most, most_turning) = (SETTINGS.coarse_max_steps, SETTINGS.coarse_max_turning_steps);
    let effect = SETTINGS.coarse_effect_rate_per_step;
    let least = steps(contact, SETTINGS.coarse_contact_rate_per_step, most);
    least.max(steps(assembly.rate_rad_per_s, effect, most)).max(steps(turning, effect, most_turning)) as usize
}

/// Settling time after which the transient of the start is below a ten-thousandth of the noise, s: some time constants of
/// the mass that is damped least.
pub fn shortest_settling_s(rig: &Rig) -> f64 {
    let Some(rig) = rig.bearing() else { return Start::SETTLE_S };
    let rate = |s: &Support| 0.5 * s.damping_n_s_per_m / s.mass_kg;
    let least = rate(&rig.inner).min(rate(&rig.outer)).min(rate(&rig.resonator));
    (SETTINGS.settle_time_constants / least.max(1e-9)).clamp(SETTINGS.min_settle_s, Start::SETTLE_S)
}

/// Acquisition chain of a run, theory (38).
struct Chain {
    noise_std: f64,
    locations: [&'static str; 2],
    signals: Vec<(Stage, Signal)>,
}

fn prepare(run: &Run, alter: &dyn Fn(&mut Assembly)) -> Result<(Prepared, Chain), RigError> {
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
            expected: "the rate at which the path was identified",
        });
    }
    let mut assembly = assemble_in_noise(run.rig, run.start.velocity_covariance);
    alter(&mut assembly);
    let rig = bearing_under(&assembly, &run.condition)?;
    let prepared = Prepared::new(&rig, &mut assembly, &run.condition, &run.start);
    let chain = chain(&rig, &run.start, assembly);
    Ok((prepared, chain))
}

/// Bearing rig of a machine.
///
/// # Errors
///
/// A machine of another kind.
pub fn bearing_of(model: &Machine) -> Result<BearingRig, RigError> {
    match model {
        Machine::Bearing(rig) => Ok(rig.clone()),
        Machine::Sdof(_) => Err(RigError::BadCondition {
            field: "rig.kind",
            found: "\"sdof\"".into(),
            expected: "\"bearing-5dof\"; an sdof rig is driven by a recorded input",
        }),
    }
}

/// Bearing rig of an assembly under an operating condition, whose film of lubricant takes from the clearance: theory (111).
///
/// # Errors
///
/// A machine of another kind.
pub(super) fn bearing_under(assembly: &Assembly, condition: &OperatingCondition) -> Result<BearingRig, RigError> {
    let mut rig = bearing_of(&assembly.machine)?;
    if let Some(lubricant) = assembly.lubricant {
        let [inner, outer] = lubricant.thickness_m(&rig.bearing, condition.shaft_hz, condition.load_n);
        rig.bearing.radial_clearance_m -= inner + outer;
    }
    Ok(rig)
}

fn chain(rig: &BearingRig, start: &Start, assembly: Assembly) -> Chain {
    let noise_std = if start.noise { rig.sensor.noise_std_m_per_s2 } else { 0.0 };
    let locations = [rig.sensor.horizontal.name(), rig.sensor.vertical.name()];
    Chain { noise_std, locations, signals: output_chain(assembly) }
}

/// Output chain from machine to file.
pub(super) fn output_chain(assembly: Assembly) -> Vec<(Stage, Signal)> {
    let mut signals = assembly.signals;
    signals.sort_by_key(|(stage, _)| *stage);
    signals
}

/// Assembly of a rig with its effects.
pub(crate) fn assemble(rig: &Rig) -> Assembly {
    assemble_in_noise(rig, None)
}

/// Assembly of a rig whose force laws take their mean over left-out noise of covariance `scatter`.
pub(super) fn assemble_in_noise(rig: &Rig, scatter: Option<VelocityCovariance>) -> Assembly {
    let mut assembly = Assembly::new(rig.model.clone());
    assembly.velocity_covariance = scatter;
    for entry in &rig.effects {
        if let Some(values) = Values::new(entry, rig.model.kind()) {
            (values.definition().apply)(&values, &mut assembly);
        }
    }
    for path in &rig.paths {
        let longest = (path.sample_rate_hz * SETTINGS.max_path_preroll_s) as usize;
        let settle = path.settles_within(SETTINGS.path_decay, longest);
        assembly.preroll_s = assembly.preroll_s.max(settle as f64 / path.sample_rate_hz);
        let path = path.clone();
        assembly.signal(Stage::Path, move |at, signal| {
            if at.channel == path.channel {
                path.filter(signal);
            }
        });
    }
    assembly
}

/// Time from which the signals of a run are no numbers, s; `None` if they all are.
pub(super) fn diverged_at_s(signals: &Signals, prepared: &Prepared, sample_rate_hz: f64) -> Option<f64> {
    let first = signals.iter().filter_map(|signal| signal.iter().position(|v| !v.is_finite())).min();
    first.map(|bad| (bad as f64 - prepared.preroll as f64) / sample_rate_hz)
}

fn finish(run: &Run, prepared: &Prepared, chain: &Chain, signals: Signals) -> Result<Recording, RigError> {
    let OperatingCondition { shaft_hz, load_n, sample_rate_hz, samples } = run.condition;
    let preroll = prepared.preroll;
    if let Some(time_s) = diverged_at_s(&signals, prepared, sample_rate_hz) {
        return Err(RigError::Diverged { time_s });
    }
    let mut channels = Vec::with_capacity(3);
    let [ax, ay, fx, fy] = signals;
    let channel = [("ax", [&ax, &ay], [&fx, &fy]), ("ay", [&ay, &ax], [&fy, &fx])];
    for (index, (name, [along, across], [path_force, across_force])) in channel.into_iter().enumerate() {
        let at = Acquisition { channel: name, sample_rate_hz, preroll, path_force, across_force, across };
        let mut signal = along.clone();
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
        alter(
            &Acquisition {
                channel: "tacho",
                sample_rate_hz,
                preroll: 0,
                path_force: &[],
                across_force: &[],
                across: &[],
            },
            &mut tacho,
        );
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

/// Tachometer signal: 1 at each turn's first sample.
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
