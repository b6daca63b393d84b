//! What a candidate must be, beside its gain, to be a cause.

use super::candidate::Candidate;
use super::data::{Data, Point};
use super::observation::duration_s;
use super::refit::refit;
use super::settings::{GateSettings, LikelihoodSettings};
use super::unsteady::is_fleeting;
use crate::diagnose::result::Fit;
use crate::rig::effect::component::{Component, Part};
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::{EffectEntry, Rig};

const GATE: GateSettings = GateSettings::DEFAULT;
const LIKELIHOOD: LikelihoodSettings = LikelihoodSettings::DEFAULT;

/// Whether a candidate is no tone from elsewhere: a mode is wider than a line in the finest of the spectra, and rings all the time.
pub fn is_no_tone(candidate: &Candidate) -> bool {
    let Some(mode) = candidate.effect().filter(|e| e.kind == EffectKind::StructuralResonance) else { return true };
    let number = |key: ParameterKey| mode.number(key).unwrap_or_default();
    let frequency_hz = number(ParameterKey::FrequencyHz);
    let half_power_hz = 2.0 * number(ParameterKey::DampingRatio) * frequency_hz;
    let observations = candidate.model.data.observations;
    let bins_hz = observations.iter().map(|o| o.hz(1.0));
    half_power_hz > (LIKELIHOOD.tapers + 2) as f64 * bins_hz.fold(f64::MAX, f64::min)
        && !is_fleeting(observations, frequency_hz, half_power_hz)
}

/// Whether a candidate is a mode of more damping than a structure has, which is a broad tilt of the spectrum, or a damper that locks
/// its component, as dry friction does.
pub fn is_overdamped(candidate: &Candidate) -> bool {
    let Some(effect) = candidate.effect() else { return false };
    if effect.kind == EffectKind::StructuralResonance {
        let greatest = effect.definition().parameter(ParameterKey::DampingRatio).map_or(1.0, |p| p.search_range.1);
        return effect.number(ParameterKey::DampingRatio).is_some_and(|ratio| ratio > greatest);
    }
    let Some((part, damping)) = damped(&effect, &candidate.model.rig) else { return false };
    damping > (GATE.most_critical * 2.0 * (part.mass * part.stiffness).sqrt()).max(part.damping)
}

/// The component of a damper between a part and the ground, and its damping with it.
pub fn damped(effect: &EffectEntry, rig: &Rig) -> Option<(Part, f64)> {
    let part = Component::parse(effect.text(ParameterKey::Component)?)?.part_of(&rig.model);
    let damping = match effect.kind {
        EffectKind::DampingChange => effect.number(ParameterKey::Value)?,
        EffectKind::ViscousFriction => part.damping + effect.number(ParameterKey::DampingNSPerM)?,
        _ => return None,
    };
    (part.stiffness > 0.0).then_some((part, damping))
}

/// Whether a candidate is a sensor's gain that the noise does not show: its colours are no less than without it. What a first cause
/// has wrong of the lines is no gain.
pub fn is_gain_of_lines_alone(candidate: &Candidate, without: &Point) -> bool {
    let data = candidate.model.data;
    candidate.kind == EffectKind::SensorGain && data.colours_prior(&candidate.point) >= data.colours_prior(without)
}

/// Whether held-out recordings have a candidate's effect too, `held_null` being −ln there without it and `held_out` what it gains:
/// as much as in as many of the fitted recordings, or, where theirs is another speed or load that shows less of it, most of
/// what the effect gains at its best there.
pub fn is_in(held_data: &Data, held_null: f64, held_out: f64, candidate: &Candidate) -> bool {
    let share = duration_s(held_data.observations) / duration_s(candidate.model.data.observations);
    let at_best = || {
        let fitted = refit(held_data, &candidate.model, &candidate.point);
        fitted.map_or(f64::INFINITY, |point| held_null - point.objective())
    };
    held_out > GATE.held_out
        && (held_out > GATE.held_out_share * share * candidate.gain || held_out > GATE.agreement * at_best())
}

