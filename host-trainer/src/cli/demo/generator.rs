//! Simulated recordings of the 5-DoF rig, from one of them on with a vibration mode that the nominal rig lacks, as of a
//! loose bracket.

use crate::rig::effect::{EffectKind, ParameterKey};
use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::settings::DemoSettings;
use crate::recording::Recording;
use crate::rig::RigError;
use crate::rig::config::{EffectEntry, Rig};
use crate::rig::simulate::{Run, simulate_many};
use crate::rig::{OperatingCondition, Start};

/// Recordings to simulate.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Recordings, in order of time.
    pub recordings: usize,
    /// Length of each, s.
    pub seconds: f64,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Gain of the mode at the sensor, as a multiple of that by the housing's mass alone; 0 for no mode.
    pub gain: f64,
    /// Seed of everything random, the effect's start included.
    pub seed: u64,
}

/// Hidden effect of the recordings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Truth {
    /// Name of the effect.
    pub effect: &'static str,
    /// Natural frequency of the mode, Hz.
    pub frequency_hz: f64,
    /// Damping ratio of the mode.
    pub damping_ratio: f64,
    /// First recording with the effect, from 0; `None` if there is none.
    pub first_affected: Option<usize>,
}

/// Recordings with their hidden effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Made {
    /// Recordings of `ay`, the vertical sensor, and `ax`, the horizontal one.
    pub recordings: Vec<Recording>,
    /// Hidden effect, not to be used by the diagnosis.
    pub truth: Truth,
}

const EFFECT: EffectKind = EffectKind::StructuralResonance;
/// Nominal rig as a file: all that the job knows of the machine.
pub const RIG: &str = include_str!("rig.toml");
const SETTINGS: DemoSettings = DemoSettings::DEFAULT;

/// Nominal rig.
///
/// # Errors
/// None in practice.
pub fn nominal() -> Result<Rig, RigError> {
    Rig::parse(RIG, Path::new("rig.toml"))
}

/// Simulates the recordings of a scenario; equal scenarios give equal samples.
///
/// # Errors
/// Errors of the simulation.
pub fn make(scenario: &Scenario) -> Result<Made, RigError> {
    let nominal = nominal()?;
    let mut rng = ChaCha8Rng::seed_from_u64(scenario.seed);
    let start = (rng.random_range(SETTINGS.start) * scenario.recordings as f64).ceil() as usize;
    let (frequency_hz, damping_ratio) =
        (rng.random_range(SETTINGS.frequency_hz), rng.random_range(SETTINGS.damping_ratio));
    let mode = EffectEntry::new(
        EFFECT,
        &[
            (ParameterKey::FrequencyHz, frequency_hz),
            (ParameterKey::DampingRatio, damping_ratio),
            (ParameterKey::Gain, scenario.gain),
        ],
    );
    let changed = nominal.clone().with_effect(mode);
    let first_affected = (scenario.gain != 0.0 && start < scenario.recordings).then_some(start);
    let affected = |n: usize| first_affected.is_some_and(|first| n >= first);
    let mut one_of = |values: [f64; 3]| {
        values[rng.random_range(0..values.len())] * (1.0 + rng.random_range(-SETTINGS.scatter..SETTINGS.scatter))
    };
    let runs: Vec<Run> = (0..scenario.recordings)
        .map(|n| Run {
            rig: if affected(n) { &changed } else { &nominal },
            condition: OperatingCondition {
                shaft_hz: one_of(SETTINGS.shaft_hz),
                load_n: one_of(SETTINGS.load_n),
                sample_rate_hz: scenario.sample_rate_hz,
                samples: (scenario.seconds * scenario.sample_rate_hz).round() as usize,
            },
            start: Start::of_series(scenario.seed, n),
        })
        .collect();
    let mut recordings = simulate_many(&runs)?;
    for recording in &mut recordings {
        recording.channels.retain(|channel| ["ax", "ay"].contains(&channel.name.as_str()));
        // The vertical one first: the monitor uses the first channel by default.
        recording.channels.sort_by(|a, b| b.name.cmp(&a.name));
    }
    let truth = Truth { effect: EFFECT.name(), frequency_hz, damping_ratio, first_affected };
    Ok(Made { recordings, truth })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::spectrum::welch;

    const PLAN: Scenario = Scenario { recordings: 12, seconds: 0.3, sample_rate_hz: 25_600.0, gain: 5.0, seed: 3 };

    #[test]
    fn the_mode_comes_about_half_way_and_shows_at_its_frequency() {
        let made = make(&PLAN).unwrap();
        let first = made.truth.first_affected.unwrap();
        assert!((5..8).contains(&first), "{first}");
        let density = |recording: &Recording| {
            let samples: Vec<f32> = recording.channels[0].samples.iter().map(|v| *v as f32).collect();
            let spectrum = welch(&[&samples], 25_600.0, 512).unwrap();
            spectrum.values[(made.truth.frequency_hz / spectrum.step_hz).round() as usize]
        };
        let (early, late) = (density(&made.recordings[0]), density(&made.recordings[11]));
        assert!(late > 5.0 * early, "{early} {late}");
        assert_eq!(made.recordings[0].channels[0].name, "ay");
    }

    #[test]
    fn null_without_gain_there_is_no_effect() {
        let made = make(&Scenario { gain: 0.0, ..PLAN }).unwrap();
        assert_eq!(made.truth.first_affected, None);
    }

    #[test]
    fn same_seed_same_samples_and_the_effect_changes_nothing_before_it_starts() {
        let (made, control) = (make(&PLAN).unwrap(), make(&Scenario { gain: 0.0, ..PLAN }).unwrap());
        assert_eq!(made, make(&PLAN).unwrap());
        assert_ne!(made, make(&Scenario { seed: 4, ..PLAN }).unwrap());
        let first = made.truth.first_affected.unwrap();
        assert_eq!(made.recordings[..first], control.recordings[..first]);
        assert_ne!(made.recordings[first], control.recordings[first]);
    }
}
