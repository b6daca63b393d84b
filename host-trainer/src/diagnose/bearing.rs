//! Diagnosis of the 5-DoF rig by its likelihood.
//!
//! 1. The rig as it is, its unknown parameters and the angles fitted, leaves a residual; [`residual`](super::residual)
//!    says whether chance could have left it.
//! 2. Every hypothesis is brought as near as it can come ([`compete`](super::compete)), on recordings without the last.
//! 3. The best is kept where it gains more than its parameters are worth, and more on the recording that took no part
//!    than chance gives. A second one is sought in the same way in what it leaves.
//! 4. Where what is kept leaves most of what there was to explain, nothing in the vocabulary explains it.

use std::collections::BTreeMap;

use super::DiagnoseError;
use super::acquisition::{self, Fault};
use super::compete::{Contender, Contest};
use super::outcome::{Cause, Diagnosis, Fit, Fitted, HeldOut, Location, Outcome, Parameter, Rejected, SCHEMA, Verdict};
use super::prove::{Proof, prove};
use super::residual::{Excess, Whitened, excess, tests, whitened};
use super::{hypothesis, locate, pointers, recorded};
use crate::calibrate::bearing::{Options, calibrate};
use crate::calibrate::estimate::{Estimate, covariance, estimates};
use crate::calibrate::split::{Split, part};
use crate::recording::Recording;
use crate::rig::effect::Values;
use crate::rig::{Rig, Value};
use crate::whittle::coordinate::Coordinate;
use crate::whittle::observed::Observed;
use crate::whittle::problem::Problem;
use crate::whittle::search::Found;

/// ln L that a cause must gain beyond what its parameters are worth: some ninety explanations, each from many starts, were
/// tried on the same recordings.
const LEAST_MERIT: f64 = 12.0;
/// Excess, in standard deviations of chance, from which a residual is not noise of the rig's kind.
const EXCESS: f64 = 6.0;
/// Share of the excess that causes must take away to be an explanation; of what the first leaves, that a second must.
const EXPLAINED: f64 = 0.85;
const SECOND_EXPLAINS: f64 = 0.6;
/// p-value on the recording that took no part.
const LEAST_P: f64 = 0.01;
/// Length of the beginnings that all hypotheses are first tried on, s.
const BRIEF_S: f64 = 0.4;

