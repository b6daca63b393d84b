//! Acquisition faults of an sdof rig in held-out recordings.
//!
//! The force balance removes such faults from the samples first. Held-out traces are the other way round, so that they can be
//! measured again: the recording with the fault, and a simulation with it.

use crate::rig::effect::{EffectKind, ParameterKey};
use std::f64::consts::TAU;

use super::result::{Fit, HeldOut, Location};
use crate::recording::Recording;
use crate::rig::EffectEntry;
use crate::stats::significance::sign_flip;

/// Blocks of each recording whose gains are compared.
const BLOCKS: usize = 48;

/// Whether an effect is a persistent acquisition fault.
pub fn lasts(entry: &EffectEntry) -> bool {
    matches!(entry.kind, EffectKind::SensorClipping | EffectKind::MainsInterference)
}

/// Adds mains interference back to the measured signals, and the faults to the simulations of the corrected rig.
pub fn put_back(held_out: &mut [HeldOut], channel: &str, recordings: &[Recording], faults: &[&EffectEntry]) {
    let named = |kind: EffectKind| faults.iter().find(|entry| entry.kind == kind);
    for held in held_out {
        if let Some(entry) = named(EffectKind::MainsInterference)
            && let Some(raw) = as_recorded(held, channel, recordings)
        {
            mains(held, raw, entry);
        }
        // The converter comes after the cable.
        if let Some(entry) = named(EffectKind::SensorClipping) {
            let level = number(entry, ParameterKey::Value).abs();
            held.after.iter_mut().for_each(|value| *value = value.clamp(-level, level));
        }
    }
}

/// Fit to held-out recordings, sample by sample; `None` if there are none.
pub fn fit(held_out: &[HeldOut], noise_floor: f64, seed: u64) -> Option<Fit> {
    let (mut before, mut after, mut count) = (Vec::new(), Vec::new(), 0);
    for held in held_out {
        let length = held.measured.len().div_ceil(BLOCKS).max(1);
        let squares = |of: &[f64]| -> Vec<f64> {
            let pairs: Vec<f64> = held.measured.iter().zip(of).map(|(m, s)| (m - s).powi(2)).collect();
            pairs.chunks(length).map(|block| block.iter().sum()).collect()
        };
        before.extend(squares(&held.before));
        after.extend(squares(&held.after));
        count += held.measured.len();
    }
    let root = |sums: &[f64]| (sums.iter().sum::<f64>() / count as f64).sqrt();
    let names: Vec<&str> = held_out.iter().map(|held| held.name.as_str()).collect();
    (count > 0).then(|| Fit {
        metric: "RMS of measured minus simulated, in the sensor's unit".into(),
        held_out: names.join(", "),
        before: root(&before),
        after: root(&after),
        noise_floor,
        p_value: sign_flip(&before, &after, seed),
    })
}

/// Location of such faults.
pub fn location(channel: &str, faults: &[&EffectEntry]) -> Location {
    let mut location = Location { channel: channel.into(), ..Location::default() };
    for entry in faults {
        if entry.kind == EffectKind::MainsInterference {
            let line = number(entry, ParameterKey::FrequencyHz);
            location.frequency_hz.push([line, line]);
        } else {
            location.state = format!(
                "|{channel}| at {:.6}, the end of the sensor's range",
                number(entry, ParameterKey::Value).abs()
            );
        }
    }
    location
}

fn number(entry: &EffectEntry, key: ParameterKey) -> f64 {
    entry.number(key).unwrap_or_default()
}

/// Original samples of a held-out recording, which may be the end of a recording.
fn as_recorded<'a>(held: &HeldOut, channel: &str, recordings: &'a [Recording]) -> Option<&'a [f64]> {
    let samples = |r: &'a Recording| r.channel(channel).map(|c| c.samples.as_slice());
    let count = held.measured.len();
    if let [only] = recordings {
        return samples(only).and_then(|all| all.get(all.len().checked_sub(count)?..));
    }
    let apart = |all: &[f64]| -> f64 { all.iter().zip(&held.measured).map(|(a, b)| (a - b).powi(2)).sum() };
    let same = recordings.iter().filter(|r| r.name() == held.name).filter_map(samples).filter(|all| all.len() == count);
    same.min_by(|a, b| apart(a).total_cmp(&apart(b)))
}

/// Mains interference of the cause's frequency and amplitude, its phase fitted to each recording.
fn mains(held: &mut HeldOut, raw: &[f64], entry: &EffectEntry) {
    let (frequency, amplitude) = (number(entry, ParameterKey::FrequencyHz), number(entry, ParameterKey::Amplitude));
    let angle = |k: usize| TAU * frequency * k as f64 / held.sample_rate_hz;
    let taken = raw.iter().zip(&held.measured).map(|(raw, rest)| raw - rest).enumerate();
    let (sine, cosine) = taken.fold((0.0, 0.0), |(s, c), (k, line)| {
        let (sin, cos) = angle(k).sin_cos();
        (s + line * sin, c + line * cos)
    });
    let phase = cosine.atan2(sine);
    let line = |k: usize| [1.0, 3.0, 5.0].iter().map(|n| (n * (angle(k) + phase)).sin() / n).sum::<f64>();
    let line: Vec<f64> = (0..raw.len()).map(line).collect();
    held.after.iter_mut().zip(line).for_each(|(value, line)| *value += amplitude * line);
    held.measured = raw.to_vec();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Channel, Source};

    #[test]
    fn a_line_is_put_back_in_its_own_phase() {
        let line = |k: usize| {
            let angle = TAU * 50.0 * k as f64 / 1000.0 + 0.7;
            0.3 * [1.0, 3.0, 5.0].iter().map(|n: &f64| (n * angle).sin() / n).sum::<f64>()
        };
        let raw: Vec<f64> = (0..2000).map(|k| 1.0 + line(k)).collect();
        let recording = |name: &str, samples: Vec<f64>| Recording {
            source: Source { path: format!("{name}.csv").into(), variable: None },
            channels: vec![Channel { name: "q".into(), location: None, samples }],
            sample_rate_hz: 1000.0,
            ..Recording::default()
        };
        let recordings = [recording("a", vec![0.0; 2000]), recording("b", raw.clone())];
        let flat = vec![1.0; 2000];
        let mut held = [HeldOut {
            name: "b".into(),
            sample_rate_hz: 1000.0,
            measured: flat.clone(),
            before: flat.clone(),
            after: flat,
        }];
        let entry = EffectEntry::new(
            EffectKind::MainsInterference,
            &[(ParameterKey::FrequencyHz, 50.0), (ParameterKey::Amplitude, 0.3)],
        );
        put_back(&mut held, "q", &recordings, &[&entry]);
        assert_eq!(held[0].measured, raw);
        let fit = fit(&held, 0.0, 1).unwrap();
        assert!(fit.before > 0.2 && fit.after < 1e-9 && fit.p_value < 1e-3, "{fit:?}");
    }
}
