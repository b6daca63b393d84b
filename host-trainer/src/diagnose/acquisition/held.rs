//! Samples that a logger lost and filled with the last one before them: a run of equal samples, too long for chance.

use super::dropped::{Gap, Kind};
use crate::identify::likelihood::observed::accelerations;
use crate::recording::Recording;

/// Fewest samples of a run: a coarse converter holds a slow motion for a few.
const FEWEST: usize = 8;
/// Greatest probability of such a run anywhere in a recording whose other samples are what they are.
const BY_CHANCE: f64 = 1e-9;

/// Longest run of equal samples of a recording; `None` if a converter of its steps has such runs, or if it is at a limit of the sensor.
pub fn gap(recording: &Recording) -> Option<Gap> {
    let channels = accelerations(recording);
    let runs = channels.into_iter().flatten().filter_map(|channel| run(&channel.samples));
    runs.max_by_key(|gap| gap.count)
}

fn run(samples: &[f64]) -> Option<Gap> {
    let (mut longest, mut length) = ((0, 0), 1);
    for k in 1..samples.len() {
        length = if samples[k] == samples[k - 1] { length + 1 } else { 1 };
        if length > longest.1 {
            longest = (k + 1 - length, length);
        }
    }
    let (first, count) = longest;
    let value = *samples.get(first)?;
    let beyond = |side: f64| samples.iter().any(|v| side * (v - value) > 0.0);
    if count < FEWEST || !(beyond(1.0) && beyond(-1.0)) {
        return None;
    }
    // Others of the same length are no evidence against the converter.
    let equal = samples.windows(2).filter(|pair| pair[0] == pair[1]).count().saturating_sub(count - 1);
    let share = (equal + 1) as f64 / samples.len() as f64;
    let chance = samples.len() as f64 * share.powi(count as i32 - 1);
    (chance < BY_CHANCE).then_some(Gap {
        sample: first,
        count: count - 1,
        z: (-2.0 * chance.ln()).sqrt(),
        kind: Kind::Held,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{Start, simulate};

    fn of(change: impl Fn(&mut Vec<f64>)) -> Option<Gap> {
        let mut recording = simulate(&nominal(), &condition(30.0, 800.0, 12_800), &Start::seeded(3)).unwrap();
        change(&mut recording.channels.iter_mut().find(|c| c.name == "ay").unwrap().samples);
        gap(&recording)
    }

    #[test]
    fn a_run_is_found_and_a_coarse_converter_or_a_limit_is_none() {
        assert_eq!(of(|_| ()), None);
        let found = of(|samples| {
            let last = samples[4000];
            samples[4001..4041].fill(last);
        });
        assert_eq!(found.map(|gap| (gap.sample, gap.count)), Some((4000, 40)));
        let step = 2.0;
        assert_eq!(of(|samples| samples.iter_mut().for_each(|v| *v = (*v / step).round() * step)), None);
        assert_eq!(of(|samples| samples.iter_mut().take(40).for_each(|v| *v = 1e3)), None);
    }
}
