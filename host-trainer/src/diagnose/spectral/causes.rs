//! Causes and their numbers: probability, intervals, evidence.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;

use super::candidate::Candidate;
use super::data::Point;
use super::events::{Event, Occurrence};
use super::expansion::Expansion;
use super::fit::Model;
use super::gate::is_overdamped;
use super::settings::{EventSettings, GateSettings, IntervalSettings};
use super::text;
use super::tolerance::is_tolerance;
use crate::diagnose::result::{Aspect, Cause, Fitted, Parameter, Test};
use crate::identify::likelihood::coordinate::{Coordinate, Scale};
use crate::identify::likelihood::observed::CHANNELS;
use crate::rig::EffectEntry;
use crate::rig::config::{RigKey, RigKind};
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::stats::significance::Z975;

const GATE: GateSettings = GateSettings::DEFAULT;
const INTERVALS: IntervalSettings = IntervalSettings::DEFAULT;

/// Cause that passed the gate.
pub struct Accepted<'d, 'a> {
    /// Its fit.
    pub candidate: Candidate<'d, 'a>,
    /// Gain on the held-out recordings.
    pub held_out: f64,
    /// Probability.
    pub probability: f64,
    /// Other candidates, best first.
    pub rivals: Vec<Candidate<'d, 'a>>,
    /// Index of the effect in the rig.
    pub effect: usize,
    /// Gain of both, where it was found at once with another.
    pub beside: Option<Beside>,
    /// Whether it is a dry friction that holds its component, whose force the motion does not show.
    pub holds: bool,
}

/// Gain of two causes that were found at once.
#[derive(Clone, Debug)]
pub struct Beside {
    /// Gain of both.
    pub gain: f64,
    /// Next best pair and its gain.
    pub next: Option<(String, f64)>,
}

/// Probability of a candidate among its rivals, others of its kind only if they are no cause: a small gain, and one in what a first
/// cause leaves, may be an imperfection of the machine.
pub fn probability(best: &Candidate, rivals: &[Candidate], is_second: bool) -> f64 {
    let others = rivals.iter().filter(|c| c.kind != best.kind || is_tolerance(c)).map(|c| c.merit() - best.merit());
    probability_of(best.gain, others, best.gain, is_second)
}

/// Probability of a cause of some gain among others of other merits, as differences from that of the `explained` gain it is part of.
pub fn probability_of(gain: f64, others: impl Iterator<Item = f64>, explained: f64, is_second: bool) -> f64 {
    let scale = GATE.model_error_nats(explained);
    let others: f64 = others.map(|merit| (merit / scale).exp()).sum();
    let by_gain = 1.0 - GATE.doubt / gain.max(1.0).sqrt();
    let by_rank = if is_second { GATE.second_trust } else { 1.0 };
    (by_gain.max(0.0) * by_rank / (1.0 + others)).min(GATE.most_probable)
}

/// The damper that holds a component as a dry friction does: of all `refused`, one that gains as much.
pub fn holding<'c, 'd, 'a>(friction: &Candidate, refused: &'c [Candidate<'d, 'a>]) -> Option<&'c Candidate<'d, 'a>> {
    let least = friction.gain - GATE.model_error_nats(friction.gain);
    let locks = |c: &&Candidate| c.kind == EffectKind::DampingChange && c.place == friction.place && c.gain > least;
    let is_friction = friction.kind == EffectKind::CoulombFriction;
    refused.iter().filter(|_| is_friction).find(|c| locks(c) && is_overdamped(c))
}

/// Trust in causes by what they leave, and by what else changes the level.
#[derive(Clone, Copy, Debug)]
pub struct Trust {
    /// Whether the signals are steady: spikes and bursts of noise change the spectrum as all effects do but those of lines.
    pub is_steady: bool,
    /// Whether the converter keeps the level: steps as great as the signal change it and the spectrum, as a gain and a mode do.
    pub keeps_level: bool,
    /// Whether the noise is as behind a filter or mounting that the rig has not, which has a gain and broad modes of its own.
    pub is_filtered: bool,
    /// Share that is left of the lack of fit beyond chance.
    pub share: f64,
}

