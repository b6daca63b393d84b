//! Dry friction and dampers, which are one another at speeds below that at which the friction is rounded.

use super::candidate::{Candidate, NullFit};
use super::data::Point;
use super::gate::{damped, is_overdamped};
use super::hypotheses::{FASTEST_FRICTION_PER_S, Hypothesis};
use super::settings::SearchSettings;
use crate::rig::EffectEntry;
use crate::rig::effect::component::Component;
use crate::rig::effect::{EffectKind, ParameterKey};

const SETTINGS: SearchSettings = SearchSettings::DEFAULT;

/// The damper that a dry friction is at speeds below that at which it is rounded and, of a damper that locks its component, found so or
/// by itself, the friction; each is searched from the other's fit.
pub fn as_friction_or_damper<'d, 'a>(
    best_so_far: &Candidate<'d, 'a>,
    hypotheses: &[Hypothesis],
    null: &NullFit<'d, 'a>,
) -> Vec<Candidate<'d, 'a>> {
    let hypothesis = |kind: EffectKind| hypotheses.iter().find(|h| h.kind == kind && h.place == best_so_far.place);
    let both = (hypothesis(EffectKind::DampingChange), hypothesis(EffectKind::CoulombFriction), best_so_far.effect());
    let (Some(damper), Some(friction), Some(effect)) = both else { return Vec::new() };
    let as_damper = damper_of(&effect, null).and_then(|start| searched_from(best_so_far, damper, &start, null));
    let locking = as_damper.as_ref().unwrap_or(best_so_far);
    let start = || {
        let rounded = std::iter::once(&effect).chain(&friction.starts);
        let rounding = rounded.filter_map(|e| e.number(ParameterKey::RegularisationMPerS)).next()?;
        friction_of(&locking.effect().filter(|_| is_overdamped(locking))?, rounding, null)
    };
    let as_friction = start().and_then(|start| searched_from(locking, friction, &start, null));
    as_damper.into_iter().chain(as_friction).collect()
}

/// Search of a hypothesis at a start beside what another candidate's fit has of the machine.
fn searched_from<'d, 'a>(
    of: &Candidate,
    hypothesis: &Hypothesis,
    start: &EffectEntry,
    null: &NullFit<'d, 'a>,
) -> Option<Candidate<'d, 'a>> {
    let values = of.point.values[..null.model.coordinates.len()].to_vec();
    let beside = NullFit::new(&null.model, &Point { values, ..of.point.clone() });
    let (model, from) = beside.with_effect(hypothesis, &hypothesis.placed(start), false)?;
    let point = model.start_from(&from).ok()?;
    Some(null.candidate(hypothesis, model, point).searched(SETTINGS.steps[1]))
}

/// Damping of a dry friction's component with the friction's slope at rest; `None` of another effect.
fn damper_of(effect: &EffectEntry, null: &NullFit) -> Option<EffectEntry> {
    use ParameterKey::{ForceN, RegularisationMPerS, Value};
    let place = effect.text(ParameterKey::Component).filter(|_| effect.kind == EffectKind::CoulombFriction)?;
    let own = Component::parse(place)?.part_of(&null.rig.model).damping;
    let slope = effect.number(ForceN)? / effect.number(RegularisationMPerS)?;
    Some(EffectEntry::new(EffectKind::DampingChange, &[(Value, own + slope)]))
}

