//! What every machine has within the tolerances of its make, load and drive, and of what is stated of it, which is no cause.

use super::candidate::Candidate;
use super::hypotheses::LOAD_COMPONENT;
use super::observation::{duration_s, mean_load_n};
use super::settings::{GateSettings, ToleranceSettings};
use crate::rig::effect::component::Component;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::{EffectEntry, Rig};

const GATE: GateSettings = GateSettings::DEFAULT;
const SETTINGS: ToleranceSettings = ToleranceSettings::DEFAULT;

/// Index of the candidate to be judged: the first, an error of the stated load that gains nearly as much, or, of a first one within
/// tolerances, a cause of its kind that gains what is asked and as much: an all-clear must not be chance.
pub fn first_to_judge(found: &[Candidate], asked: f64) -> usize {
    let first = &found[0];
    let is_close = |c: &Candidate| c.gain > first.gain - SETTINGS.load_nats - SETTINGS.load_share_of_gain * first.gain;
    let load_error = found.iter().position(|c| is_load_error(c) && is_close(c));
    let is_alike = |c: &Candidate| c.gain > asked && c.merit() > first.merit() - GATE.model_error_nats(first.gain);
    let is_cause = |c: &Candidate| c.kind == first.kind && !is_tolerance(c) && is_alike(c);
    let cause = || found.iter().position(is_cause).filter(|_| is_tolerance(first));
    load_error.or_else(cause).unwrap_or(0)
}

/// Whether a candidate is an error of the stated load.
fn is_load_error(candidate: &Candidate) -> bool {
    candidate.place == LOAD_COMPONENT && is_small_force(candidate)
}

/// Whether a candidate is a constant force as small as the load is known, in size or in direction.
fn is_small_force(candidate: &Candidate) -> bool {
    let force = candidate.effect().and_then(|e| e.number(ParameterKey::ForceN)).unwrap_or_default();
    let least = SETTINGS.load_share * mean_load_n(candidate.model.data.observations);
    candidate.kind == EffectKind::ConstantForce && force.abs() < least
}

/// Whether a candidate is what every machine has: an error of the stated load, or an effect within its tolerances.
pub fn is_tolerance(candidate: &Candidate) -> bool {
    let each = candidate.model.data.observations.iter();
    let seconds = each.map(|o| duration_s(std::slice::from_ref(o))).fold(0.0, f64::max);
    let is_within =
        |effect: &EffectEntry| is_within_tolerance(effect, seconds) || is_statement_error(effect, &candidate.model.rig);
    is_small_force(candidate) || candidate.effect().is_some_and(|effect| is_within(&effect))
}

/// Whether an effect changes a mass, a stiffness or a damping by no more than a statement of it is right by.
fn is_statement_error(effect: &EffectEntry, rig: &Rig) -> bool {
    let [of_mass_and_stiffness, of_damping] = SETTINGS.stated;
    let changed = || {
        let component = Component::parse(effect.text(ParameterKey::Component)?)?;
        let part = component.part_of(&rig.model);
        let of_contact = || rig.bearing().map(|machine| machine.bearing.contact_stiffness_n_per_m1_5);
        let (stated, share) = match effect.kind {
            EffectKind::MassChange => (part.mass, of_mass_and_stiffness),
            EffectKind::StiffnessChange if component == Component::Bearing => (of_contact()?, of_mass_and_stiffness),
            EffectKind::StiffnessChange => (part.stiffness, of_mass_and_stiffness),
            EffectKind::DampingChange => (part.damping, of_damping),
            _ => return None,
        };
        Some((effect.number(ParameterKey::Value)? - stated).abs() < share * stated)
    };
    changed().unwrap_or(false)
}

