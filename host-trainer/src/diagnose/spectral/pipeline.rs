//! From recordings to a result: acquire, split, fit the nominal rig, select causes, validate.

use super::baseline::Baseline;
use super::causes::{self, Accepted, Intervals, Trust};
use super::data::{Data, GreatestColour, Point};
use super::events::{Event, event, without_event};
use super::fit::Model;
use super::gate::is_unlike;
use super::growth::Lasting;
use super::held_out::{Compared, Disturbed, held_out};
use super::lack::{lack, lack_of_both};
use super::mains::Mains;
use super::observation::{Observation, mean_load_n};
use super::refit::refit_nuisances;
use super::selection::{Selection, rejected_names};
use super::settings::{self, FitSettings, GateSettings};
use super::terms::term;
use super::text;
use super::unevenness::UnevenMachines;
use super::unsteady::unsteady_kurtosis;
use crate::diagnose::acquisition::{Acquired, Converter, Fault};
use crate::diagnose::result::{Cause, Diagnosis, DiagnosisResult, Nuisance, SCHEMA, Term, Verdict};
use crate::diagnose::{DiagnoseError, Task, evidence, locate, shown};
use crate::identify::calibrate::split::Split;
use crate::identify::likelihood::coordinate::Coordinate;
use crate::identify::likelihood::observed::Observed;
use crate::recording::Recording;
use crate::rig::config::BearingRig;
use crate::rig::{Rig, Start, simulate};
use crate::signal::kinematics::Orders;

const GATE: GateSettings = GateSettings::DEFAULT;
const FIT: FitSettings = FitSettings::DEFAULT;

/// Diagnosis of all recordings of a task, each with the same causes.
pub struct Whole {
    /// Result.
    pub result: DiagnosisResult,
    /// Recordings as they were searched, without faults of the acquisition, the electrical line and an event.
    pub searched: Vec<Observation>,
    /// Rig with the lasting effects that were found, as it was fitted.
    pub lasting: Lasting,
}

