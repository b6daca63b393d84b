//! Samples that a logger lost and filled with the last one before them: a run of equal samples, too long for chance.

use super::dropped::{Gap, Kind};
use crate::identify::likelihood::observed::accelerations;
use crate::recording::Recording;

/// Fewest samples of a run: a coarse converter holds a slow motion for a few.
const FEWEST: usize = 8;
/// Greatest probability of such a run anywhere in a recording whose other samples are what they are.
const BY_CHANCE: f64 = 1e-9;

/// Runs of equal samples of the channel that holds most; none if a converter of its steps has such runs, or where they are at a limit
/// of the sensor.
pub fn gaps(recording: &Recording) -> Vec<Gap> {
    let channels = accelerations(recording).into_iter().flatten().map(|channel| runs(&channel.samples));
    channels.max_by_key(|gaps| gaps.iter().map(|gap| gap.count).sum::<usize>()).unwrap_or_default()
}

fn runs(samples: &[f64]) -> Vec<Gap> {
    let runs: Vec<&[f64]> = samples.chunk_by(|a, b| a == b).collect();
    // Others of a length are no evidence against the converter.
    let repeats = |run: &&[f64]| run.len() - 1;
    let equal: usize = runs.iter().map(repeats).sum();
    let gap = |(first, run): (usize, &[f64])| {
        let count = run.len() - 1;
        let beyond = |side: f64| samples.iter().any(|v| side * (v - run[0]) > 0.0);
        if run.len() < FEWEST || !(beyond(1.0) && beyond(-1.0)) {
            return None;
        }
        let share = (equal - count + 1) as f64 / samples.len() as f64;
        let chance = samples.len() as f64 * share.powi(count as i32);
        let z = (-2.0 * chance.ln()).sqrt();
        (chance < BY_CHANCE).then_some(Gap { sample: first, count, z, kind: Kind::Held })
    };
    let firsts = runs.iter().scan(0, |next, run| Some(std::mem::replace(next, *next + run.len())));
    firsts.zip(runs.iter().copied()).filter_map(gap).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{Start, simulate};

    fn of(change: impl Fn(&mut Vec<f64>)) -> Vec<[usize; 2]> {
        let mut recording = simulate(&nominal(), &condition(30.0, 800.0, 12_800), &Start::seeded(3)).unwrap();
        change(&mut recording.channels.iter_mut().find(|c| c.name == "ay").unwrap().samples);
        gaps(&recording).iter().map(|gap| [gap.sample, gap.count]).collect()
    }

    #[test]
    fn runs_are_found_and_a_coarse_converter_or_a_limit_is_none() {
        assert_eq!(of(|_| ()).len(), 0);
        let found = of(|samples| {
            for (first, count) in [(4000, 40), (5000, 900)] {
                let last = samples[first];
                samples[first + 1..=first + count].fill(last);
            }
        });
        assert_eq!(found, [[4000, 40], [5000, 900]]);
        let step = 2.0;
        assert_eq!(of(|samples| samples.iter_mut().for_each(|v| *v = (*v / step).round() * step)).len(), 0);
        assert_eq!(of(|samples| samples.iter_mut().take(40).for_each(|v| *v = 1e3)).len(), 0);
    }
}