/// Dry friction, rounded at a speed, with a damper's slope at rest, or as much of it as is simulated.
fn friction_of(damper: &EffectEntry, rounding_m_per_s: f64, null: &NullFit) -> Option<EffectEntry> {
    use ParameterKey::{ForceN, RegularisationMPerS};
    let (part, damping) = damped(damper, &null.rig)?;
    let slope = (damping - part.damping).min(FASTEST_FRICTION_PER_S * part.mass);
    let numbers = [(ForceN, slope * rounding_m_per_s), (RegularisationMPerS, rounding_m_per_s)];
    Some(EffectEntry::new(EffectKind::CoulombFriction, &numbers))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::result::Cause;
    use crate::diagnose::spectral::candidate::best;
    use crate::diagnose::spectral::causes::{Accepted, Intervals, cause, holding};
    use crate::diagnose::spectral::data::Data;
    use crate::diagnose::spectral::fit::Model;
    use crate::diagnose::spectral::imperfect::testing::observed;
    use crate::diagnose::spectral::unevenness::UnevenMachines;
    use crate::rig::test_support::nominal;

    /// Machine whose housing has a damper, with the hypotheses of its diagnosis, to be asked something.
    fn with_damper(damping_n_s_per_m: f64, asked: impl Fn(&NullFit, &[Hypothesis])) {
        let numbers = [(ParameterKey::Value, damping_n_s_per_m)];
        let damper = EffectEntry::new(EffectKind::DampingChange, &numbers);
        let rig = nominal().with_effect(damper.with_text(ParameterKey::Component, "outer"));
        let orders = rig.bearing().unwrap().bearing.geometry().orders();
        let observations = [observed(&rig, 500.0, &Point::default().in_recordings(1, 0))];
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let model = Model::fixed(&data, nominal());
        let null = NullFit::new(&model, &model.search(model.start().unwrap(), 4).unwrap());
        asked(&null, &null.hypotheses());
    }

    fn of_housing(kind: EffectKind, hypotheses: &[Hypothesis]) -> &Hypothesis {
        hypotheses.iter().find(|h| h.kind == kind && h.place == "outer").unwrap()
    }

    fn fitted<'d, 'a>(hypothesis: &Hypothesis, start: EffectEntry, null: &NullFit<'d, 'a>) -> Candidate<'d, 'a> {
        best(null.started(hypothesis, &[start])).unwrap().searched(SETTINGS.steps[0])
    }

    /// A dry friction that is rounded far beyond the motion's speeds is a damper, with a number less; nothing else is tried as one.
    #[test]
    fn invariant_a_friction_rounded_beyond_the_motion_is_a_damper() {
        use ParameterKey::{ForceN, RegularisationMPerS, Value};
        with_damper(9e3, |null, hypotheses| {
            let friction = of_housing(EffectKind::CoulombFriction, hypotheses);
            let rounded = friction.starts[0].clone().with_number(ForceN, 3e3).with_number(RegularisationMPerS, 1.0);
            let own = nominal().bearing().unwrap().outer.damping_n_s_per_m;
            assert_eq!(damper_of(&rounded, null).unwrap().number(Value), Some(own + 3e3));
            let friction = fitted(friction, rounded, null);
            let damper = as_friction_or_damper(&friction, hypotheses, null).remove(0);
            assert!(friction.gain > 50.0 && damper.gain > friction.gain - 1.0, "{} {}", friction.gain, damper.gain);
            assert!(damper.merit() > friction.merit(), "{} {}", damper.merit(), friction.merit());
            let value = damper.effect().unwrap().number(Value).unwrap();
            assert!((value / 9e3 - 1.0).abs() < 0.1, "{value}");
            assert!(as_friction_or_damper(&damper, hypotheses, null).is_empty());
        });
    }

    /// A damper that locks its component is tried as dry friction, which gains as much, so that its force is not known.
    #[test]
    fn invariant_a_damper_that_locks_its_component_is_a_friction() {
        let part = Component::Outer.part_of(&nominal().model);
        let locked = 60.0 * (part.mass * part.stiffness).sqrt();
        with_damper(locked, |null, hypotheses| {
            let damping = of_housing(EffectKind::DampingChange, hypotheses);
            let start = damping.placed(&EffectEntry::new(damping.kind, &[(ParameterKey::Value, locked)]));
            let damper = fitted(damping, start, null);
            let [friction] = &as_friction_or_damper(&damper, hypotheses, null)[..] else { panic!("one") };
            assert_eq!(friction.kind, EffectKind::CoulombFriction);
            assert!(damper.gain > 50.0 && friction.gain > damper.gain - 6.0, "{} {}", damper.gain, friction.gain);
            let holds = |of: &Candidate, refused: &[Candidate]| holding(of, refused).is_some();
            assert!(holds(friction, std::slice::from_ref(&damper)) && !holds(friction, &[]));
            assert!(!holds(&damper, std::slice::from_ref(&damper)));
            let said = |holds: bool, values: &Intervals| {
                let candidate = friction.clone();
                let (rivals, beside) = (Vec::new(), None);
                let accepted =
                    Accepted { candidate, held_out: 20.0, probability: 0.9, rivals, effect: 0, beside, holds };
                cause(&accepted, &friction.effect().unwrap(), values)
            };
            let stated = |of: Cause| of.parameters.into_keys().collect::<Vec<_>>();
            let none = Intervals::new();
            assert_eq!(stated(said(false, &none)), ["component", "force_n"]);
            assert_eq!(stated(said(true, &none)), ["component"]);
            let of_any_size = Intervals::from([((0, ParameterKey::ForceN), [1e-2, 1e2])]);
            assert_eq!(stated(said(false, &of_any_size)), ["component"]);
            assert!(said(true, &none).evidence.ends_with("so that its force is not known."));
        });
    }
}