/// Whether an effect strikes, or sticks and slips, which can be taken for spikes.
pub fn may_strike(kind: EffectKind) -> bool {
    use EffectKind::{Backlash, CoulombFriction, EndStopContact, ExcessClearance};
    is_defect(kind) || matches!(kind, Backlash | CoulombFriction | EndStopContact | ExcessClearance)
}

fn is_defect(kind: EffectKind) -> bool {
    matches!(kind, EffectKind::OuterRaceDefect | EffectKind::InnerRaceDefect | EffectKind::BallDefect)
}

/// Whether an effect changes lines more than the noise between them.
fn is_of_lines(kind: EffectKind) -> bool {
    use EffectKind::{CageSlip, InnerRaceWaviness, Misalignment, OuterRaceWaviness, SpeedDrift, Unbalance};
    let is_other =
        matches!(kind, OuterRaceWaviness | InnerRaceWaviness | Unbalance | Misalignment | SpeedDrift | CageSlip);
    is_other || is_defect(kind)
}

/// Whether a mode is narrower than the edges of filters.
fn is_sharp(mode: &EffectEntry) -> bool {
    mode.number(ParameterKey::DampingRatio).is_some_and(|ratio| ratio < GATE.sharp_ratio)
}

impl Trust {
    /// Factor of the probability of an effect.
    pub fn of(self, effect: &EffectEntry) -> f64 {
        let [full, none] = GATE.left_share;
        let trust = (1.0 - (self.share - full) / (none - full)).clamp(0.0, 1.0);
        match effect.kind {
            kind if is_defect(kind) => trust.max(GATE.defect_trust),
            kind if self.may_be_of_signal(effect) || !is_of_lines(kind) && !self.is_steady => 0.0,
            _ => trust,
        }
    }

    /// Whether what is between the machine and its recording may change levels and spectra as an effect does.
    fn may_be_of_signal(self, effect: &EffectEntry) -> bool {
        match effect.kind {
            EffectKind::SensorGain => !self.keeps_level || self.is_filtered,
            EffectKind::StructuralResonance => !self.keeps_level || self.is_filtered && !is_sharp(effect),
            _ => false,
        }
    }

    /// Whether an effect of a probability by itself is stated as a cause.
    pub fn states(self, probability: f64, effect: &EffectEntry) -> bool {
        probability * self.of(effect) >= GATE.least_probable.min(probability)
    }
}

/// Intervals of the parameters of effects, by the effect's index and key.
pub type Intervals = BTreeMap<(usize, ParameterKey), [f64; 2]>;

/// 95 % interval of each coordinate, of an effect with the error of its form: values of the effects by index and key, and the rig's
/// unknown numbers.
pub fn estimates(model: &Model, point: &Point, unknown: usize) -> (Intervals, Vec<Fitted>) {
    let (mut effects, mut numbers) = (BTreeMap::new(), Vec::new());
    let count = model.coordinates.len();
    if count == 0 {
        return (effects, numbers);
    }
    // A rig that cannot run next to the estimate has no interval.
    let Ok(expansion) = Expansion::new(model, point) else { return (effects, numbers) };
    let all = expansion.gradient.len();
    let inverse = Mat::from_fn(all, all, |a, b| expansion.information[(a, b)] + if a == b { 1e-9 } else { 0.0 })
        .partial_piv_lu()
        .inverse();
    // With one channel there is no phase between them, and a defect may be on either side of the load.
    let has_phase = model.data.observations.iter().any(|o| o.samples.iter().all(Option::is_some));
    for (a, coordinate) in model.coordinates.iter().enumerate() {
        // White's widening: where recordings disagree more than the information says.
        let pulls = expansion.pieces.iter().map(|g| (0..all).map(|b| inverse[(a, b)] * g[b]).sum::<f64>().powi(2));
        let variance = inverse[(a, a)].max(pulls.sum::<f64>()).max(0.0);
        let half = Z975 * variance.sqrt();
        let value = coordinate.to_value(point.values[a]);
        if a < unknown {
            numbers.push((coordinate.key.to_string(), value, ends(coordinate, value, half, 0.0)));
        } else if let RigKey::Effect { index, key } = coordinate.key {
            let kind = model.rig.effects[index].kind;
            let is_of_one = kind == EffectKind::OuterRaceDefect && key == ParameterKey::AngleRad && !has_phase;
            let of_form = match is_of_one {
                true => INTERVALS.angle_of_one_rad,
                false => INTERVALS.form_error(kind, key, value),
            };
            let ends = ends(coordinate, value, half, Z975 * of_form);
            effects.insert((index, key), if is_of_one { of_either_side(ends) } else { ends });
        }
    }
    (effects, numbers)
}

