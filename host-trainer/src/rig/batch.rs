//! A rig under the operating conditions of a manifest or of recordings.

use crate::recording::{Recording, manifest::Entry};

use super::{
    condition::{OperatingCondition, Start},
    config::{Machine, Rig},
    error::RigError,
    plausible::{check_speed, check_stated},
    sdof::{self, Drive},
    settings::ConditionLimits,
    simulate::{Run, simulate_many},
};

const LIMITS: ConditionLimits = ConditionLimits::DEFAULT;

/// Simulates a bearing rig for `seconds` under the condition of each entry; starts by `seed`.
///
/// # Errors
///
/// An entry without speed, load or sample rate, and what [`simulate_many`] refuses.
pub fn entries(rig: &Rig, entries: &[Entry], seconds: f64, seed: u64) -> Result<Vec<Recording>, RigError> {
    let conditions: Vec<_> = entries
        .iter()
        .map(|entry| {
            let place = entry.file.display().to_string();
            let sample_rate_hz = stated(entry.sample_rate_hz, &place, "sample_rate_hz")?;
            let samples = (seconds * sample_rate_hz).round();
            if !(1.0..=LIMITS.samples_of_one).contains(&samples) {
                return Err(RigError::BadRecording {
                    place: format!("seconds of {place}"),
                    found: format!("{seconds} s at {sample_rate_hz} Hz"),
                    expected: format!("1 to {} samples", LIMITS.samples_of_one),
                });
            }
            let shaft_hz = stated(entry.shaft_hz, &place, "shaft_hz")?;
            if let Machine::Bearing(rig) = &rig.model {
                check_speed(rig, shaft_hz, sample_rate_hz, &place)?;
            }
            let load_n = stated(entry.load_n, &place, "load_n")?;
            Ok(OperatingCondition { shaft_hz, load_n, sample_rate_hz, samples: samples as usize })
        })
        .collect::<Result<_, RigError>>()?;
    let samples: f64 = conditions.iter().map(|condition: &OperatingCondition| condition.samples as f64).sum();
    if samples > LIMITS.samples {
        return Err(RigError::BadRecording {
            place: "seconds of all recordings".into(),
            found: format!("{samples} samples"),
            expected: format!("at most {} in one run", LIMITS.samples),
        });
    }
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
    check_stated(rig, recordings)?;
    let conditions: Vec<_> = recordings
        .iter()
        .map(|recording| {
            let place = recording.source.to_string();
            Ok(OperatingCondition {
                shaft_hz: stated(recording.shaft_hz, &place, "shaft_hz")?,
                load_n: stated(recording.load_n, &place, "load_n")?,
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
    let (mut made, mut rest) = (Vec::with_capacity(runs.len()), runs.as_slice());
    while !rest.is_empty() {
        let mut samples = 0;
        let fits = |run: &&Run| {
            samples += run.condition.samples;
            samples <= LIMITS.samples_at_once
        };
        let (now, later) = rest.split_at(rest.iter().take_while(fits).count().max(1));
        made.extend(simulate_many(now)?);
        rest = later;
    }
    Ok(made)
}

fn driven(rig: &Rig, recording: &Recording) -> Result<Recording, RigError> {
    if ["u", "q", "qd", "qdd"].into_iter().all(|name| recording.channel(name).is_none()) {
        let there: Vec<_> = recording.channels.iter().map(|c| c.name.as_str()).collect();
        return Err(RigError::BadRecording {
            place: recording.source.to_string(),
            found: format!("channels {}", there.join(", ")),
            expected: "`u`, `q` or `qdd`, since the rig is of kind \"sdof\"".into(),
        });
    }
    let none = vec![0.0; recording.len()];
    let input = recording.samples("u").unwrap_or(&none);
    let position = recording.samples("q").and_then(|q| q.first().copied()).unwrap_or(0.0);
    let drive = Drive { input, sample_rate_hz: recording.sample_rate_hz, position, ..Drive::default() };
    sdof::simulate(rig, &drive)
}

fn stated(value: Option<f64>, place: &str, key: &str) -> Result<f64, RigError> {
    value.ok_or_else(|| RigError::BadRecording {
        place: format!("{place}, {key}"),
        found: "none stated".into(),
        expected: "a number in the manifest".into(),
    })
}