/// Diagnoses recordings of a bearing rig of known structure, which all have the same causes; `rig` is calibrated to the baseline.
///
/// # Errors
/// Recordings without acceleration or speed; a rig that cannot run.
pub fn whole(task: &Task, rig: &Rig, progress: &dyn Fn(&str)) -> Result<Whole, DiagnoseError> {
    let machine = rig.bearing().ok_or(DiagnoseError::NotBearing { found: rig.model.kind().name() })?;
    let orders = machine.bearing.geometry().orders();
    let converter = Converter::of(rig, task.recordings);
    let rig = &converter.map_or_else(|| rig.clone(), |converter| converter.noisy(rig));
    let coarse = converter.filter(|converter| converter.is_mismatch(task.baseline));
    let mut acquired = Acquired::detect(rig, task.recordings)?;
    let split = Split::new(&acquired.recordings);
    let observe = |recordings: &[Recording]| -> Result<Vec<Observation>, DiagnoseError> {
        Ok(Observed::from_recordings(recordings)?.iter().map(Observation::new).collect())
    };
    let (mut all_fitted, recorded_held) = (observe(&split.fitted)?, observe(&split.held_out)?);
    let mut all_held = recorded_held.clone();
    progress("searching for the electrical line and for events");
    let all: Vec<Observation> = all_fitted.iter().chain(&all_held).cloned().collect();
    let Once { mains, event } = Once::find(rig, &all, orders)?;
    if let Some(mains) = &mains {
        acquired.taken_out.push(mains.fault(&all));
        all_held = mains.removed(&all_held, all_fitted.len());
        all_fitted = mains.removed(&all_fitted, 0);
    }
    let event = event.as_ref();
    let fitted = without(&all_fitted, event, 0);
    let held = without(&all_held, event, all_fitted.len());
    progress("fitting the nominal rig");
    let data = Data::new(&fitted, orders, UnevenMachines::new(rig, &fitted, &orders)?);
    let held_data = Data::new(&held, orders, UnevenMachines::new(rig, &held, &orders)?);
    let nominal = nominal(rig, &data);
    let null = null_point(&nominal)?;
    let held_null = refit_nuisances(&held_data, &nominal, &null)?;
    let [before, held_before] = lack_of_both([(&data, &null), (&held_data, &held_null)]);
    let healthy = task.baseline.map(&observe).transpose()?.unwrap_or_default();
    let healthy_data = Data::new(&healthy, orders, UnevenMachines::new(rig, &healthy, &orders)?);
    let baseline = (!healthy.is_empty()).then(|| Baseline::new(&healthy_data, &nominal, &null)).transpose()?;
    let mut selection = Selection::new(&nominal, &null, event.map(|e| e.effect.kind)).with_causes(
        &held_data,
        held_null.objective(),
        baseline,
        progress,
    )?;
    let refitted = |selection: &Selection| refit_nuisances(&held_data, &selection.model, &selection.point);
    let left_by = |selection: &Selection, held: &Point| {
        lack_of_both([(&data, &selection.point), (&held_data, held)]).map(|lack| lack.total())
    };
    let mut held_point = refitted(&selection)?;
    let left: f64 = left_by(&selection, &held_point).iter().sum();
    let chance = GATE.lack * (fitted.len() + held.len()) as f64;
    let doubtful = selection.rejected.iter().find(|c| c.gain > GATE.doubtful_gain).cloned();
    // What strikes has pits or play for causes; the rig itself may rattle, and a mode ring with that.
    let strikes = selection.accepted.iter().any(|a| causes::may_strike(a.candidate.kind));
    let found_rig = selection.rig()?;
    let run = || simulate(&found_rig, &held.first()?.condition, &Start::of_series(task.seed, 0)).ok();
    let observed: Vec<&Observation> = fitted.iter().chain(&held).collect();
    let kurtosis = (!strikes).then(|| unsteady_kurtosis(&observed, run)).flatten();
    let is_nameless = coarse.is_some() || kurtosis.is_some() || !selection.nameless.is_empty();
    let was = before.total() + held_before.total() + event.map_or(0.0, Event::gain);
    let share = (left - chance).max(0.0) / (was - chance).max(1.0);
    let most_coloured = |selection: &Selection, held: &Point| {
        tilted(&data, &selection.point, 0).or_else(|| tilted(&held_data, held, fitted.len()))
    };
    let trust = Trust {
        is_steady: kurtosis.is_none(),
        keeps_level: coarse.is_none_or(|converter| converter.keeps_level()),
        is_filtered: most_coloured(&selection, &held_point).is_some(),
        share,
    };
    // One spike among others is no event.
    let event = event.filter(|e| trust.states(e.probability, &e.effect));
    if selection.judge(trust) {
        held_point = refitted(&selection)?;
    }
    progress("simulating held-out recordings");
    let disturbed = Disturbed { acquired: &acquired, mains: mains.as_ref(), event, first: all_fitted.len() };
    let nominal_rig = nominal.rig_at(&null.values)?;
    let simulated = |selection: &Selection, machine: &Point| -> Result<_, DiagnoseError> {
        let after = selection.rig()?;
        let compared = Compared { before: &nominal_rig, after: &after, machine };
        let signals = held_out(&recorded_held, &compared, &disturbed, &orders, task.seed)?;
        let (fit, remains) = shown::fit(&signals, split.describe(), task.seed);
        Ok((signals, fit, remains))
    };
    let (mut signals, mut fit, mut remains) = simulated(&selection, &held_point)?;
    let unshown = selection.take_back_unshown(&fit);
    if unshown.is_some() {
        held_point = refitted(&selection)?;
        (signals, fit, remains) = simulated(&selection, &held_point)?;
    }
    // More than `left` where causes were taken back.
    let [unexplained_of_fitted, unexplained_of_held] = left_by(&selection, &held_point);
    let unexplained = unexplained_of_fitted + unexplained_of_held;
    let tilted = most_coloured(&selection, &held_point);
    let is_beyond_chance =
        unexplained > chance || doubtful.is_some() || unshown.is_some() || tilted.is_some() || is_unlike(&fit);
    let corrected = selection.rig()?;
    let Selection { model, point, accepted, rejected, .. } = &selection;

    let is_named = !accepted.is_empty() || event.is_some() || acquired.faults().next().is_some();
    let verdict = match (is_named, is_beyond_chance || is_nameless) {
        (true, _) => Verdict::Mismatch,
        (false, true) => Verdict::Unexplained,
        (false, false) => Verdict::NoMismatch,
    };
    let names: Vec<String> = all_fitted.iter().chain(&all_held).map(|o| o.name.clone()).collect();
    let (intervals, numbers) = causes::estimates(model, point, nominal.coordinates.len());
    let found = Found { event, names: &names, accepted, trust, corrected: &corrected, intervals: &intervals };
    let (causes, terms) = (found.causes(&acquired), found.terms(machine, mean_load_n(&all_fitted)));

    fit.p_value = if accepted.is_empty() && event.is_none() {
        acquired.faults().map(|f| f.p_value).reduce(f64::max).unwrap_or(1.0)
    } else {
        let gain = accepted.iter().map(|a| a.held_out).sum::<f64>() + event.map_or(0.0, Event::gain);
        (-gain).exp().clamp(1e-300, 1.0)
    };
    remains.share = match verdict {
        Verdict::NoMismatch => 0.0,
        _ => (unexplained_of_fitted / before.total().max(1.0)).min(1.0),
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
    if verdict == Verdict::Unexplained && is_beyond_chance {
        let each = before.nats.iter().chain(&held_before.nats).zip(&names);
        let most = each.max_by(|a, b| a.0.total_cmp(b.0)).map_or(String::new(), |(_, name)| format!("in {name}"));
        caveats.extend((unexplained > chance).then(|| text::unexplained(unexplained, &most)));
        caveats.extend(doubtful.map(|candidate| text::doubtful(&candidate)));
        caveats.extend(unshown.map(|candidate| text::unshown(&candidate)));
        caveats.extend(tilted.map(|colour| text::tilted(&colour, &names[colour.recording])));
        caveats.extend(is_unlike(&fit).then(|| text::unlike(&fit)));
    }
    let is_unsteady = verdict == Verdict::Unexplained && coarse.is_none();
    caveats.extend(kurtosis.filter(|_| is_unsteady).map(text::unsteady));
    caveats.extend(selection.nameless.iter().map(text::nameless));
    caveats.extend(coarse.as_ref().map(text::coarse));
    caveats.extend((!selection.in_baseline.is_empty()).then(|| text::in_baseline(&selection.in_baseline)));
    caveats.extend(selection.tolerated.iter().map(text::tolerated));
    let is_load_unknown = task.recordings.iter().any(|recording| recording.load_n.is_none());
    caveats.extend(is_load_unknown.then(|| text::NO_LOAD.into()));
    let diagnosis = Diagnosis {
        schema: SCHEMA.into(),
        verdict,
        rejected: rejected_names(accepted, rejected, &causes),
        causes,
        location,
        terms,
        nuisance: nuisances(&data, point),
        left: remains,
        fit,
    };
    let settings = settings::document();
    let result =
        DiagnosisResult { diagnosis, rig: corrected_rig, held_out: signals, tests, fitted: numbers, caveats, settings };
    let lasting = Lasting::of(model, corrected);
    let searched = fitted.into_iter().chain(held).collect();
    Ok(Whole { result, searched, lasting })
}

/// What was found: an event, and effects of the corrected rig.
struct Found<'f, 'd, 'a> {
    event: Option<&'f Event>,
    /// Names of all recordings.
    names: &'f [String],
    accepted: &'f [Accepted<'d, 'a>],
    trust: Trust,
    corrected: &'f Rig,
    intervals: &'f Intervals,
}