/// Whether simulations without a cause are farther from the held-out recordings than a healthy machine's.
pub fn is_unlike(fit: &Fit) -> bool {
    fit.before > GATE.unlike * fit.noise_floor
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::spectral::fit::Model;
    use crate::diagnose::spectral::imperfect::testing::observed;
    use crate::diagnose::spectral::unevenness::UnevenMachines;
    use crate::rig::test_support::nominal;

    /// A resonance, and a mode that is a tilt of the spectrum.
    #[test]
    fn null_a_mode_beyond_the_damping_of_structures_is_none() {
        let observations = [observed(&nominal(), 500.0, &Point::default().in_recordings(1, 0))];
        let orders = nominal().bearing().unwrap().bearing.geometry().orders();
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let of = |ratio: f64| {
            let numbers = [(ParameterKey::FrequencyHz, 900.0), (ParameterKey::DampingRatio, ratio)];
            let mode = EffectEntry::new(EffectKind::StructuralResonance, &numbers);
            let model = Model::fixed(&data, nominal().with_effect(mode));
            let (kind, place) = (EffectKind::StructuralResonance, "ay".into());
            is_overdamped(&Candidate { kind, place, model, point: Point::default(), gain: 700.0, phase: 0.0 })
        };
        assert!(of(0.7) && !of(0.1));
    }

    /// Dampers of a housing, and one that holds it fast.
    #[test]
    fn null_a_damper_that_locks_its_component_is_none() {
        let observations = [observed(&nominal(), 500.0, &Point::default().in_recordings(1, 0))];
        let orders = nominal().bearing().unwrap().bearing.geometry().orders();
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let part = Component::Outer.part_of(&nominal().model);
        let critical = 2.0 * (part.mass * part.stiffness).sqrt();
        let is_locked = |kind: EffectKind, key: ParameterKey, ratio: f64| {
            let damper = EffectEntry::new(kind, &[(key, ratio * critical)]).with_text(ParameterKey::Component, "outer");
            let model = Model::fixed(&data, nominal().with_effect(damper));
            is_overdamped(&Candidate {
                kind,
                place: "outer".into(),
                model,
                point: Point::default(),
                gain: 700.0,
                phase: 0.0,
            })
        };
        for (kind, key) in [
            (EffectKind::DampingChange, ParameterKey::Value),
            (EffectKind::ViscousFriction, ParameterKey::DampingNSPerM),
        ] {
            assert!(is_locked(kind, key, 70.0) && !is_locked(kind, key, 5.0), "{kind}");
        }
    }

    /// A gain that leaves the noise as it is or moves it away, beside one that takes its level.
    #[test]
    fn null_a_gain_of_the_lines_alone_is_none() {
        let observations = [observed(&nominal(), 500.0, &Point::default().in_recordings(1, 0))];
        let orders = nominal().bearing().unwrap().bearing.geometry().orders();
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let model = Model::fixed(&data, nominal());
        let with_level = |level: f64| {
            let mut point = model.start().unwrap();
            point.colour[0].iter_mut().for_each(|knot| *knot = level);
            point
        };
        let of = |kind, without: f64, with: f64| {
            let (place, point) = ("ax".into(), with_level(with));
            let candidate = Candidate { kind, place, model: model.clone(), point, gain: 700.0, phase: 0.0 };
            is_gain_of_lines_alone(&candidate, &with_level(without))
        };
        assert!(!of(EffectKind::SensorGain, -0.2, 0.01));
        assert!(of(EffectKind::SensorGain, 0.0, 0.2) && of(EffectKind::SensorGain, 0.0, 0.0));
        assert!(!of(EffectKind::StiffnessChange, 0.0, 0.2));
    }

    /// Of a healthy machine, and of one of which a friction takes the lines.
    #[test]
    fn null_simulations_that_are_far_from_the_recordings_are_no_all_clear() {
        let of = |before: f64| is_unlike(&Fit { before, noise_floor: 1.29, ..Fit::default() });
        assert!(!of(1.39) && of(2.58));
    }
}
