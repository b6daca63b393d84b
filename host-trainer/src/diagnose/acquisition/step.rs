//! An offset of a sensor that begins or ends within a recording: its mean jumps, which no motion of a machine does.

use crate::identify::likelihood::observed::accelerations;
use crate::recording::Recording;

/// Fewest turns of the shaft on either side of a jump.
const FEWEST: usize = 4;
/// Standard errors that a jump has at least. By hand: far beyond the means of a slow motion.
const LEAST_Z: f64 = 12.0;
/// Jump over the standard deviation of the means of whole turns beside it, at least: what wanders as much is no jump.
const OF_SCATTER: f64 = 4.0;

/// Jump of a channel's mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// First sample after it.
    pub sample: usize,
    /// Mean after less mean before, m/s².
    pub change: f64,
    /// Standard errors of the change.
    pub z: f64,
}

/// Jumps of the means of `ax` and `ay`; `None` for a channel without one or a recording without a speed.
pub fn steps(recording: &Recording) -> [Option<Step>; 2] {
    let turn = recording.shaft_hz.map(|hz| (recording.sample_rate_hz / hz).round() as usize).filter(|turn| *turn > 1);
    accelerations(recording).map(|channel| step(&channel?.samples, turn?))
}

/// Jump of the mean of samples, of which so many are a turn of the shaft.
fn step(samples: &[f64], turn: usize) -> Option<Step> {
    let means: Vec<f64> = samples.chunks_exact(turn).map(|one| one.iter().sum::<f64>() / turn as f64).collect();
    let of = |at: usize| {
        let (before, after) = (&means[..at], &means[at..]);
        let change = mean(after) - mean(before);
        let squares: f64 =
            [before, after].iter().map(|side| side.iter().map(|v| (v - mean(side)).powi(2)).sum::<f64>()).sum();
        let scatter = (squares / (means.len() - 2) as f64).sqrt();
        let error = scatter * (1.0 / before.len() as f64 + 1.0 / after.len() as f64).sqrt();
        (at, change, scatter, change.abs() / error.max(f64::MIN_POSITIVE))
    };
    let places = FEWEST..(means.len() + 1).saturating_sub(FEWEST);
    let (at, change, scatter, z) = places.map(of).max_by(|a, b| a.3.total_cmp(&b.3))?;
    (z > LEAST_Z && change.abs() > OF_SCATTER * scatter).then_some(Step { sample: at * turn, change, z })
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::effect::{EffectKind, ParameterKey};
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{EffectEntry, Start, simulate};

    #[test]
    fn a_jump_of_the_sensor_is_found_and_a_step_of_the_load_is_none() {
        let made = |rig| simulate(&rig, &condition(30.0, 800.0, 12_800), &Start::seeded(3)).unwrap();
        let mut recording = made(nominal());
        assert_eq!(steps(&recording), [None; 2]);
        let channel = recording.channels.iter_mut().find(|c| c.name == "ay").unwrap();
        channel.samples.iter_mut().skip(5000).for_each(|v| *v += 0.3);
        let [None, Some(step)] = steps(&recording) else { panic!("one jump, in ay") };
        assert!(step.sample.abs_diff(5000) < 430 && (step.change / 0.3 - 1.0).abs() < 0.1, "{step:?}");
        let load = [(ParameterKey::ChangeN, -300.0), (ParameterKey::TimeS, 0.4)];
        assert_eq!(steps(&made(nominal().with_effect(EffectEntry::new(EffectKind::LoadStep, &load)))), [None; 2]);
    }
}
