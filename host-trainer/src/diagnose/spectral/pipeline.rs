//! From recordings to a result: acquire, split, fit the nominal rig, select causes, validate.

use super::causes::{self, Accepted};
use super::data::{Data, Point};
use super::events::{Event, events, without_event};
use super::fit::Model;
use super::held_out::{Synthesis, held_out};
use super::lack::lack;
use super::observation::{Observation, duration_s, mean_load_n};
use super::prediction::Known;
use super::search::{Brief, Candidate, candidates};
use super::settings::{self, FitSettings, GateSettings};
use super::terms::term;
use super::text;
use crate::diagnose::acquisition::Acquired;
use crate::diagnose::result::{Cause, Diagnosis, DiagnosisResult, Nuisance, Rejected, SCHEMA, Term, Verdict};
use crate::diagnose::{DiagnoseError, Task, evidence, locate, shown};
use crate::identify::calibrate::split::Split;
use crate::identify::likelihood::coordinate::Coordinate;
use crate::identify::likelihood::observed::Observed;
use crate::recording::Recording;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::{Rig, RigError};
use crate::signal::kinematics::Orders;

const GATE: GateSettings = GateSettings::DEFAULT;
const FIT: FitSettings = FitSettings::DEFAULT;

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
    let (all_fitted, all_held) = (observe(&split.fitted)?, observe(&split.held_out)?);
    progress("searching for events");
    let event = event(rig, &all_fitted, &all_held, orders)?;
    let event = event.as_ref();
    let fitted = without(&all_fitted, event, 0);
    let held = without(&all_held, event, all_fitted.len());
    progress("fitting the nominal rig");
    let (data, held_data) = (Data::new(&fitted, orders), Data::new(&held, orders));
    let nominal = nominal(rig, &data);
    let null = nominal.search(nominal.start()?, FIT.nominal_steps)?;
    let held_null = refit_nuisances(&held_data, &nominal, &null)?;
    let (before, held_before) = (lack(&data, &null), lack(&held_data, &held_null));
    let selection = Selection::new(&nominal, &null).with_causes(&held_data, held_null.objective(), progress)?;
    let Selection { model, point, accepted, rejected, corrected_loads } = selection;

    let before_total = before.total() + held_before.total();
    let is_beyond_chance = before_total > GATE.lack * (fitted.len() + held.len()) as f64 / 4.0;
    let is_named = !accepted.is_empty() || event.is_some() || acquired.faults().next().is_some();
    let verdict = match (is_named, is_beyond_chance) {
        (true, _) => Verdict::Mismatch,
        (false, true) => Verdict::Unexplained,
        (false, false) => Verdict::NoMismatch,
    };
    let corrected = model.rig_at(&point.values)?;
    let names: Vec<String> = all_fitted.iter().chain(&all_held).map(|o| o.name.clone()).collect();
    let (intervals, numbers) = causes::estimates(&model, &point, nominal.coordinates.len())?;
    let mut all_causes: Vec<Cause> = acquired.faults().map(causes::fault_cause).collect();
    all_causes.extend(event.map(|e| causes::event_cause(e, &names)));
    let mut found: Vec<Cause> =
        accepted.iter().map(|a| causes::cause(a, &corrected.effects[a.effect], &intervals)).collect();
    found.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    all_causes.extend(found);
    let load_n = mean_load_n(&all_fitted);
    let mut terms: Vec<Term> = event.iter().filter_map(|e| term(&e.mean(), machine, load_n, [0.9, 1.1])).collect();
    terms.extend(accepted.iter().filter_map(|a| {
        let effect = &corrected.effects[a.effect];
        term(effect, machine, load_n, causes::band(effect, a, &intervals))
    }));

    progress("simulating held-out recordings");
    // Both have the noise's colours of the last fit, so that they differ by the causes alone.
    let before_rig = Synthesis { rig: nominal.rig_at(&null.values)?, colour: &point.colour };
    let after_rig = Synthesis { rig: corrected.clone(), colour: &point.colour };
    let signals = held_out(&all_held, &before_rig, &after_rig, (event, all_fitted.len()), &orders, task.seed)?;
    let (mut fit, mut left) = shown::fit(&signals, split.describe(), task.seed);
    fit.p_value = if accepted.is_empty() && event.is_none() {
        acquired.faults().map(|f| f.p_value).reduce(f64::max).unwrap_or(1.0)
    } else {
        let gain = accepted.iter().map(|a| a.held_out).sum::<f64>() + event.map_or(0.0, Event::gain);
        (-gain).exp().clamp(1e-300, 1.0)
    };
    left.share = match verdict {
        Verdict::NoMismatch => 0.0,
        _ => (lack(&data, &point).total() / before.total().max(1.0)).min(1.0),
    };
    let samples = all_fitted.iter().chain(&all_held).map(|o| o.condition.samples).sum();
    let mut tests = before.tests.clone();
    tests.extend(event.iter().flat_map(|e| causes::event_tests(e, &names, samples)));
    let tests = evidence::ranked(tests);
    let mut corrected_rig = event.map_or_else(|| corrected.clone(), |e| corrected.clone().with_effect(e.mean()));
    let location = match verdict {
        Verdict::NoMismatch => Default::default(),
        _ => locate::locate(rig, &corrected_rig, &tests),
    };
    corrected_rig.effects.extend(acquired.faults().map(|fault| fault.effect.clone()).rev());
    let mut caveats = Vec::new();
    if verdict == Verdict::Unexplained {
        let each = before.nats.iter().chain(&held_before.nats).zip(&names);
        let most = each.max_by(|a, b| a.0.total_cmp(b.0)).map_or(String::new(), |(_, name)| format!("in {name}"));
        caveats.push(text::unexplained(before_total, &most));
    }
    if corrected_loads {
        caveats.push(text::LOAD.into());
    }
    if task.recordings.iter().any(|recording| recording.load_n.is_none()) {
        caveats.push(text::NO_LOAD.into());
    }
    let diagnosis = Diagnosis {
        schema: SCHEMA.into(),
        verdict,
        rejected: rejected_names(&accepted, &rejected, &all_causes),
        causes: all_causes,
        location,
        terms,
        nuisance: nuisances(&data, &point),
        left,
        fit,
    };
    let settings = settings::document();
    Ok(DiagnosisResult { diagnosis, rig: corrected_rig, held_out: signals, tests, fitted: numbers, caveats, settings })
}

