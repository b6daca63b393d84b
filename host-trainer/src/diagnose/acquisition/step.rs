//! An offset of a sensor that begins or ends within a recording: its mean jumps, which no motion of a machine does.

use std::ops::Range;

use statrs::statistics::Statistics;

use super::{Fault, SURE, between};
use crate::identify::calibrate::split::part;
use crate::identify::likelihood::observed::{CHANNELS, accelerations};
use crate::recording::Recording;
use crate::rig::EffectEntry;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::stats::significance::two_sided;

/// Fewest turns of the shaft on either side of a jump.
const FEWEST: usize = 4;
/// Standard errors that a jump has at least. By hand: far beyond the means of a slow motion.
const LEAST_Z: f64 = 12.0;
/// Jump over the standard deviation of the means of whole turns beside it, at least: what wanders as much is no jump.
const OF_SCATTER: f64 = 4.0;

/// Jump of a channel's mean.
#[derive(Clone, Debug, PartialEq)]
struct Step {
    /// Samples within which it is: a turn of the shaft to either side.
    within: Range<usize>,
    /// Mean after less mean before, m/s².
    change: f64,
    /// Standard errors of the change.
    z: f64,
}

/// Cuts recordings in which an offset begins or ends to the longest part beside it; the fault of the greatest jump, if there is any.
pub fn steady_part(recordings: &mut [Recording]) -> Option<Fault> {
    let found: Vec<[Option<Step>; 2]> = recordings.iter().map(steps).collect();
    let each = found.iter().zip(&*recordings).flat_map(|(of, r)| of.iter().zip(CHANNELS).map(move |(s, c)| (s, c, r)));
    let each = each.filter_map(|(step, channel, recording)| Some((step.as_ref()?, channel, recording)));
    let (most, channel, recording) = each.max_by(|a, b| a.0.change.abs().total_cmp(&b.0.change.abs()))?;
    let having = found.iter().filter(|of| of.iter().any(Option::is_some)).count();
    let middle = (most.within.start + most.within.end) / 2;
    let fault = Fault {
        effect: EffectEntry::new(EffectKind::SensorBias, &[(ParameterKey::Value, most.change)])
            .with_text(ParameterKey::Channel, channel),
        evidence: format!(
            "The mean of {channel} jumps by {:.4} m/s² at {:.3} s of {}, and so in {having} of {} recordings: no motion of a machine does that.",
            most.change,
            middle as f64 / recording.sample_rate_hz,
            recording.name(),
            recordings.len()
        ),
        p_value: two_sided(most.z),
        probability: SURE,
    };
    for (recording, of) in recordings.iter_mut().zip(found) {
        let mut spans: Vec<Range<usize>> = of.into_iter().flatten().map(|step| step.within).collect();
        spans.sort_by_key(|span| span.start);
        if !spans.is_empty() {
            *recording = part(recording, between(&spans, recording.len()));
        }
    }
    Some(fault)
}

/// Jumps of the means of `ax` and `ay`; `None` for a channel without one or a recording without a speed.
fn steps(recording: &Recording) -> [Option<Step>; 2] {
    let turn = recording.shaft_hz.map(|hz| (recording.sample_rate_hz / hz).round() as usize).filter(|turn| *turn > 1);
    accelerations(recording).map(|channel| step(&channel?.samples, turn?))
}

/// Jump of the mean of samples, of which so many are a turn of the shaft.
fn step(samples: &[f64], turn: usize) -> Option<Step> {
    let means: Vec<f64> = samples.chunks_exact(turn).map(Statistics::mean).collect();
    let of = |at: usize| {
        let (before, after) = means.split_at(at);
        let change = after.mean() - before.mean();
        let squares = |side: &[f64]| (side.len() - 1) as f64 * side.variance();
        let scatter = ((squares(before) + squares(after)) / (means.len() - 2) as f64).sqrt();
        let error = scatter * (1.0 / before.len() as f64 + 1.0 / after.len() as f64).sqrt();
        (at, change, scatter, change.abs() / error.max(f64::MIN_POSITIVE))
    };
    let places = FEWEST..(means.len() + 1).saturating_sub(FEWEST);
    let (at, change, scatter, z) = places.map(of).max_by(|a, b| a.3.total_cmp(&b.3))?;
    let within = (at - 1) * turn..(at + 1) * turn;
    (z > LEAST_Z && change.abs() > OF_SCATTER * scatter).then_some(Step { within, change, z })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{Start, simulate};

    #[test]
    fn a_jump_of_the_sensor_is_found_and_a_step_of_the_load_is_none() {
        let made = |rig| simulate(&rig, &condition(30.0, 800.0, 12_800), &Start::seeded(3)).unwrap();
        let mut recording = made(nominal());
        let turn = 853; // 25.6 kHz over 30 Hz
        assert_eq!(steps(&recording), [None, None]);
        let channel = recording.channels.iter_mut().find(|c| c.name == "ay").unwrap();
        channel.samples.iter_mut().skip(5000).for_each(|v| *v += 0.3);
        let [None, Some(step)] = steps(&recording) else { panic!("one jump, in ay") };
        assert!(
            step.within.contains(&5000) && step.within.len() == 2 * turn && (step.change / 0.3 - 1.0).abs() < 0.1,
            "{step:?}"
        );
        let load = [(ParameterKey::ChangeN, -300.0), (ParameterKey::TimeS, 0.4)];
        assert_eq!(steps(&made(nominal().with_effect(EffectEntry::new(EffectKind::LoadStep, &load)))), [None, None]);
    }
}
