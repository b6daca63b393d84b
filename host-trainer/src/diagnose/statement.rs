//! What the search for causes has found, as a diagnosis says it.

use std::collections::BTreeMap;

use super::acquisition::Fault;
use super::compete::{Contender, Dropped};
use super::explain::{Choice, Explanation, LEAST_MERIT};
use super::outcome::{Cause, Fit, Fitted, HeldOut, Parameter, Rejected};
use super::prove::Proof;
use crate::calibrate::estimate::{Estimate, covariance, estimates};
use crate::report::number::by_chance;
use crate::rig::{EffectEntry, Rig};
use crate::whittle::problem::Problem;
use crate::whittle::search::Found;

/// Kind of the rig whose equations are stated.
const KIND: &str = "bearing-5dof";

/// A fault of the acquisition as a cause.
pub fn of_fault(fault: &Fault) -> Cause {
    Cause {
        name: fault.effect.name.clone(),
        probability: 0.99,
        parameters: fault.effect.parameters.iter().map(|(key, value)| (key.clone(), value.into())).collect(),
        interval95: BTreeMap::new(),
        evidence: fault.evidence.clone(),
        equation: fault.effect.equation(KIND),
    }
}

/// Estimates of effects' parameters, and of the rig's unknown ones, the first `unknown` of what was sought.
pub fn parameters(problem: &Problem, found: &Found, before: &Rig, unknown: usize) -> (Vec<Estimate>, Vec<Fitted>) {
    let covariance = covariance(&found.expansion.information, problem.coordinates.len());
    let start: Vec<f64> = problem.coordinates.iter().map(|c| before.get(&c.key).unwrap_or_default()).collect();
    let mut all = estimates(&problem.coordinates, &start, &found.point.coordinates, &covariance);
    let effects = all.split_off(unknown.min(all.len()));
    let along = all.into_iter().map(|e| (e.key, e.value, e.interval95)).collect();
    (effects, along)
}

/// The effects that `corrected` has beyond `before` as causes, the most probable first. They are those of the contenders
/// that were kept, in the same order.
pub fn causes(
    corrected: &Rig,
    before: &Rig,
    values: &[Estimate],
    explanation: &Explanation,
    proof: Option<&Proof>,
) -> Vec<Cause> {
    let added = corrected.effects.iter().enumerate().skip(before.effects.len());
    let cause = |((index, effect), choice): ((usize, &EffectEntry), &Choice)| {
        let parameters = stated(effect);
        let estimate = |key: &str| values.iter().find(|e| e.key == format!("effect[{}].{key}", index + 1));
        Cause {
            name: effect.name.clone(),
            probability: choice.probability(),
            interval95: parameters.keys().filter_map(|key| Some((key.clone(), estimate(key)?.interval95))).collect(),
            parameters,
            evidence: evidence(&choice.cause, explanation, proof),
            equation: effect.equation(KIND),
        }
    };
    let mut out: Vec<Cause> = added.zip(&explanation.kept).map(cause).collect();
    out.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    out
}

/// The parameters of the vocabulary, and where the effect acts.
fn stated(effect: &EffectEntry) -> BTreeMap<String, Parameter> {
    let vocabulary = effect.definition().map_or(&[][..], |d| d.parameters).iter().filter(|p| p.in_vocabulary());
    let keys: Vec<&str> = vocabulary.map(|p| p.name).chain(["component", "channel"]).collect();
    let all = effect.parameters.iter().filter(|(key, _)| keys.contains(&key.as_str()));
    all.map(|(key, value)| (key.clone(), value.into())).collect()
}

/// What the cause gains, and the next best explanation.
fn evidence(contender: &Contender, explanation: &Explanation, proof: Option<&Proof>) -> String {
    let next = explanation.contenders.iter().find(|c| !explanation.keeps(c.name));
    let beside = next.map_or(String::new(), |n| format!("; the next best, {}, gains {:.0}", n.name, n.gain));
    let on = proof.map_or(String::new(), |p| {
        format!(", and {:.0} on what took no part ({})", p.before - p.after, by_chance(p.p_value))
    });
    format!("ln L gains {:.0} on the fitted recordings{on}{beside}.", contender.gain)
}

/// Every other name of the contest, and why it lost. `stands` is whether the causes that were kept are proved, `explained`
/// the share of the excess that they take away.
pub fn rejected(explanation: &Explanation, stands: bool, explained: f64) -> Vec<Rejected> {
    let top = explanation.kept.first().map_or(0.0, |first| first.cause.gain);
    let mut out: Vec<Rejected> = Vec::new();
    let mut say = |name: &str, place: &str, why: String| {
        let told = stands && explanation.keeps(name) || out.iter().any(|r| r.name == name);
        if !told {
            let place = if place.is_empty() { String::new() } else { format!("({place}) ") };
            out.push(Rejected { name: name.into(), why: format!("{place}{why}") });
        }
    };
    for contender in &explanation.contenders {
        let gain = contender.gain;
        let why = if stands {
            format!("gains {gain:.0} in ln L where the cause gains {top:.0}")
        } else if contender.merit < LEAST_MERIT {
            format!("gains {gain:.1} in ln L, no more than its parameters are worth")
        } else {
            let left = 100.0 * (1.0 - explained);
            format!("gains {gain:.0} in ln L, yet all causes together leave {left:.0} % unexplained")
        };
        say(contender.name, &contender.place, why);
    }
    for Dropped { name, place, gain, fitted } in &explanation.dropped {
        let how = if *fitted { "fitted to a few recordings" } else { "at the first look" };
        say(
            name,
            place,
            format!("{how} promises {:.0} in ln L on all, less than those that were fitted to them", gain.max(0.0)),
        );
    }
    out
}

/// What the causes do to recordings that took no part, `held_out` in words. Where they do not stand, the rig stays as it
/// was.
pub fn fit(proof: Option<Proof>, stands: bool, held_out: String) -> (Fit, Vec<HeldOut>) {
    let metric = "−ln L for each frequency, above that of the right rig".to_owned();
    let nothing = Fit { metric, held_out, before: 0.0, after: 0.0, noise_floor: 0.0, p_value: 1.0 };
    let Some(proof) = proof else { return (nothing, Vec::new()) };
    let fit = Fit { before: proof.before_each, noise_floor: proof.floor_each, ..nothing };
    if stands {
        (Fit { after: proof.after_each, p_value: proof.p_value, ..fit }, proof.traces)
    } else {
        let traces = proof.traces.into_iter().map(|t| HeldOut { after: t.before.clone(), ..t }).collect();
        (Fit { after: fit.before, ..fit }, traces)
    }
}
