//! A machine's life that is not one: the 5-DoF rig, recording after recording, and from one of them on a mode of
//! vibration that the rig has not, as of a bracket that has come loose.

use crate::rig::effect::{EffectKind, ParameterKey};
use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use crate::recording::Recording;
use crate::rig::RigError;
use crate::rig::config::{EffectEntry, Rig};
use crate::rig::simulate::{Run, simulate_many};
use crate::rig::{OperatingCondition, Start};

/// What to make.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Recordings, in order of time.
    pub recordings: usize,
    /// Length of each, s.
    pub seconds: f64,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// How much of the mode the sensor sees, as a multiple of what the housing's mass alone would give; 0 for a machine
    /// that stays as it was drawn.
    pub gain: f64,
    /// Seed of everything random, the effect's start included.
    pub seed: u64,
}

/// What only the maker knows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Truth {
    /// Name of the effect.
    pub effect: &'static str,
    /// Its natural frequency, Hz.
    pub frequency_hz: f64,
    /// Its damping ratio.
    pub damping_ratio: f64,
    /// First recording with it, from 0; `None` where it never comes.
    pub first_affected: Option<usize>,
}

/// What was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Made {
    /// The recordings: `ay`, the vertical sensor, and `ax`, the horizontal one.
    pub recordings: Vec<Recording>,
    /// What may not be known.
    pub truth: Truth,
}

const EFFECT: EffectKind = EffectKind::StructuralResonance;
/// The rig as it was drawn: what anyone may know of the machine.
pub const RIG: &str = include_str!("rig.toml");
/// Speeds and loads that the machine runs at, Hz and N.
const SHAFT_HZ: [f64; 3] = [20.0, 25.0, 30.0];
const LOAD_N: [f64; 3] = [300.0, 500.0, 800.0];
/// From one recording to the next they are not quite the same: largest relative difference.
const SCATTER: f64 = 0.01;
/// Where the mode can lie: above those of shaft and housing, below the resonator's.
const FREQUENCY_HZ: std::ops::Range<f64> = 1550.0..1750.0;
const DAMPING_RATIO: std::ops::Range<f64> = 0.016..0.024;
/// The effect starts after a share of the recordings in this range.
const START: std::ops::Range<f64> = 0.4..0.55;

/// The rig as it was drawn.
///
/// # Errors
/// None in practice.
pub fn nominal() -> Result<Rig, RigError> {
    Rig::parse(RIG, Path::new("rig.toml"))
}

/// Makes the recordings. The same plan gives the same samples.
///
/// # Errors
/// What the simulation refuses.
pub fn make(plan: &Scenario) -> Result<Made, RigError> {
    let nominal = nominal()?;
    let mut rng = ChaCha8Rng::seed_from_u64(plan.seed);
    let start = (rng.random_range(START) * plan.recordings as f64).ceil() as usize;
    let (frequency_hz, damping_ratio) = (rng.random_range(FREQUENCY_HZ), rng.random_range(DAMPING_RATIO));
    let mode = EffectEntry::new(
        EFFECT,
        &[
            (ParameterKey::FrequencyHz, frequency_hz),
            (ParameterKey::DampingRatio, damping_ratio),
            (ParameterKey::Gain, plan.gain),
        ],
    );
    let changed = nominal.clone().with_effect(mode);
    let first_affected = (plan.gain != 0.0 && start < plan.recordings).then_some(start);
    let affected = |n: usize| first_affected.is_some_and(|first| n >= first);
    let mut one_of =
        |values: [f64; 3]| values[rng.random_range(0..values.len())] * (1.0 + rng.random_range(-SCATTER..SCATTER));
    let runs: Vec<Run> = (0..plan.recordings)
        .map(|n| Run {
            rig: if affected(n) { &changed } else { &nominal },
            condition: OperatingCondition {
                shaft_hz: one_of(SHAFT_HZ),
                load_n: one_of(LOAD_N),
                sample_rate_hz: plan.sample_rate_hz,
                samples: (plan.seconds * plan.sample_rate_hz).round() as usize,
            },
            start: Start::of_series(plan.seed, n),
        })
        .collect();
    let mut recordings = simulate_many(&runs)?;
    for recording in &mut recordings {
        recording.channels.retain(|channel| ["ax", "ay"].contains(&channel.name.as_str()));
        // The vertical one first: it is the one that a monitor takes where nobody says.
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