/// Diagnoses recordings of a bearing rig.
///
/// # Errors
/// Recordings without acceleration, speed or load; a rig that cannot run.
pub fn diagnose(
    rig: &Rig,
    baseline: Option<&[Recording]>,
    recordings: &[Recording],
    seed: u64,
    progress: &dyn Fn(&str),
) -> Result<Outcome, DiagnoseError> {
    if recordings.is_empty() {
        return Err(DiagnoseError::Empty);
    }
    let mut rig = rig.clone();
    let mut caveats = Vec::new();
    if let Some(baseline) = baseline {
        progress("calibrating to the baseline");
        rig = calibrate(&rig, baseline, &Options { seed, ..Options::default() }, progress)?.rig;
        if !rig.paths.is_empty() {
            return recorded::diagnose(&rig, Some(baseline), recordings, seed, progress);
        }
    } else if !rig.unknown.is_empty() {
        progress("fitting the rig's unknown parameters");
        if let Some(rig) = recorded::beyond_the_rig(&rig, recordings, seed)? {
            return recorded::diagnose(&rig, None, recordings, seed, progress);
        }
    }
    let raw = recordings;
    let observed = |recordings: &[Recording]| recordings.iter().map(Observed::of).collect::<Result<Vec<_>, _>>();
    let clipped = acquisition::clipped(raw);
    let noise_std = rig.get("sensor.noise_std_m_per_s2").unwrap_or_default();
    let mut faults = acquisition::offset(&observed(raw)?, noise_std);
    let mut recordings = acquisition::without(raw, &faults);
    if let Some(line) = line_in(&rig, &observed(&recordings)?)? {
        recordings = acquisition::without(&recordings, std::slice::from_ref(&line));
        faults.push(line);
    }
    let recordings = recordings.as_slice();
    let split = Split::of(recordings);
    let fitted = observed(&split.fitted)?;
    let held_out = observed(&split.held_out)?;
    let unknown: Vec<Coordinate> = rig.unknown_keys().iter().filter_map(|key| Coordinate::of(&rig, key)).collect();
    let few = extremes(&split.fitted);
    let briefs: Vec<Recording> =
        few.iter().map(|r| part(r, 0..r.len().min((BRIEF_S * r.sample_rate_hz) as usize))).collect();
    let (few_observed, brief) = (observed(&few)?, observed(&briefs)?);

    progress("fitting the rig as it is");
    let ground =
        Contest { all: &fitted, brief: &brief, few: &few_observed, rig: rig.clone(), unknown: unknown.clone() };
    let (null, null_found) = ground.null(&fitted)?;
    let null_residuals = residuals(&null, &null_found)?;
    let noise = replicated(&null, &null_found, seed)?;
    let before = beyond(excess(&null_residuals), noise);
    let tests = tests(&null_residuals);

    let (few_null, few_found) = ground.null(&few_observed)?;
    let few_residuals = residuals(&few_null, &few_found)?;
    let signals: Vec<Vec<f64>> = few.iter().map(signal_of).collect();
    let pointers = pointers::of(&rig, &few_observed, &signals, &few_residuals);
    let load = recordings.iter().filter_map(|r| r.load_n).sum::<f64>() / recordings.len() as f64;
    let hypotheses = hypothesis::all(&rig, load, &pointers);
    // What was cut off is lost, and with it what another cause could be known by.
    let contenders = if clipped.is_empty() { ground.run(&hypotheses, progress)? } else { Vec::new() };

    let mut kept: Vec<&Contender> = Vec::new();
    let mut left = before;
    let second;
    // A rig that stands only as long as nothing shakes it is none.
    let stable = |c: &Contender| remaining(c, seed).ok();
    let best = contenders.iter().filter(|c| c.merit > LEAST_MERIT).find_map(|c| Some((c, stable(c)?)));
    if let Some((best, rest)) = best {
        kept.push(best);
        left = rest;
        if left.deviations > EXCESS {
            progress("looking for a second cause");
            // With a first cause that is not the right one the rig may not stand in every recording: then there is no second.
            second = after(best, &ground)?.run(&others(&hypotheses, best), progress).unwrap_or_default();
            let next = second.iter().filter(|c| c.merit > LEAST_MERIT).find_map(|c| Some((c, stable(c)?)));
            if let Some((next, rest)) = next
                && (rest.deviations < EXCESS || left.nats - rest.nats > SECOND_EXPLAINS * left.nats)
            {
                kept.push(next);
                left = rest;
            }
        }
    }
    let explained = if before.nats > 0.0 { 1.0 - left.nats.max(0.0) / before.nats } else { 1.0 };
    let best = kept.last().copied();
    let proof = match best {
        Some(best) => {
            progress("proving it on what took no part");
            // A rig that cannot be run under the condition that was held out is not proved.
            prove(&null, &null_found, &best.problem, &best.found, &held_out, seed).ok()
        }
        None => None,
    };
    let proven = proof.as_ref().is_some_and(|p| p.p_value < LEAST_P && p.after < p.before);
    let stands = proven && (left.deviations < EXCESS || explained > EXPLAINED);
    let verdict = match (stands, before.deviations > EXCESS || best.is_some()) {
        (true, _) => Verdict::Mismatch,
        (false, true) if before.deviations > EXCESS => Verdict::Unexplained,
        (false, _) => Verdict::NoMismatch,
    };
    let found = if stands { best } else { None };
    let corrected = match found {
        Some(best) => best.rig()?,
        None => null.rig_at(&null_found.point.coordinates)?,
    };
    let (values, fitted_along) =
        parameters(found.map_or((&null, &null_found), |b| (&b.problem, &b.found)), &rig, unknown.len());
    let mut causes =
        if stands { causes(&corrected, &rig, &values, &kept, proof.as_ref(), &contenders) } else { Vec::new() };
    let mut corrected = corrected;
    faults.extend(clipped);
    for fault in faults.iter().rev() {
        causes.insert(0, of_fault(fault));
        corrected.effects.push(fault.effect.clone());
    }
    let verdict = if faults.is_empty() { verdict } else { Verdict::Mismatch };
    let rejected = rejected(&contenders, &kept, stands, explained);
    let location = match verdict {
        Verdict::NoMismatch => Location::default(),
        _ => locate::locate(&rig, &corrected, &fitted, &null_residuals),
    };
    if verdict == Verdict::Unexplained {
        caveats.push(format!(
            "The best explanation in the vocabulary takes away {:.0} % of what the rig leaves unexplained; {:.0} % are asked for.",
            100.0 * explained.max(0.0),
            100.0 * EXPLAINED
        ));
    }
    let (fit, traces) = if faults.is_empty() {
        evidence_of(proof, stands, &split)
    } else {
        progress("showing it on what took no part");
        let p_value = faults.iter().map(|f| f.p_value).fold(0.0, f64::max);
        super::prove::shown(&rig, &corrected, &observed(&Split::of(raw).held_out)?, &split.describe(), p_value, seed)?
    };
    let diagnosis = Diagnosis { schema: SCHEMA, verdict, causes, rejected, location, fit };
    Ok(Outcome { diagnosis, rig: corrected, held_out: traces, tests, fitted: fitted_along, caveats })
}