/// Selection of causes, one after the other.
struct Selection<'d, 'a> {
    /// Nominal rig with the effects so far.
    model: Model<'d, 'a>,
    /// Fit of the model.
    point: Point,
    accepted: Vec<Accepted<'d, 'a>>,
    /// Candidates that did not pass the gate.
    rejected: Vec<Candidate<'d, 'a>>,
    /// Whether an error of the stated loads is among the effects.
    corrected_loads: bool,
}

impl<'d, 'a> Selection<'d, 'a> {
    /// Nominal rig without causes.
    fn new(nominal: &Model<'d, 'a>, null: &Point) -> Self {
        let (model, point) = (nominal.clone(), null.clone());
        Self { model, point, accepted: Vec::new(), rejected: Vec::new(), corrected_loads: false }
    }

    /// Adds at most two causes, each judged by the held-out recordings; `held_null` is −ln there without any.
    fn with_causes(mut self, held_data: &Data, held_null: f64, progress: &dyn Fn(&str)) -> Result<Self, DiagnoseError> {
        let observations = self.model.data.observations;
        let brief = Brief::new(observations);
        let mut held_now = held_null;
        while self.accepted.len() < 2 {
            let is_second = !self.accepted.is_empty();
            progress(if is_second { "searching for a second cause" } else { "searching for a cause" });
            let left = lack(self.model.data, &self.point).total();
            if is_second && left < GATE.second_lack {
                break;
            }
            let kinds: Vec<EffectKind> = self.model.rig.effects.iter().map(|e| e.kind).collect();
            let mut found = candidates(&self.model, &self.point, &brief, &kinds);
            if found.is_empty() {
                break;
            }
            let best = found.remove(load_error_or_first(&found, observations));
            let judged = refit_nuisances(held_data, &best.model, &best.point)?.objective();
            let share = if is_second { GATE.second_share } else { GATE.first_share };
            let held_share = duration_s(held_data.observations) / duration_s(observations);
            let enough_held = GATE.held_out.max(GATE.held_out_share * held_share * best.gain);
            if best.gain < GATE.gain.max(share * left) || held_now - judged < enough_held {
                self.rejected.push(best);
                self.rejected.extend(found);
                break;
            }
            let held_out = held_now - judged;
            (self.model, self.point, held_now) = (best.model.clone(), best.point.clone(), judged);
            if is_load_error(&best, observations) {
                self.corrected_loads = true;
                continue;
            }
            let probability = causes::probability(&best, &found, is_second);
            let effect = self.model.rig.effects.len() - 1;
            self.accepted.push(Accepted { candidate: best, held_out, probability, rivals: found, effect });
        }
        Ok(self)
    }
}