impl Found<'_, '_, '_> {
    /// Causes, the most probable first; of equal ones faults of the acquisition, then the event.
    fn causes(&self, acquired: &Acquired) -> Vec<Cause> {
        let cause = |a: &Accepted| causes::cause(a, &self.corrected.effects[a.effect], self.intervals);
        let event = self.event.map(|e| causes::event_cause(e, self.names, self.trust));
        let lasting = self.accepted.iter().map(cause);
        let mut all: Vec<Cause> = acquired.faults().map(Fault::cause).chain(event).chain(lasting).collect();
        all.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        all
    }

    /// Terms under a load, N.
    fn terms(&self, machine: &BearingRig, load_n: f64) -> Vec<Term> {
        let event = self.event.and_then(|e| term(&e.mean(), machine, load_n, e.band()));
        let lasting = self.accepted.iter().filter_map(|a| {
            let effect = &self.corrected.effects[a.effect];
            term(effect, machine, load_n, causes::band(effect, a, self.intervals))
        });
        event.into_iter().chain(lasting).collect()
    }
}

/// Colour that is more than what differs between noises; recordings are counted from `first`.
fn tilted(data: &Data, point: &Point, first: usize) -> Option<GreatestColour> {
    let greatest = data.greatest_colour(point).filter(|colour| colour.power_np.abs() > GATE.most_colour_np)?;
    Some(GreatestColour { recording: first + greatest.recording, ..greatest })
}

