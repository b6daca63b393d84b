//! Causes, rejected candidates and fit of a diagnosis, from the result of model selection.

use crate::rig::config::RigKind;
use crate::rig::effect::{EffectKind, ParameterKey};
use std::collections::BTreeMap;
use std::fmt;

use super::acquisition::Fault;
use super::explain::{Explanation, LEAST_BIC_GAIN, Selected};
use super::model_selection::{Dropped, Stage};
use super::result::{Cause, Fit, Fitted, HeldOut, Parameter, Rejected};
use super::validation::Validation;
use crate::identify::calibrate::estimate::{Estimate, ParameterPrior, covariance_under, estimates};
use crate::identify::likelihood::problem::Problem;
use crate::identify::likelihood::search::Optimum;
use crate::rig::{EffectEntry, Rig, RigError};
use crate::stats::format::by_chance;

/// Kind of rig of the stated equations.
const KIND: RigKind = RigKind::Bearing5Dof;

/// Cause of an acquisition fault.
pub fn fault_cause(fault: &Fault) -> Cause {
    Cause {
        name: fault.effect.kind.to_string(),
        probability: 0.99,
        parameters: fault.effect.parameters.iter().map(|(key, value)| (key.to_string(), value.into())).collect(),
        interval95: BTreeMap::new(),
        evidence: fault.evidence.clone(),
        equation: fault.effect.equation(KIND),
    }
}

/// Estimates of the effects' parameters and of the rig's unknown ones, the first `unknown` coordinates. The interval of a time
/// is no narrower than one sample.
///
/// # Errors
/// Errors of the rig, none that the search has not met.
pub fn parameters(
    problem: &Problem,
    found: &Optimum,
    before: &Rig,
    unknown: usize,
    prior: &ParameterPrior,
) -> Result<(Vec<Estimate>, Vec<Fitted>), RigError> {
    let covariance =
        covariance_under(prior, &problem.expand_with(&prior.coordinates, &found.point)?, problem.coordinates.len());
    let start: Vec<f64> = problem.coordinates.iter().map(|c| before.get(c.key).unwrap_or_default()).collect();
    let mut all = estimates(&problem.coordinates, &start, &found.point.coordinates, &covariance);
    let mut effects = all.split_off(unknown.min(all.len()));
    let half_a_sample_s = problem.observed.first().map_or(0.0, |o| 0.5 / o.condition.sample_rate_hz);
    for estimate in effects.iter_mut().filter(|e| e.key.quantity() == ParameterKey::TimeS.name()) {
        let [from, to] = estimate.interval95;
        estimate.interval95 = [from.min(estimate.value - half_a_sample_s), to.max(estimate.value + half_a_sample_s)];
    }
    let along = all.into_iter().map(|e| (e.key.to_string(), e.value, e.interval95)).collect();
    Ok((effects, along))
}

/// Causes for the effects that `corrected` has beyond `before`, the most probable first. The effects are in the order of the
/// kept candidates.
pub fn causes(
    corrected: &Rig,
    before: &Rig,
    values: &[Estimate],
    explanation: &Explanation,
    validation: Option<&Validation>,
) -> Vec<Cause> {
    let added = corrected.effects.iter().enumerate().skip(before.effects.len());
    let cause = |((index, effect), choice): ((usize, &EffectEntry), &Selected)| {
        let parameters = stated(effect);
        let estimate =
            |name: &str| values.iter().find(|e| e.key.of_effect(index).is_some_and(|key| key.name() == name));
        Cause {
            name: effect.kind.to_string(),
            probability: choice.probability(),
            interval95: parameters.keys().filter_map(|key| Some((key.clone(), estimate(key)?.interval95))).collect(),
            parameters,
            evidence: evidence(choice, explanation, validation),
            equation: effect.equation(KIND),
        }
    };
    let mut out: Vec<Cause> = added.zip(&explanation.kept).map(cause).collect();
    out.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    out
}

/// Parameters of the vocabulary, with component and channel.
fn stated(effect: &EffectEntry) -> BTreeMap<String, Parameter> {
    let vocabulary = effect.definition().parameters.iter().filter(|p| p.in_vocabulary());
    let keys: Vec<ParameterKey> =
        vocabulary.map(|p| p.key).chain([ParameterKey::Component, ParameterKey::Channel]).collect();
    let all = effect.parameters.iter().filter(|(key, _)| keys.contains(key));
    all.map(|(key, value)| (key.to_string(), value.into())).collect()
}

/// Log-likelihood gain of the cause and of the next best candidate, in a sentence.
fn evidence(choice: &Selected, explanation: &Explanation, validation: Option<&Validation>) -> String {
    let next = choice.rivals.iter().find(|c| !explanation.keeps(c.kind));
    let beside = next.map_or(String::new(), |n| {
        format!("; the next best candidate, {}, gains {:.0}", n.kind, n.log_likelihood_gain)
    });
    let on = validation.map_or(String::new(), |p| {
        format!(" and {:.0} on the held-out ones ({})", p.before - p.after, by_chance(p.p_value))
    });
    format!("Gain of {:.0} in ln L on the fitted recordings{on}{beside}.", choice.cause.log_likelihood_gain)
}

/// Reason to reject the best explanation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Failure {
    /// Share of the lack of fit that is left unexplained.
    Leaves(f64),
    /// No significant gain on held-out recordings.
    NotConfirmed,
    /// Ratio of the held-out error to that of the rig without the causes.
    Errs(f64),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Leaves(share) => {
                write!(f, "all causes together leave {:.0} % of the mismatch unexplained", 100.0 * share)
            }
            Self::NotConfirmed => f.write_str("held-out recordings do not confirm it"),
            Self::Errs(times) => {
                write!(f, "with all causes together the held-out error is {times:.1} times that without them")
            }
        }
    }
}