/// Index of the first candidate, or of an error of the stated load that gains nearly as much.
fn load_error_or_first(found: &[Candidate], observations: &[Observation]) -> usize {
    let most = found[0].gain;
    let is_close = |c: &Candidate| c.gain > most - GATE.load_nats - GATE.load_share_of_gain * most;
    found.iter().position(|c| is_load_error(c, observations) && is_close(c)).unwrap_or(0)
}

/// Whether a candidate is an error of the stated load.
fn is_load_error(candidate: &Candidate, observations: &[Observation]) -> bool {
    let force = |rig: Rig| rig.effects.last().and_then(|e| e.number(ParameterKey::ForceN));
    let force = candidate.model.rig_at(&candidate.point.values).ok().and_then(force).unwrap_or_default();
    candidate.kind == EffectKind::ConstantForce && force.abs() < GATE.load_share * mean_load_n(observations)
}

/// Nominal rig with its unknown numbers free.
fn nominal<'d, 'a>(rig: &Rig, data: &'d Data<'a>) -> Model<'d, 'a> {
    let coordinates: Vec<Coordinate> =
        rig.unknown_keys().into_iter().filter_map(|key| Coordinate::for_key(rig, key)).collect();
    let guess = |c: &Coordinate| c.to_coordinate(rig.get(c.key).unwrap_or_default());
    let guesses = coordinates.iter().map(guess).collect();
    Model { data, rig: rig.clone(), coordinates, guesses, known: Known::Nothing }
}

/// Fitted model on other recordings, of which only the nuisances are fitted.
fn refit_nuisances(data: &Data, model: &Model, point: &Point) -> Result<Point, RigError> {
    let other = Model::fixed(data, model.rig_at(&point.values)?);
    let count = data.observations.len();
    let jitter = point.jitter.iter().copied().max().unwrap_or(0);
    let from = Point { values: Vec::new(), stretch: vec![0.0; count], jitter: vec![jitter; count], ..point.clone() };
    other.search(other.start_from(&from)?, FIT.held_out_steps)
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
    let start = nominal.start()?;
    let point = if nominal.coordinates.is_empty() { start } else { nominal.search(start, FIT.nominal_steps)? };
    let noise: Vec<_> = point.predictions.iter().map(|p| p.noise.clone()).collect();
    let found = events(&nominal.rig_at(&point.values)?, &all, &noise)?;
    Ok(found.into_iter().next())
}

/// Recordings without the stretch of an event; the first of them is the `first` of all.
fn without(observations: &[Observation], event: Option<&Event>, first: usize) -> Vec<Observation> {
    let cut = |(n, o): (usize, &Observation)| {
        let occurrence = event.and_then(|e| e.occurrences.get(first + n)).filter(|found| found.is_event());
        occurrence.map_or_else(|| o.clone(), |found| without_event(o, found.time_s))
    };
    observations.iter().enumerate().map(cut).collect()
}

/// Effects that were considered and are no causes, each once, with the reason.
fn rejected_names(accepted: &[Accepted], rejected: &[Candidate], causes: &[Cause]) -> Vec<Rejected> {
    let kept = accepted.first().map(|a| a.candidate.gain);
    let rivals = accepted.iter().flat_map(|a| a.rivals.iter().map(|rival| (rival, kept)));
    let mut out: Vec<Rejected> = Vec::new();
    for (candidate, kept) in rivals.chain(rejected.iter().map(|c| (c, None))) {
        let name = candidate.kind.to_string();
        if !out.iter().any(|r| r.name == name) && !causes.iter().any(|c| c.name == name) {
            out.push(Rejected { name, why: text::rejected(candidate, kept) });
        }
    }
    out
}

fn nuisances(data: &Data, point: &Point) -> Vec<Nuisance> {
    let of = |(n, o): (usize, &Observation)| Nuisance {
        recording: o.name.clone(),
        shaft_hz: None,
        slip: Some(-point.stretch[n]),
        wander: None,
    };
    data.observations.iter().enumerate().map(of).collect()
}
