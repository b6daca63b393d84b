//! From recordings to a result: acquire, split, fit the nominal rig, search, validate.

use std::collections::BTreeMap;

use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;

use super::events::{Event, events};
use super::fit::{Data, Known, Model, Point};
use super::lack::lack;
use super::observation::Observation;
use super::search::{Brief, Candidate, candidates};
use super::settings::GateSettings;
use super::terms::term;
use super::text;
use crate::diagnose::acquisition::{Acquired, Fault};
use crate::diagnose::result::{
    Aspect, Cause, Diagnosis, DiagnosisResult, Fitted, HeldOut, Nuisance, Parameter, Rejected, SCHEMA, Term, Test,
    Verdict,
};
use crate::diagnose::{DiagnoseError, Task, evidence, locate, shown};
use crate::identify::calibrate::split::Split;
use crate::identify::likelihood::coordinate::Coordinate;
use crate::identify::likelihood::observed::{CHANNELS, Observed};
use crate::recording::Recording;
use crate::rig::config::{RigKey, RigKind};
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::{EffectEntry, OperatingCondition, Rig, RigError, Run, Start, simulate_many};
use crate::signal::kinematics::Orders;
use crate::signal::transform::{forward, inverse_plan};
use crate::stats::significance::Z975;

const GATE: GateSettings = GateSettings::DEFAULT;
/// Steps of the nominal fit and of a fit to held-out recordings.
const STEPS: [usize; 2] = [10, 4];

/// Cause that passed the gate.
struct Accepted<'d, 'a> {
    candidate: Candidate<'d, 'a>,
    held_out: f64,
    probability: f64,
    rivals: Vec<Candidate<'d, 'a>>,
    /// Index of the effect in the rig.
    effect: usize,
}