/// The electrical line, where the residual of the rig has it.
fn line_in(rig: &Rig, observed: &[Observed]) -> Result<Option<Fault>, DiagnoseError> {
    let problem = Problem { observed, rig: rig.clone(), coordinates: Vec::new(), band: 1.0 };
    let expected = problem.expected(&problem.start()?)?;
    Ok(acquisition::mains(observed, &whitened(observed, &expected)))
}

fn of_fault(fault: &Fault) -> Cause {
    let value = |value: &Value| match value {
        Value::Number(number) => Parameter::Number(*number),
        Value::Text(text) => Parameter::Name(text.clone()),
    };
    Cause {
        name: fault.effect.name.clone(),
        probability: 0.99,
        parameters: fault.effect.parameters.iter().map(|(k, v)| (k.clone(), value(v))).collect(),
        interval95: BTreeMap::new(),
        evidence: fault.evidence.clone(),
        equation: fault
            .effect
            .definition()
            .zip(Values::new(&fault.effect, "bearing-5dof"))
            .map_or_else(String::new, |(d, v)| (d.equation)(&v)),
    }
}

/// The recordings of the least and the greatest load: what depends on it shows between them.
fn extremes(recordings: &[Recording]) -> Vec<Recording> {
    let load = |r: &&Recording| r.load_n.unwrap_or_default();
    let least = recordings.iter().min_by(|a, b| load(a).total_cmp(&load(b)));
    let greatest = recordings.iter().max_by(|a, b| load(a).total_cmp(&load(b)));
    let mut out: Vec<Recording> = least.into_iter().cloned().collect();
    out.extend(greatest.filter(|g| out.first() != Some(*g)).cloned());
    out
}

fn signal_of(recording: &Recording) -> Vec<f64> {
    let [ax, ay] = crate::whittle::observed::accelerations(recording);
    ax.or(ay).map_or_else(Vec::new, |c| c.samples.clone())
}

fn residuals(problem: &Problem, found: &Found) -> Result<Vec<Whitened>, DiagnoseError> {
    Ok(whitened(problem.observed, &problem.expected(&found.point)?))
}

/// The excess that recordings of this very rig would show: what the linearisation of its random part leaves out.
fn replicated(problem: &Problem, found: &Found, seed: u64) -> Result<Excess, DiagnoseError> {
    let rig = problem.rig_at(&found.point.coordinates)?;
    let expected = problem.expected(&found.point)?;
    let observed = super::prove::replicate(&rig, problem.observed, &found.point.angles, seed)?;
    Ok(excess(&whitened(&observed, &expected)))
}

fn beyond(all: Excess, noise: Excess) -> Excess {
    let (nats, deviations) = (all.nats - noise.nats.max(0.0), all.deviations - noise.deviations.max(0.0));
    Excess { nats, deviations }
}

/// What a contender leaves beyond what its own replicates do.
fn remaining(contender: &Contender, seed: u64) -> Result<Excess, DiagnoseError> {
    let all = excess(&residuals(&contender.problem, &contender.found)?);
    Ok(beyond(all, replicated(&contender.problem, &contender.found, seed)?))
}

/// The contest for a second cause: the first is part of the rig, its parameters are fitted along.
fn after<'o>(best: &Contender<'o>, ground: &Contest<'o>) -> Result<Contest<'o>, DiagnoseError> {
    Ok(Contest { rig: best.rig()?, unknown: best.problem.coordinates.clone(), ..ground.clone() })
}

fn others(hypotheses: &[hypothesis::Hypothesis], best: &Contender) -> Vec<hypothesis::Hypothesis> {
    hypotheses.iter().filter(|h| !(h.name == best.name && h.place == best.place)).cloned().collect()
}

/// Estimates of effects' parameters, and of the rig's unknown ones.
fn parameters((problem, found): (&Problem, &Found), before: &Rig, unknown: usize) -> (Vec<Estimate>, Vec<Fitted>) {
    let covariance = covariance(&found.expansion.information, problem.coordinates.len());
    let start: Vec<f64> = problem.coordinates.iter().map(|c| before.get(&c.key).unwrap_or_default()).collect();
    let mut all = estimates(&problem.coordinates, &start, &found.point.coordinates, &covariance);
    let effects = all.split_off(unknown.min(all.len()));
    let along = all.into_iter().map(|e| (e.key, e.value, e.interval95)).collect();
    (effects, along)
}