/// Whether an effect is roundness or finish of races and balls, or a speed that wanders within recordings of some length, s.
fn is_within_tolerance(effect: &EffectEntry, seconds: f64) -> bool {
    let number = |key: ParameterKey| effect.number(key).unwrap_or_default().abs();
    match effect.kind {
        EffectKind::OuterRaceWaviness | EffectKind::InnerRaceWaviness => {
            let is_roundness = number(ParameterKey::Lobes) <= SETTINGS.round_lobes;
            number(ParameterKey::AmplitudeM) <= if is_roundness { SETTINGS.round_m } else { SETTINGS.wave_m }
        }
        EffectKind::OuterRaceDefect | EffectKind::InnerRaceDefect | EffectKind::BallDefect => {
            number(ParameterKey::DepthM) <= SETTINGS.finish_m
        }
        // Standard deviation of a ramp.
        EffectKind::SpeedDrift => number(ParameterKey::RatePerS) * seconds / 12f64.sqrt() <= SETTINGS.wander,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::spectral::causes::probability;
    use crate::diagnose::spectral::data::{Data, Point};
    use crate::diagnose::spectral::fit::Model;
    use crate::diagnose::spectral::imperfect::testing::observed;
    use crate::diagnose::spectral::unevenness::UnevenMachines;
    use crate::rig::test_support::nominal;

    /// Where three lobes, a race's roundness, and five gain alike, five are judged, and as no more probable than not.
    #[test]
    fn null_an_all_clear_is_not_chance() {
        use ParameterKey::{AmplitudeM, Lobes};
        let orders = nominal().bearing().unwrap().bearing.geometry().orders();
        let observations = [observed(&nominal(), 500.0, &Point::default().in_recordings(1, 0))];
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let waves = |lobes: f64, gain: f64| {
            let kind = EffectKind::OuterRaceWaviness;
            let effect = EffectEntry::new(kind, &[(AmplitudeM, 3e-7), (Lobes, lobes)]);
            let model = Model::fixed(&data, nominal().with_effect(effect));
            let point = model.start().unwrap();
            Candidate { kind, place: format!("{lobes} lobes"), model, point, gain, phase: 0.0 }
        };
        let judged =
            |gain: f64, asked: f64| first_to_judge(&[waves(3.0, 650.0), waves(2.0, 649.0), waves(5.0, gain)], asked);
        assert_eq!(judged(645.0, 100.0), 2);
        assert_eq!(judged(600.0, 100.0), 0);
        assert_eq!(judged(645.0, 646.0), 0);
        assert_eq!(first_to_judge(&[waves(5.0, 650.0), waves(8.0, 649.0), waves(3.0, 645.0)], 100.0), 0);
        let doubted = probability(&waves(5.0, 645.0), &[waves(3.0, 650.0)], false);
        assert!((0.3..0.5).contains(&doubted), "{doubted}");
        assert!(probability(&waves(5.0, 650.0), &[waves(8.0, 650.0)], false) > 0.9);
    }

    #[test]
    fn what_is_stated_is_right_within_a_tolerance() {
        let outer = Component::parse("outer").unwrap().part_of(&nominal().model);
        let is_error = |kind, value: f64| {
            let effect =
                EffectEntry::new(kind, &[(ParameterKey::Value, value)]).with_text(ParameterKey::Component, "outer");
            is_statement_error(&effect, &nominal())
        };
        use EffectKind::{DampingChange, MassChange, StiffnessChange};
        assert!(
            is_error(StiffnessChange, 1.005 * outer.stiffness) && !is_error(StiffnessChange, 1.02 * outer.stiffness)
        );
        assert!(is_error(MassChange, 0.995 * outer.mass) && !is_error(MassChange, 0.98 * outer.mass));
        assert!(is_error(DampingChange, 1.04 * outer.damping) && !is_error(DampingChange, 0.9 * outer.damping));
        let contact = nominal().bearing().unwrap().bearing.contact_stiffness_n_per_m1_5;
        let stiffer = EffectEntry::new(StiffnessChange, &[(ParameterKey::Value, 1.005 * contact)]);
        assert!(is_statement_error(&stiffer.with_text(ParameterKey::Component, "bearing"), &nominal()));
    }

    #[test]
    fn tolerances_are_of_make_and_drive() {
        use ParameterKey::{AmplitudeM, DepthM, Lobes, RatePerS};
        let is_tolerated =
            |kind, numbers: &[(ParameterKey, f64)]| is_within_tolerance(&EffectEntry::new(kind, numbers), 1.0);
        let round =
            |amplitude, lobes| is_tolerated(EffectKind::InnerRaceWaviness, &[(AmplitudeM, amplitude), (Lobes, lobes)]);
        assert!(round(3e-7, 2.0) && round(-3e-7, 3.0) && !round(1e-6, 2.0) && !round(3e-7, 9.0) && round(2e-8, 9.0));
        let deep = |depth| is_tolerated(EffectKind::OuterRaceDefect, &[(DepthM, depth)]);
        assert!(deep(1e-8) && !deep(1e-6));
        let drifting = |rate| is_tolerated(EffectKind::SpeedDrift, &[(RatePerS, rate)]);
        assert!(drifting(-0.01) && !drifting(0.03));
        assert!(!is_tolerated(EffectKind::Unbalance, &[(ParameterKey::UnbalanceKgM, 1e-9)]));
    }
}
