//! Samples that a logger dropped: one turn of the shaft is short by as many, while all others are alike.

use crate::identify::likelihood::observed::accelerations;
use crate::recording::Recording;

/// Fewest turns of a recording by which one is found short.
const TURNS: usize = 5;
/// Samples, and share of a turn, by which turns of an even speed differ.
const ALIKE: [f64; 2] = [2.5, 0.004];
/// Variance of a turn between two whole samples, each uniform within one.
const WHOLE_SAMPLES: f64 = 1.0 / 6.0;
/// Order of the autoregression whose errors show the jump.
const ORDER: usize = 24;
/// Samples after a jump in which these errors are large.
const JUMP: usize = 12;

/// Missing samples of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Sample before which they are missing.
    pub sample: usize,
    /// Their count.
    pub count: usize,
    /// Standard deviations of a turn by which this one is short; a turn's is at least that of its whole samples.
    pub z: f64,
}

/// Missing samples by a recording's tachometer; `None` without one, or if every turn is as long as the others.
pub fn gap(recording: &Recording) -> Option<Gap> {
    let tacho = &recording.channel("tacho")?.samples;
    let pulses: Vec<usize> = (0..tacho.len()).filter(|n| tacho[*n] > 0.5).collect();
    let turns: Vec<f64> = pulses.windows(2).map(|p| (p[1] - p[0]) as f64).collect();
    if turns.len() < TURNS {
        return None;
    }
    let mut sorted = turns.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted[sorted.len() / 2];
    let alike = ALIKE[0].max(ALIKE[1] * usual);
    let odd: Vec<usize> = (0..turns.len()).filter(|n| (turns[*n] - usual).abs() > alike).collect();
    let [odd] = odd.as_slice() else { return None };
    let count = (usual - turns[*odd]).rem_euclid(usual).round() as usize;
    let within = pulses[*odd]..pulses[*odd + 1];
    let others = (0..turns.len()).filter(|n| n != odd).map(|n| (turns[n] - usual).powi(2));
    let scatter = (others.sum::<f64>() / (turns.len() - 1) as f64).max(WHOLE_SAMPLES);
    Some(Gap { sample: jump(recording, within)?, count, z: (turns[*odd] - usual).abs() / scatter.sqrt() })
}

/// Sample of the greatest jump within a turn: where the errors of an autoregression are largest.
fn jump(recording: &Recording, within: std::ops::Range<usize>) -> Option<usize> {
    let mut energy = vec![0.0; within.len()];
    for channel in accelerations(recording).into_iter().flatten() {
        let samples = &channel.samples;
        let weights = autoregression(samples);
        let error =
            |n: usize| samples[n] - weights.iter().enumerate().map(|(k, w)| w * samples[n - 1 - k]).sum::<f64>();
        let errors: Vec<f64> = (ORDER..samples.len()).map(error).collect();
        let variance = errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64;
        for (place, sum) in energy.iter_mut().enumerate() {
            let from = (within.start + place).checked_sub(ORDER)?;
            let there = errors.get(from..(from + JUMP).min(errors.len())).unwrap_or_default();
            *sum += there.iter().map(|e| e * e).sum::<f64>() / variance.max(f64::MIN_POSITIVE);
        }
    }
    // The window begins with the jump where the errors' sum is greatest for the last time.
    let best = energy.iter().copied().fold(0.0, f64::max);
    energy.iter().rposition(|e| *e > 0.98 * best).map(|place| within.start + place)
}

/// Weights of the last samples in the prediction of the next, by Levinson's recursion.
fn autoregression(samples: &[f64]) -> Vec<f64> {
    let lag = |l: usize| samples.iter().zip(&samples[l..]).map(|(a, b)| a * b).sum::<f64>();
    let lags: Vec<f64> = (0..=ORDER.min(samples.len() / 4)).map(lag).collect();
    let mut weights: Vec<f64> = Vec::new();
    let mut error = lags[0].max(f64::MIN_POSITIVE);
    for n in 1..lags.len() {
        let known: f64 = weights.iter().enumerate().map(|(k, w)| w * lags[n - 1 - k]).sum();
        let reflection = (lags[n] - known) / error;
        let mut next = weights.clone();
        (0..weights.len()).for_each(|k| next[k] -= reflection * weights[weights.len() - 1 - k]);
        next.push(reflection);
        weights = next;
        error *= 1.0 - reflection * reflection;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::effect::{EffectKind, ParameterKey};
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{EffectEntry, Rig, Run, Start, simulate_many};

    fn recording(rig: &Rig) -> Recording {
        simulate_many(&[Run { rig, condition: condition(30.0, 500.0, 25_600), start: Start::seeded(3) }])
            .unwrap()
            .remove(0)
    }

    #[test]
    fn missing_samples_are_counted_and_placed() {
        for count in [40.0, 444.0] {
            let effect = EffectEntry::new(
                EffectKind::DroppedSamples,
                &[(ParameterKey::TimeS, 0.4), (ParameterKey::Count, count)],
            );
            let gap = gap(&recording(&nominal().with_effect(effect))).unwrap();
            assert!((gap.count as f64 - count).abs() <= 2.0, "{gap:?}");
            // Few missing samples jump little: 338 samples off of 40. The cut is wider.
            assert!(gap.sample.abs_diff(10_240) < 400, "{gap:?}");
        }
    }

    #[test]
    fn null_an_even_turning_shaft_has_lost_nothing() {
        assert_eq!(gap(&recording(&nominal())), None);
    }
}