/// Fit of the nominal rig, whose rotation wanders if that is most of what the rig lacks: otherwise it would take up the lines of a
/// defect.
fn null_point(nominal: &Model) -> Result<Point, DiagnoseError> {
    let even = nominal.search(nominal.start()?, FIT.nominal_steps)?;
    let wandering = nominal.search_wandering(&even, FIT.nominal_steps)?;
    let lacks = [&even, &wandering].map(|point| lack(nominal.data, point).total());
    Ok(if lacks[1] < GATE.wandering_left * lacks[0] { wandering } else { even })
}

/// Nominal rig with its unknown numbers free.
pub fn nominal<'d, 'a>(rig: &Rig, data: &'d Data<'a>) -> Model<'d, 'a> {
    Model::of_unknown(
        data,
        rig,
        rig.unknown_keys().into_iter().filter_map(|key| Coordinate::for_key(rig, key)).collect(),
    )
}

/// What is taken out of the recordings before a lasting effect is searched for.
struct Once {
    mains: Option<Mains>,
    /// Event that happened once in some of the recordings.
    event: Option<Event>,
}

impl Once {
    /// Electrical line and event in all recordings, those that are held out last.
    fn find(rig: &Rig, all: &[Observation], orders: Orders) -> Result<Self, DiagnoseError> {
        let data = Data::new(all, orders, UnevenMachines::default());
        let nominal = nominal(rig, &data);
        let start = nominal.start()?;
        let point = if nominal.coordinates.is_empty() { start } else { nominal.search(start, FIT.nominal_steps)? };
        let mains = Mains::find(&data, &point);
        let noise: Vec<_> = point.predictions.iter().map(|p| p.noise.clone()).collect();
        let cleaned = mains.as_ref().map(|mains| mains.removed(all, 0));
        let event = event(&nominal.rig_at(&point.values)?, cleaned.as_deref().unwrap_or(all), &noise)?;
        Ok(Self { mains, event })
    }
}

/// Recordings without the stretch of an event; the first of them is the `first` of all.
fn without(observations: &[Observation], event: Option<&Event>, first: usize) -> Vec<Observation> {
    let cut = |(n, o): (usize, &Observation)| {
        let occurrence = event.and_then(|e| e.occurrences.get(first + n)).filter(|found| found.is_event());
        let effect = event.and_then(|e| e.effect_in(first + n));
        occurrence.zip(effect).map_or_else(|| o.clone(), |(found, effect)| without_event(o, found.time_s, &effect))
    };
    observations.iter().enumerate().map(cut).collect()
}

fn nuisances(data: &Data, point: &Point) -> Vec<Nuisance> {
    let of = |(n, o): (usize, &Observation)| Nuisance {
        recording: o.name.clone(),
        shaft_hz: None,
        slip: Some(-point.stretch[n].outer),
        wander: None,
    };
    data.observations.iter().enumerate().map(of).collect()
}
