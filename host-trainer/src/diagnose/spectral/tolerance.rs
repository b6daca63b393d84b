//! What every machine has within the tolerances of its make, load and drive, which is no cause.

use super::candidate::Candidate;
use super::hypotheses::LOAD_COMPONENT;
use super::observation::{Observation, duration_s, mean_load_n};
use super::settings::ToleranceSettings;
use crate::rig::EffectEntry;
use crate::rig::effect::{EffectKind, ParameterKey};

const SETTINGS: ToleranceSettings = ToleranceSettings::DEFAULT;

/// Index of the first candidate, or of an error of the stated load that gains nearly as much.
pub fn load_error_or_first(found: &[Candidate], observations: &[Observation]) -> usize {
    let first = found[0].gain;
    let is_close = |c: &Candidate| c.gain > first - SETTINGS.load_nats - SETTINGS.load_share_of_gain * first;
    found.iter().position(|c| is_load_error(c, observations) && is_close(c)).unwrap_or(0)
}

/// Whether a candidate is an error of the stated load.
fn is_load_error(candidate: &Candidate, observations: &[Observation]) -> bool {
    let force = candidate.effect().and_then(|e| e.number(ParameterKey::ForceN)).unwrap_or_default();
    let is_of_load = candidate.kind == EffectKind::ConstantForce && candidate.place == LOAD_COMPONENT;
    is_of_load && force.abs() < SETTINGS.load_share * mean_load_n(observations)
}

/// Whether a candidate is what every machine has: an error of the stated load, or an effect within its tolerances.
pub fn is_tolerance(candidate: &Candidate, observations: &[Observation]) -> bool {
    let seconds = observations.iter().map(|o| duration_s(std::slice::from_ref(o))).fold(0.0, f64::max);
    is_load_error(candidate, observations) || candidate.effect().is_some_and(|e| is_within_tolerance(&e, seconds))
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