/// Diagnoses recordings of a bearing rig of known structure; `rig` is calibrated to the baseline.
///
/// # Errors
/// Recordings without acceleration or speed; a rig that cannot run.
pub fn diagnose(task: &Task, rig: &Rig, progress: &dyn Fn(&str)) -> Result<DiagnosisResult, DiagnoseError> {
    let machine = rig.bearing().ok_or(DiagnoseError::NotBearing { found: rig.model.kind().name() })?;
    let orders = machine.bearing.geometry().orders();
    let acquired = Acquired::detect(rig, task.recordings)?;
    let split = Split::new(&acquired.recordings);
    let observe = |recordings: &[Recording]| -> Result<Vec<Observation>, DiagnoseError> {
        Ok(Observed::from_recordings(recordings)?.iter().map(Observation::new).collect())
    };
    let (whole, held_whole) = (observe(&split.fitted)?, observe(&split.held_out)?);
    progress("searching for events");
    let event = event(rig, &whole, &held_whole, orders)?;
    let fitted = without(&whole, event.as_ref(), 0);
    let held = without(&held_whole, event.as_ref(), whole.len());
    progress("fitting the nominal rig");
    let data = Data::new(&fitted, orders);
    let nominal = nominal(rig, &data);
    let null = nominal.search(nominal.start(None)?, STEPS[0])?;
    let held_data = Data::new(&held, orders);
    let brief = Brief::new(&fitted);
    let before = lack(&data, &null);
    let before_held = judge(&held_data, &nominal, &null)?;
    let held_lack = lack(&held_data, &before_held);
    let mut accepted: Vec<Accepted> = Vec::new();
    let mut rejected: Vec<(Candidate, Option<f64>)> = Vec::new();
    let (mut model, mut point, mut held_point) = (nominal.clone(), null.clone(), before_held.clone());
    let mut corrections = 0;
    while accepted.len() < 2 {
        let is_second = !accepted.is_empty();
        progress(if is_second { "searching for a second cause" } else { "searching for a cause" });
        let left = lack(&data, &point).total();
        if is_second && left < GATE.second_lack {
            break;
        }
        let kinds: Vec<EffectKind> = model.rig.effects.iter().map(|e| e.kind).collect();
        let mut found = candidates(&model, &point, &brief, &kinds);
        if found.is_empty() {
            break;
        }
        // An error of the stated load comes before a cause that does the same.
        let close = |c: &Candidate| c.gain > found[0].gain - GATE.load_nats - GATE.load_share_of_gain * found[0].gain;
        let load = found.iter().position(|c| is_load(c, &fitted) && close(c)).unwrap_or(0);
        let best = found.remove(load);
        let judged = judge(&held_data, &best.model, &best.point)?;
        let held_out = held_point.objective() - judged.objective();
        let enough = GATE.gain.max(if is_second { GATE.second_share } else { GATE.first_share } * left);
        if best.gain < enough || held_out < GATE.held_out {
            rejected.push((best, None));
            rejected.extend(found.into_iter().map(|c| (c, None)));
            break;
        }
        (model, point, held_point) = (best.model.clone(), best.point.clone(), judged);
        if is_load(&best, &fitted) {
            corrections += 1;
            continue;
        }
        let probability = probability(&best, &found);
        let effect = model.rig.effects.len() - 1;
        accepted.push(Accepted { candidate: best, held_out, probability, rivals: found, effect });
    }
    let after = lack(&data, &point);
    let corrected = model.rig_at(&point.values)?;
    let with_event = event.as_ref().map_or_else(|| corrected.clone(), |e| corrected.clone().with_effect(e.mean()));
    let beyond = before.total() + held_lack.total() > GATE.lack * (fitted.len() + held.len()) as f64 / 4.0;
    let faults: Vec<&Fault> = acquired.faults().collect();
    let named = !accepted.is_empty() || event.is_some() || !faults.is_empty();
    let verdict = match (named, beyond) {
        (true, _) => Verdict::Mismatch,
        (false, true) => Verdict::Unexplained,
        (false, false) => Verdict::NoMismatch,
    };
    let (values, fitted_values) = estimates(&model, &point, nominal.coordinates.len())?;
    let mut causes: Vec<Cause> = faults.iter().map(|fault| fault_cause(fault)).collect();
    let names: Vec<String> = whole.iter().chain(&held_whole).map(|o| o.name.clone()).collect();
    causes.extend(event.as_ref().map(|e| event_cause(e, &names)));
    let own = accepted.iter().map(|a| cause(a, &corrected.effects[a.effect], &values));
    let mut own: Vec<Cause> = own.collect();
    let load = whole.iter().map(|o| o.condition.load_n.abs()).sum::<f64>() / whole.len().max(1) as f64;
    let mut missing: Vec<Term> = event.iter().filter_map(|e| term(&e.mean(), machine, load, [0.9, 1.1])).collect();
    missing.extend(accepted.iter().filter_map(|a| {
        let effect = &corrected.effects[a.effect];
        term(effect, machine, load, band(effect, a, &values))
    }));
    own.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    causes.extend(own);
    progress("simulating held-out recordings");
    let held_out = traces(&nominal, &null, &corrected, &point, event.as_ref(), &held_whole, whole.len(), task.seed)?;
    let (mut fit, mut left) = shown::fit(&held_out, split.describe(), task.seed);
    let gain: f64 = accepted.iter().map(|a| a.held_out).sum::<f64>() + event.as_ref().map_or(0.0, Event::gain);
    fit.p_value = if accepted.is_empty() && event.is_none() {
        faults.iter().map(|f| f.p_value).fold(if faults.is_empty() { 1.0 } else { 0.0 }, f64::max)
    } else {
        (-gain).exp().clamp(1e-300, 1.0)
    };
    left.share = if verdict == Verdict::NoMismatch { 0.0 } else { (after.total() / before.total().max(1.0)).min(1.0) };
    let mut tests = before.tests.clone();
    tests.extend(event.iter().flat_map(|e| event_tests(e, &names)));
    let tests = evidence::ranked(tests);
    let location = match verdict {
        Verdict::NoMismatch => Default::default(),
        _ => locate::locate(rig, &with_event, &tests),
    };
    let kept = accepted.first().map(|a| a.candidate.gain);
    let rivals = accepted.iter().flat_map(|a| a.rivals.iter().map(|r| (r, kept)));
    let mut others: Vec<Rejected> = Vec::new();
    for (candidate, kept) in rivals.chain(rejected.iter().map(|(c, k)| (c, *k))) {
        let name = candidate.kind.to_string();
        if !others.iter().any(|r| r.name == name) && !causes.iter().any(|c| c.name == name) {
            others.push(Rejected { name, why: text::rejected(candidate, kept) });
        }
    }
    let mut caveats = Vec::new();
    if verdict == Verdict::Unexplained {
        let each = before.nats.iter().chain(&held_lack.nats).zip(&names);
        let most = each.max_by(|a, b| a.0.total_cmp(b.0)).map_or(String::new(), |(_, name)| format!("in {name}"));
        caveats.push(text::unexplained(before.total() + held_lack.total(), &most));
    }
    if corrections > 0 {
        caveats.push(LOAD.into());
    }
    if task.recordings.iter().any(|recording| recording.load_n.is_none()) {
        caveats.push(NO_LOAD.into());
    }
    let mut corrected_rig = with_event;
    corrected_rig.effects.extend(faults.iter().rev().map(|fault| fault.effect.clone()));
    let diagnosis = Diagnosis {
        schema: SCHEMA.into(),
        verdict,
        causes,
        rejected: others,
        location,
        terms: missing,
        nuisance: nuisance(&data, &point),
        left,
        fit,
    };
    Ok(DiagnosisResult { diagnosis, rig: corrected_rig, held_out, tests, fitted: fitted_values, caveats })
}