fn causes(
    corrected: &Rig,
    before: &Rig,
    values: &[Estimate],
    kept: &[&Contender],
    proof: Option<&Proof>,
    all: &[Contender],
) -> Vec<Cause> {
    let first = before.effects.len();
    let mut out = Vec::new();
    for (index, effect) in corrected.effects.iter().enumerate().skip(first) {
        let Some(definition) = effect.definition() else { continue };
        let Some(contender) = kept.get(index - first) else { continue };
        let vocabulary = |key: &str| definition.parameters.iter().any(|p| p.name == key && p.in_vocabulary());
        let mut parameters = BTreeMap::new();
        for (key, value) in
            effect.parameters.iter().filter(|(key, _)| vocabulary(key) || *key == "component" || *key == "channel")
        {
            let value = match value {
                Value::Number(number) => Parameter::Number(*number),
                Value::Text(text) => Parameter::Name(text.clone()),
            };
            parameters.insert(key.clone(), value);
        }
        let own = |key: &str| values.iter().find(|e| e.key == format!("effect[{}].{key}", index + 1));
        let interval95 = parameters.keys().filter_map(|key| Some((key.clone(), own(key)?.interval95))).collect();
        let next = all.iter().find(|c| !kept.iter().any(|k| k.name == c.name));
        let beside = next.map_or(String::new(), |n| format!("; the next best, {}, gains {:.0}", n.name, n.gain));
        let on = proof.map_or(String::new(), |p| {
            format!(", and {:.0} on what took no part (p {:.1e})", p.before - p.after, p.p_value)
        });
        out.push(Cause {
            name: effect.name.clone(),
            probability: probability(contender, all),
            parameters,
            interval95,
            evidence: format!("ln L gains {:.0} on the fitted recordings{on}{beside}.", contender.gain),
            equation: Values::new(effect, "bearing-5dof").map_or_else(String::new, |v| (definition.equation)(&v)),
        });
    }
    out.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    out
}

/// Share of the posterior among the finalists of its own name against the others.
fn probability(contender: &Contender, all: &[Contender]) -> f64 {
    let top = all.iter().map(|c| c.merit).fold(contender.merit, f64::max);
    let weight = |c: &Contender| (c.merit - top).exp();
    let own: f64 = weight(contender);
    let others: f64 = all.iter().filter(|c| c.name != contender.name && c.merit < contender.merit).map(weight).sum();
    (own / (own + others)).min(0.999)
}

fn rejected(all: &[Contender], kept: &[&Contender], stands: bool, explained: f64) -> Vec<Rejected> {
    let top = kept.first().map_or(0.0, |k| k.gain);
    let mut out: Vec<Rejected> = Vec::new();
    for contender in all {
        if stands && kept.iter().any(|k| k.name == contender.name) || out.iter().any(|r| r.name == contender.name) {
            continue;
        }
        let place = if contender.place.is_empty() { String::new() } else { format!("({}) ", contender.place) };
        let why = if stands {
            format!("{place}gains {:.0} in ln L where the cause gains {top:.0}", contender.gain)
        } else if contender.merit < LEAST_MERIT {
            format!("{place}gains {:.1} in ln L, no more than its parameters are worth", contender.gain)
        } else {
            format!(
                "{place}gains {:.0} in ln L, yet all causes together leave {:.0} % unexplained",
                contender.gain,
                100.0 * (1.0 - explained)
            )
        };
        out.push(Rejected { name: contender.name.into(), why });
    }
    out
}

fn evidence_of(proof: Option<Proof>, stands: bool, split: &Split) -> (Fit, Vec<HeldOut>) {
    let metric = "−ln L for each frequency, above that of the right rig".to_owned();
    let held_out = split.describe();
    match proof {
        Some(p) if stands => {
            let fit = Fit {
                metric,
                held_out,
                before: p.before_each,
                after: p.after_each,
                noise_floor: p.floor_each,
                p_value: p.p_value,
            };
            (fit, p.traces)
        }
        Some(p) => {
            let fit = Fit {
                metric,
                held_out,
                before: p.before_each,
                after: p.before_each,
                noise_floor: p.floor_each,
                p_value: 1.0,
            };
            let traces = p.traces.into_iter().map(|t| HeldOut { after: t.before.clone(), ..t }).collect();
            (fit, traces)
        }
        None => (Fit { metric, held_out, before: 0.0, after: 0.0, noise_floor: 0.0, p_value: 1.0 }, Vec::new()),
    }
}