impl Failure {
    /// Caveat in a sentence; `asked` is the share that an explanation must explain.
    pub fn caveat(self, asked: f64) -> String {
        match self {
            Self::Leaves(share) => format!(
                "The best explanation in the vocabulary explains {:.0} % of the mismatch; {:.0} % are required.",
                100.0 * (1.0 - share),
                100.0 * asked
            ),
            _ => format!("Best explanation in the vocabulary: {self}."),
        }
    }
}

/// Rejected candidates of the selection with reasons; `failure` is the reason to reject the kept causes too.
pub fn rejected(explanation: &Explanation, failure: Option<Failure>) -> Vec<Rejected> {
    let causes = if explanation.kept.len() > 1 { "the causes together gain" } else { "the cause gains" };
    let mut out: Vec<Rejected> = Vec::new();
    let mut say = |kind: EffectKind, place: &str, why: String| {
        let told = failure.is_none() && explanation.keeps(kind) || out.iter().any(|r| r.name == kind.name());
        if !told {
            let place = if place.is_empty() { String::new() } else { format!("({place}) ") };
            out.push(Rejected { name: kind.to_string(), why: format!("{place}{why}") });
        }
    };
    for candidate in &explanation.candidates {
        let log_likelihood_gain = candidate.log_likelihood_gain;
        let why = match failure {
            None => {
                format!("gains {log_likelihood_gain:.0} in ln L, {causes} {:.0}", explanation.log_likelihood_gain)
            }
            Some(_) if candidate.bic_gain < LEAST_BIC_GAIN => {
                format!("gains {log_likelihood_gain:.1} in ln L, not more than the BIC penalty of its parameters")
            }
            Some(failure) => format!("gains {log_likelihood_gain:.0} in ln L, but {failure}"),
        };
        say(candidate.kind, &candidate.place, why);
    }
    for Dropped { kind, place, log_likelihood_gain, at } in &explanation.dropped {
        let scores = format!("expected gain of {:.0} in ln L", log_likelihood_gain.max(0.0));
        let why = match at {
            Stage::Screened => format!("after screening: {scores}, less than the candidates fitted to all recordings"),
            Stage::Fitted => {
                format!("fitted to a subset of the recordings: {scores}, less than the candidates fitted to all")
            }
            Stage::Invalid => {
                format!("{scores}, but only with implausible parameters or where the simulation fails")
            }
        };
        say(*kind, place, why);
    }
    out
}

/// Fit to held-out recordings, which `held_out` describes, and their traces. If the causes are rejected, both are those of the
/// rig without them.
pub fn fit(validation: Option<Validation>, stands: bool, held_out: String) -> (Fit, Vec<HeldOut>) {
    let metric = "−ln L per frequency bin, above that of the true rig".to_owned();
    let nothing = Fit { metric, held_out, before: 0.0, after: 0.0, noise_floor: 0.0, p_value: 1.0 };
    let Some(validation) = validation else { return (nothing, Vec::new()) };
    let fit = Fit { before: validation.before_each, noise_floor: validation.floor_each, ..nothing };
    if stands {
        (Fit { after: validation.after_each, p_value: validation.p_value, ..fit }, validation.traces)
    } else {
        let traces = validation.traces.into_iter().map(|t| HeldOut { after: t.before.clone(), ..t }).collect();
        (Fit { after: fit.before, ..fit }, traces)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::data_split::DataSplit;
    use crate::diagnose::explain::NullFit;
    use crate::diagnose::model_selection::Candidate;
    use crate::diagnose::tests::recordings;
    use crate::rig::effect::EffectKind;
    use crate::rig::test_support::nominal;

    /// A wrong explanation may gain more alone than either of two right ones.
    #[test]
    fn what_lost_to_two_causes_is_set_against_both() {
        let split = DataSplit::new(&recordings(&nominal(), 3)).unwrap();
        let null_fit = NullFit::new(&nominal(), &split, 3).unwrap();
        let candidate = |kind: EffectKind, log_likelihood_gain: f64| Candidate {
            kind,
            place: String::new(),
            problem: null_fit.problem.clone(),
            found: null_fit.found.clone(),
            bic_gain: log_likelihood_gain,
            log_likelihood_gain,
        };
        let choice = |all: &[(EffectKind, f64)]| {
            let rivals: Vec<_> = all.iter().map(|(kind, gain)| candidate(*kind, *gain)).collect();
            Selected { cause: rivals[0].clone(), rivals, left: null_fit.lack_of_fit }
        };
        let explanation = Explanation {
            candidates: choice(&[(EffectKind::SensorGain, 930.0), (EffectKind::BallDefect, 720.0)]).rivals,
            kept: vec![
                choice(&[(EffectKind::BallDefect, 720.0), (EffectKind::Unbalance, 400.0)]),
                choice(&[(EffectKind::LoadStep, 280.0), (EffectKind::Shock, 90.0)]),
            ],
            log_likelihood_gain: 1000.0,
            ..Explanation::nothing(null_fit.lack_of_fit)
        };
        let [lost] = &rejected(&explanation, None)[..] else { panic!() };
        assert_eq!(lost.why, "gains 930 in ln L, the causes together gain 1000");
        let says = |n: usize| evidence(&explanation.kept[n], &explanation, None);
        assert_eq!(
            says(0),
            "Gain of 720 in ln L on the fitted recordings; the next best candidate, unbalance, gains 400."
        );
        assert_eq!(says(1), "Gain of 280 in ln L on the fitted recordings; the next best candidate, shock, gains 90.");
    }
}