/// Caveat of recordings without a stated load.
const NO_LOAD: &str = "No load is stated (load_n in recordings.toml); the rig was simulated with 0 N, so that what depends on \
                       the load is a guess.";

/// Caveat of a corrected load.
const LOAD: &str =
    "The stated loads are off by a few newtons; the corrected rig has a constant force for that, which is no cause.";

/// Whether a candidate is an error of the stated load.
fn is_load(candidate: &Candidate, observations: &[Observation]) -> bool {
    let load = observations.iter().map(|o| o.condition.load_n.abs()).sum::<f64>() / observations.len().max(1) as f64;
    let force = |rig: Rig| rig.effects.last().and_then(|e| e.number(ParameterKey::ForceN));
    let force = candidate.model.rig_at(&candidate.point.values).ok().and_then(force).unwrap_or_default();
    candidate.kind == EffectKind::ConstantForce && force.abs() < GATE.load_share * load
}

/// Nominal rig with its unknown numbers free.
fn nominal<'d, 'a>(rig: &Rig, data: &'d Data<'a>) -> Model<'d, 'a> {
    let coordinates: Vec<Coordinate> =
        rig.unknown_keys().into_iter().filter_map(|key| Coordinate::for_key(rig, key)).collect();
    let guess = |c: &Coordinate| c.to_coordinate(rig.get(c.key).unwrap_or_default());
    let guesses = coordinates.iter().map(guess).collect();
    Model { data, rig: rig.clone(), coordinates, guesses, known: Known::Nothing }
}

/// A fitted model on other recordings: only what each recording has of its own is fitted.
fn judge(data: &Data, model: &Model, point: &Point) -> Result<Point, RigError> {
    let rig = model.rig_at(&point.values)?;
    let other = Model { data, rig, coordinates: Vec::new(), guesses: Vec::new(), known: Known::Nothing };
    let count = data.observations.len();
    let jitter = point.jitter.iter().copied().max().unwrap_or(0);
    let from = Point { stretch: vec![0.0; count], jitter: vec![jitter; count], ..point.clone() };
    other.search(other.start(Some(&from))?, STEPS[1])
}

/// Event that happened once in some of the recordings, the held-out ones last.
fn event(
    rig: &Rig,
    fitted: &[Observation],
    held: &[Observation],
    orders: Orders,
) -> Result<Option<Event>, DiagnoseError> {
    let all: Vec<Observation> = fitted.iter().chain(held).cloned().collect();
    let data = Data::new(&all, orders);
    let nominal = nominal(rig, &data);
    let start = nominal.start(None)?;
    let point = if nominal.coordinates.is_empty() { start } else { nominal.search(start, STEPS[0])? };
    let noise: Vec<_> = point.predictions.iter().map(|p| p.noise.clone()).collect();
    let fitted_rig = nominal.rig_at(&point.values)?;
    let found = events(&fitted_rig, &all, &noise)?;
    Ok(found.into_iter().next())
}

/// Recordings without the stretch of an event: the longer part before or after it.
fn without(observations: &[Observation], event: Option<&Event>, first: usize) -> Vec<Observation> {
    let cut = |(n, o): (usize, &Observation)| match event.and_then(|e| e.each.get(first + n)).filter(|h| h.is_event()) {
        Some(happening) => o.apart_from(happening.time_s),
        None => o.clone(),
    };
    observations.iter().enumerate().map(cut).collect()
}