/// Ends of the interval of a value, from its half width in the coordinate and that by the error of a form in the value's own unit.
/// A number with a sign keeps it, and its interval ends at [`IntervalSettings::unknown_factor`] either way.
fn ends(coordinate: &Coordinate, value: f64, half: f64, of_form: f64) -> [f64; 2] {
    let half = match coordinate.scale {
        Scale::Log { .. } => half.hypot(of_form / value.abs()).min(INTERVALS.unknown_factor.ln()),
        Scale::Linear { unit } => half.hypot(of_form / unit),
    };
    let ends = [-half, half].map(|by| coordinate.to_value(coordinate.to_coordinate(value) + by));
    [ends[0].min(ends[1]), ends[0].max(ends[1])]
}

/// Interval of an angle with that of its mirror image across the load.
fn of_either_side([from, to]: [f64; 2]) -> [f64; 2] {
    [from.min(PI - to), to.max(PI - from)]
}

/// Ends of the interval of an effect's strength over the strength.
pub fn band(effect: &EffectEntry, accepted: &Accepted, values: &Intervals) -> [f64; 2] {
    let strength = accepted.candidate.model.coordinates.iter().find_map(|c| match c.key {
        RigKey::Effect { index, key } if index == accepted.effect => Some(key),
        _ => None,
    });
    let ends = strength.and_then(|key| Some((values.get(&(accepted.effect, key))?, effect.number(key)?)));
    ends.filter(|(_, value)| *value != 0.0).map_or([1.0, 1.0], |(ends, value)| ends.map(|end| end / value))
}

/// Parameters of the vocabulary, with the place, and the angle of an oblique force.
fn stated(effect: &EffectEntry) -> BTreeMap<String, Parameter> {
    let vocabulary = effect.definition().parameters.iter().filter(|p| p.in_vocabulary());
    let keys: Vec<ParameterKey> =
        vocabulary.map(|p| p.key).chain([ParameterKey::Component, ParameterKey::Channel]).collect();
    let is_oblique = effect.kind == EffectKind::ConstantForce && effect.number(ParameterKey::AngleRad) != Some(0.0);
    let is_stated = |key: &ParameterKey| keys.contains(key) || is_oblique && *key == ParameterKey::AngleRad;
    let all = effect.parameters.iter().filter(|(key, _)| is_stated(key));
    all.map(|(key, value)| (key.to_string(), value.into())).collect()
}

/// Cause of a candidate, `effect` as it was fitted in the end.
pub fn cause(accepted: &Accepted, effect: &EffectEntry, values: &Intervals) -> Cause {
    let mut parameters = stated(effect);
    if accepted.holds {
        parameters.remove(ParameterKey::ForceN.name());
    }
    let own = values.iter().filter(|((index, _), _)| *index == accepted.effect);
    for ((_, key), _) in own.filter(|(_, ends)| INTERVALS.is_of_unknown(**ends)) {
        parameters.remove(key.name());
    }
    let interval = |(key, ends): (&(usize, ParameterKey), &[f64; 2])| {
        (key.0 == accepted.effect && parameters.contains_key(key.1.name())).then(|| (key.1.to_string(), *ends))
    };
    Cause {
        name: effect.kind.to_string(),
        probability: accepted.probability,
        interval95: values.iter().filter_map(interval).collect(),
        parameters,
        evidence: text::evidence(accepted),
        equation: effect.equation(RigKind::Bearing5Dof),
        ..Cause::default()
    }
}

/// Cause of an event; `names` are those of all recordings.
pub fn event_cause(event: &Event, names: &[String], trust: Trust) -> Cause {
    let effect = event.mean();
    let mut parameters = stated(&effect);
    let mut equation = effect.equation(RigKind::Bearing5Dof);
    if !event.is_size_known {
        parameters.remove(event.size().name());
        equation = text::OF_UNKNOWN_SIZE.into();
    }
    let times: Vec<(String, f64)> = occurrences(event, names).map(|(o, name)| (name.clone(), o.time_s)).collect();
    Cause {
        name: effect.kind.to_string(),
        probability: event.probability * trust.of(&effect),
        parameters,
        evidence: text::event(&times, event.gain()),
        equation,
        ..Cause::default()
    }
}

