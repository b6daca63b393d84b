//! Recordings that took no part in the fit, simulated.

use super::{causes::Cause, diagnose::fitted, equation::Parameter, finding::HeldOutTrace, shooting, states::States};
use crate::rig::Rig;

/// Traces of the held-out recordings. `plain` is the rig with its unknown parameters fitted, `corrected` the same with
/// the causes; from the effect of index `first` on they are fitted again to the recordings that are left. Each simulation
/// starts where it leaves least.
pub fn traces(
    plain: &Rig,
    corrected: &Rig,
    first: usize,
    causes: &[Cause],
    unknown: &[Parameter],
    states: &States,
) -> Vec<HeldOutTrace> {
    let Some((train, test, _)) = states.split() else { return Vec::new() };
    let again: Vec<Cause> = causes
        .iter()
        .zip(&corrected.effects[first..])
        .map(|(cause, entry)| Cause { entry: entry.clone(), ..cause.clone() })
        .collect();
    let mut base = corrected.clone();
    base.effects.truncate(first);
    let after = fitted(base, &again, unknown, &train).0;
    let before = fitted(plain.clone(), &[], unknown, &train).0;
    simulated(&before, &after, &test)
}

/// Recordings as measured and as two rigs give them, each from the start that leaves least; those that diverge are left
/// out.
pub fn simulated(before: &Rig, after: &Rig, test: &States) -> Vec<HeldOutTrace> {
    let one = |index: usize| {
        let alone = States { tracks: vec![test.tracks[index].clone()], ..test.clone() };
        let track = &alone.tracks[0];
        let (before, after) = (shooting::follow(before, &alone)?, shooting::follow(after, &alone)?);
        Some(HeldOutTrace {
            recording: track.name.clone(),
            channel: alone.sensed.channel(),
            time_s: (0..track.len()).map(|k| k as f64 * alone.step_s()).collect(),
            measured: track.sensed.clone(),
            before,
            after,
        })
    };
    (0..test.tracks.len()).filter_map(one).collect()
}