/// Probability of a candidate among its rivals.
fn probability(best: &Candidate, rivals: &[Candidate]) -> f64 {
    let [least, share] = GATE.rivalry;
    let scale = least + share * best.gain.max(0.0);
    let weight = |c: &Candidate| ((c.gain - best.gain) / scale).exp();
    let others: f64 = rivals.iter().filter(|c| c.kind != best.kind).map(weight).sum();
    (1.0 / (1.0 + others)).min(0.97)
}

/// Intervals of the parameters of effects, by the effect's index and key.
type Intervals = BTreeMap<(usize, ParameterKey), [f64; 2]>;

/// Interval of each coordinate: values of the effects by index and key, and the rig's unknown numbers.
fn estimates(model: &Model, point: &Point, unknown: usize) -> Result<(Intervals, Vec<Fitted>), DiagnoseError> {
    let (mut effects, mut numbers) = (BTreeMap::new(), Vec::new());
    let count = model.coordinates.len();
    if count == 0 {
        return Ok((effects, numbers));
    }
    let expansion = model.expand(point)?;
    let all = expansion.gradient.len();
    let inverse = Mat::from_fn(all, all, |a, b| expansion.information[(a, b)] + if a == b { 1e-9 } else { 0.0 })
        .partial_piv_lu()
        .inverse();
    for (a, coordinate) in model.coordinates.iter().enumerate() {
        // White's widening: where recordings disagree more than the information says.
        let pulls = expansion.pieces.iter().map(|g| (0..all).map(|b| inverse[(a, b)] * g[b]).sum::<f64>().powi(2));
        let variance = inverse[(a, a)].max(pulls.sum::<f64>()).max(0.0);
        let half = Z975 * variance.sqrt();
        let ends = [-half, half].map(|d| coordinate.to_value(point.values[a] + d));
        let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        if a < unknown {
            numbers.push((coordinate.key.to_string(), coordinate.to_value(point.values[a]), ends));
        } else if let RigKey::Effect { index, key } = coordinate.key {
            effects.insert((index, key), ends);
        }
    }
    Ok((effects, numbers))
}

/// Ends of the interval of an effect's strength over the strength.
fn band(effect: &EffectEntry, accepted: &Accepted, values: &Intervals) -> [f64; 2] {
    let strength = accepted.candidate.model.coordinates.iter().find_map(|c| match c.key {
        RigKey::Effect { index, key } if index == accepted.effect => Some(key),
        _ => None,
    });
    let ends = strength.and_then(|key| Some((values.get(&(accepted.effect, key))?, effect.number(key)?)));
    ends.filter(|(_, value)| *value != 0.0).map_or([1.0, 1.0], |(ends, value)| ends.map(|end| end / value))
}

fn stated(effect: &EffectEntry) -> BTreeMap<String, Parameter> {
    let vocabulary = effect.definition().parameters.iter().filter(|p| p.in_vocabulary());
    let keys: Vec<ParameterKey> =
        vocabulary.map(|p| p.key).chain([ParameterKey::Component, ParameterKey::Channel]).collect();
    let all = effect.parameters.iter().filter(|(key, _)| keys.contains(key));
    all.map(|(key, value)| (key.to_string(), value.into())).collect()
}

fn cause(accepted: &Accepted, effect: &EffectEntry, values: &Intervals) -> Cause {
    let parameters = stated(effect);
    let interval = |(key, ends): (&(usize, ParameterKey), &[f64; 2])| {
        (key.0 == accepted.effect && parameters.contains_key(key.1.name())).then(|| (key.1.to_string(), *ends))
    };
    Cause {
        name: effect.kind.to_string(),
        probability: accepted.probability,
        interval95: values.iter().filter_map(interval).collect(),
        parameters,
        evidence: text::evidence(accepted.candidate.gain, accepted.held_out, accepted.rivals.first()),
        equation: effect.equation(RigKind::Bearing5Dof),
    }
}

fn fault_cause(fault: &Fault) -> Cause {
    Cause {
        name: fault.effect.kind.to_string(),
        probability: 0.97,
        parameters: fault.effect.parameters.iter().map(|(key, value)| (key.to_string(), value.into())).collect(),
        interval95: BTreeMap::new(),
        evidence: fault.evidence.clone(),
        equation: fault.effect.equation(RigKind::Bearing5Dof),
    }
}