/// Tests of an event in the recordings in which it happened; each of all `samples` was a time of each template.
pub fn event_tests<'e>(event: &'e Event, names: &'e [String], samples: usize) -> impl Iterator<Item = Test> + 'e {
    let tried = (samples * EventSettings::DEFAULT.templates()) as f64;
    occurrences(event, names).map(move |(o, name)| Test {
        aspect: Aspect::Time,
        channel: CHANNELS[o.channel],
        at: Some([o.time_s - 2e-3, o.time_s + 5e-3]),
        what: format!("{name}, {:.4} s: response to a {}", o.time_s, event.effect.kind),
        z: (2.0 * o.gain).sqrt(),
        p_value: (tried * (-o.gain).exp()).min(1.0),
        q_value: 1.0,
    })
}

/// Recordings in which an event happened, with their names.
fn occurrences<'e>(event: &'e Event, names: &'e [String]) -> impl Iterator<Item = (&'e Occurrence, &'e String)> {
    event.occurrences.iter().zip(names).filter(|(o, _)| o.is_event())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Behind a filter that the rig has not no gain is trusted, and of modes those narrower than its edges; behind a coarse converter none.
    #[test]
    fn null_a_gain_and_a_broad_mode_beside_a_filter_are_not_trusted() {
        let mode =
            |ratio: f64| EffectEntry::new(EffectKind::StructuralResonance, &[(ParameterKey::DampingRatio, ratio)]);
        let gain = EffectEntry::new(EffectKind::SensorGain, &[(ParameterKey::Value, 1.5)]);
        let damper = EffectEntry::new(EffectKind::ViscousFriction, &[(ParameterKey::DampingNSPerM, 1e3)]);
        let trusted = |keeps_level: bool, is_filtered: bool| {
            let trust = Trust { is_steady: true, keeps_level, is_filtered, share: 0.1 };
            [&mode(0.02), &mode(0.2), &gain, &damper].map(|effect| trust.of(effect))
        };
        assert_eq!(trusted(true, false), [1.0; 4]);
        assert_eq!(trusted(true, true), [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(trusted(false, false), [0.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn an_oblique_force_is_stated_with_its_angle() {
        let of = |angle_rad: f64| {
            let numbers = [(ParameterKey::ForceN, 300.0), (ParameterKey::AngleRad, angle_rad)];
            let force = EffectEntry::new(EffectKind::ConstantForce, &numbers);
            stated(&force.with_text(ParameterKey::Component, "inner-x")).into_keys().collect::<Vec<_>>()
        };
        assert_eq!(of(0.0), ["component", "force_n"]);
        assert_eq!(of(0.6), ["angle_rad", "component", "force_n"]);
    }

    /// Whatever the error, a force keeps its sign and its interval ends; one that could be of any size is not stated.
    #[test]
    fn invariant_a_number_keeps_its_sign_and_one_that_is_not_known_is_not_stated() {
        let key = RigKey::Effect { index: 0, key: ParameterKey::ForceN };
        let force = |sign: f64| Coordinate { key, scale: Scale::Log { sign }, moves_mean: true, moves_variance: true };
        let close = |[a, b]: [f64; 2], [c, d]: [f64; 2]| (a / c - 1.0).abs() + (b / d - 1.0).abs() < 1e-9;
        for (half, of_form, is_known) in [(0.1, 1.0, true), (1e-9, 30.0, true), (5.0, 1.0, false), (900.0, 0.0, false)]
        {
            let [from, to] = ends(&force(1.0), 25.0, half, of_form);
            assert!(0.0 < from && from < 25.0 && 25.0 < to && to.is_finite(), "{from} {to}");
            assert_eq!(INTERVALS.is_of_unknown([from, to]), !is_known, "{from} {to}");
            let mirrored = ends(&force(-1.0), -25.0, half, of_form);
            assert!(close(mirrored, [-to, -from]) && INTERVALS.is_of_unknown(mirrored) != is_known, "{mirrored:?}");
        }
    }
}
