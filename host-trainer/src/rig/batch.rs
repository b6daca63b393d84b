//! A rig under the operating conditions of a manifest or of recordings.

use crate::recording::{Recording, manifest::Entry};

use super::{
    condition::{OperatingCondition, Start},
    config::{Machine, Rig},
    error::RigError,
    sdof::{self, Drive},
    simulate::{Run, simulate_many},
};

/// Simulates a bearing rig for `seconds` under the condition of each entry; starts by `seed`.
///
/// # Errors
///
/// An entry without speed, load or sample rate, and what [`simulate_many`] refuses.
pub fn entries(rig: &Rig, entries: &[Entry], seconds: f64, seed: u64) -> Result<Vec<Recording>, RigError> {
    let conditions: Vec<_> = entries
        .iter()
        .map(|entry| {
            let sample_rate_hz = stated(entry.sample_rate_hz, "sample_rate_hz")?;
            Ok(OperatingCondition {
                shaft_hz: stated(entry.shaft_hz, "shaft_hz")?,
                load_n: stated(entry.load_n, "load_n")?,
                sample_rate_hz,
                samples: (seconds * sample_rate_hz).round() as usize,
            })
        })
        .collect::<Result<_, RigError>>()?;
    bearing(rig, &conditions, seed)
}

/// Simulates a rig as each recording was made: a bearing rig at its speed, load and length, an sdof
/// rig driven by its `u` (0 without one) from rest at its first `q`.
///
/// # Errors
///
/// A recording without what the rig needs, and what the simulation refuses.
pub fn recordings(rig: &Rig, recordings: &[Recording], seed: u64) -> Result<Vec<Recording>, RigError> {
    if matches!(rig.model, Machine::Sdof(_)) {
        return recordings.iter().map(|recording| driven(rig, recording)).collect();
    }
    let conditions: Vec<_> = recordings
        .iter()
        .map(|recording| {
            Ok(OperatingCondition {
                shaft_hz: stated(recording.shaft_hz, "shaft_hz")?,
                load_n: stated(recording.load_n, "load_n")?,
                sample_rate_hz: recording.sample_rate_hz,
                samples: recording.len(),
            })
        })
        .collect::<Result<_, RigError>>()?;
    bearing(rig, &conditions, seed)
}

fn bearing(rig: &Rig, conditions: &[OperatingCondition], seed: u64) -> Result<Vec<Recording>, RigError> {
    let run = |(index, condition): (usize, &OperatingCondition)| Run {
        rig,
        condition: *condition,
        start: Start::of_series(seed, index),
    };
    let runs: Vec<Run> = conditions.iter().enumerate().map(run).collect();
    simulate_many(&runs)
}

fn driven(rig: &Rig, recording: &Recording) -> Result<Recording, RigError> {
    let channel = |name: &str| recording.channel(name).map(|c| c.samples.as_slice());
    let none = vec![0.0; recording.len()];
    let input = channel("u").unwrap_or(&none);
    let position = channel("q").and_then(|q| q.first().copied()).unwrap_or(0.0);
    let drive = Drive { input, sample_rate_hz: recording.sample_rate_hz, position, ..Drive::default() };
    sdof::simulate(rig, &drive)
}

fn stated(value: Option<f64>, field: &'static str) -> Result<f64, RigError> {
    value.ok_or(RigError::BadCondition { field, found: "none stated".into(), expected: "a number in the manifest" })
}