fn event_cause(event: &Event, names: &[String]) -> Cause {
    let effect = event.mean();
    let times: Vec<(String, f64)> =
        event.each.iter().zip(names).filter(|(h, _)| h.is_event()).map(|(h, n)| (n.clone(), h.time_s)).collect();
    let mut interval95 = BTreeMap::new();
    if let Some(time) = effect.number(ParameterKey::TimeS) {
        interval95.insert(ParameterKey::TimeS.to_string(), [time - 1e-3, time + 1e-3]);
    }
    Cause {
        name: effect.kind.to_string(),
        probability: 0.95,
        parameters: stated(&effect),
        interval95,
        evidence: text::event(&times, event.gain()),
        equation: effect.equation(RigKind::Bearing5Dof),
    }
}

fn event_tests<'e>(event: &'e Event, names: &'e [String]) -> impl Iterator<Item = Test> + 'e {
    event.each.iter().zip(names).filter(|(h, _)| h.is_event()).map(|(h, name)| Test {
        aspect: Aspect::Time,
        channel: "ay",
        at: Some([h.time_s - 2e-3, h.time_s + 5e-3]),
        what: format!("{name}, {:.4} s: response to a {}", h.time_s, event.effect.kind),
        z: (2.0 * h.gain).sqrt(),
        p_value: (1e5 * (-h.gain).exp()).min(1.0),
        q_value: 1.0,
    })
}

fn nuisance(data: &Data, point: &Point) -> Vec<Nuisance> {
    let of = |(n, o): (usize, &Observation)| Nuisance {
        recording: o.name.clone(),
        shaft_hz: Some(o.condition.shaft_hz),
        slip: Some(-point.stretch[n]),
        wander: None,
    };
    data.observations.iter().enumerate().map(of).collect()
}

/// Held-out recordings beside simulations of both rigs, each with the noise's colour.
#[allow(clippy::too_many_arguments)]
fn traces(
    nominal: &Model,
    null: &Point,
    corrected: &Rig,
    point: &Point,
    event: Option<&Event>,
    held: &[Observation],
    first: usize,
    seed: u64,
) -> Result<Vec<HeldOut>, DiagnoseError> {
    let before = nominal.rig_at(&null.values)?;
    let mut out = Vec::new();
    for (n, o) in held.iter().enumerate() {
        let after = match event.and_then(|e| e.effect_in(first + n)) {
            Some(effect) => corrected.clone().with_effect(effect),
            None => corrected.clone(),
        };
        let start = Start { cage_angle0_rad: 0.4, shaft_angle0_rad: 1.1, ..Start::of_series(seed, n) };
        let condition: OperatingCondition = o.condition;
        let run = |rig| Run { rig, condition, start };
        let made = simulate_many(&[run(&before), run(&after)])?;
        for (channel, measured) in o.samples.iter().enumerate() {
            let Some(measured) = measured else { continue };
            let of = |recording: &Recording, colour: &super::likelihood::Colour| {
                let samples = recording.channel(CHANNELS[channel]).map_or_else(Vec::new, |c| c.samples.clone());
                coloured(samples, &super::likelihood::hats(o), &colour[channel])
            };
            out.push(HeldOut {
                name: format!("{}-{}", o.name, CHANNELS[channel]),
                sample_rate_hz: o.condition.sample_rate_hz,
                measured: measured.clone(),
                before: of(&made[0], &null.colour),
                after: of(&made[1], &point.colour),
            });
        }
    }
    Ok(out)
}

/// Samples with the colour of a channel's noise.
fn coloured(mut samples: Vec<f64>, hats: &[(usize, f64)], colour: &[f64]) -> Vec<f64> {
    let n = samples.len();
    if n == 0 {
        return samples;
    }
    let mut bins = forward(&mut samples);
    for (bin, (knot, share)) in bins.iter_mut().zip(hats) {
        let log = colour[*knot] * (1.0 - share) + colour[*knot + 1] * share;
        *bin *= (0.5 * log).exp() / n as f64;
    }
    let inverse = inverse_plan(n);
    let mut out = inverse.make_output_vec();
    bins[0].im = 0.0;
    if let Some(last) = bins.last_mut().filter(|_| n.is_multiple_of(2)) {
        last.im = 0.0;
    }
    inverse.process(&mut bins, &mut out).unwrap_or_default();
    out
}
