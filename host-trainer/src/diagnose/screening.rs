//! Screening of all hypotheses by the expected gain of many short runs.

use crate::rig::effect::ParameterKey;
use std::f64::consts::TAU;

use super::hypothesis::{Hypothesis, Start};
use super::refine_starts::{by_tachometers, scanned, timed, tuned};
use super::start_score::{Angles, NullPrediction, StartScore, Strength, Trial, evaluate};
use crate::rig::{Rig, RigError};

/// Share of the greatest promise below which another is not looked at more closely.
const HOPELESS: f64 = 0.04;
/// The same of what happens at a time of its own, which scores little a part of a sample from there; and the share of what it
/// must gain in the end.
const HOPELESS_NEAR_ITS_TIME: f64 = 0.01;
const GAINS_NEAR_ITS_TIME: f64 = 0.5;
/// Places of a wave of the inner race that are tried, evenly over its length.
const AROUND: u32 = 4;
/// Starts of a hypothesis, and shares of their scaled strength, that are tried for what they hold.
const HELD: usize = 3;
const SHARES: [f64; 3] = [1.0, 0.4, 0.15];

/// Thresholds of screening, in ln L of the screened recordings.
#[derive(Clone, Copy, Debug)]
pub struct Stakes {
    /// Gain that a hypothesis must have in the end.
    pub least: f64,
    /// Expected gain of others.
    pub others: f64,
}

/// Best start of each hypothesis that can be simulated. Starts of small expected gain relative to the best, or to the required
/// gain, are not refined.
///
/// # Errors
/// Errors of the simulation before it runs.
pub fn screen(
    null: &NullPrediction,
    rig: &Rig,
    hypotheses: &[(usize, &Hypothesis)],
    stakes: Stakes,
) -> Result<Vec<StartScore>, RigError> {
    let of = |(n, h): &(usize, &Hypothesis)| -> Vec<Trial> {
        h.starts.iter().flat_map(|start| tries_from(null, *n, h, start)).collect()
    };
    let trials: Vec<Trial> = hypotheses.iter().flat_map(of).collect();
    let scores = evaluate(null, rig, &trials, Strength::Scaled)?;
    let mut best: Vec<StartScore> = Vec::new();
    for score in &scores {
        // Of a pit, one of each width: from the wrong one no search comes to the right one.
        let width = |p: &StartScore| p.start.effect.number(ParameterKey::WidthRad);
        if !best.iter().any(|b| b.hypothesis == score.hypothesis && width(b) == width(score)) {
            best.push(score.clone());
        }
    }
    let most = best.iter().map(|b| b.log_likelihood_gain).fold(stakes.others, f64::max);
    let hopeless = HOPELESS * most.max(stakes.least);
    for score in &mut best {
        if score.start.is_pit() && score.log_likelihood_gain > hopeless {
            *score = scanned(null, rig, score)?;
        } else if score.start.is_mode() && score.log_likelihood_gain > hopeless {
            *score = tuned(null, rig, score)?;
        } else if score.start.is_timed() {
            let least = (HOPELESS_NEAR_ITS_TIME * most).max(GAINS_NEAR_ITS_TIME * stakes.least);
            *score = timed(null, rig, score, least)?;
        }
    }
    by_tachometers(null, rig, &mut best)?;
    hold(null, rig, &scores, &mut best)?;
    Ok(best)
}

/// What is tried of a start: the angles that suit it, and of a wavy inner race, where tachometers tell the shaft's angle, those of
/// the rig without it with the lobes all around the shaft.
fn tries_from(null: &NullPrediction, hypothesis: usize, of: &Hypothesis, start: &Start) -> Vec<Trial> {
    let angles = match &start.leads {
        Some(leads) => Angles::Moved(leads.clone()),
        None if of.has_angles_of_its_own() => Angles::Aligned,
        None => Angles::Bare,
    };
    let mut trials = vec![Trial { hypothesis, start: start.clone(), angles }];
    let lobes = start.number(ParameterKey::Lobes);
    if start.effect.is_on_shaft() && lobes > 0.0 && null.observed.iter().all(|o| o.tachometer.is_some()) {
        let turned = |k: u32| start.turned_on_shaft(f64::from(k) * TAU / f64::from(AROUND) / lobes);
        trials.extend((0..AROUND).map(|k| Trial { hypothesis, start: turned(k), angles: Angles::Bare }));
    }
    trials
}

/// What scores hold: a strength that was found as if all were linear is tried as it is, and weaker.
fn hold(null: &NullPrediction, rig: &Rig, all: &[StartScore], best: &mut [StartScore]) -> Result<(), RigError> {
    let most = best.iter().map(|b| b.log_likelihood_gain).fold(0.0, f64::max);
    let mut trials = Vec::new();
    for (number, score) in best.iter().enumerate().filter(|(_, p)| p.log_likelihood_gain > HOPELESS * most) {
        let Some(key) = score.start.strength() else { continue };
        // Another start may hold more than the one that scores most; what was looked at more closely is past that.
        let closer = score.start.is_timed() || score.start.is_pit() || score.start.is_mode();
        let others = all.iter().filter(|p| !closer && p.hypothesis == score.hypothesis).skip(1).take(HELD - 1);
        for from in std::iter::once(score).chain(others) {
            trials.extend(SHARES.map(|share| {
                let strength = from.start.nothing + (from.start.number(key) - from.start.nothing) * share;
                let angles = Angles::Given(from.angles.clone());
                Trial { hypothesis: number, start: from.start.with(key, strength), angles }
            }));
        }
    }
    let held = evaluate(null, rig, &trials, Strength::Given)?;
    for (number, score) in best.iter_mut().enumerate() {
        match held.iter().find(|h| h.hypothesis == number) {
            Some(found) => *score = StartScore { hypothesis: score.hypothesis, ..found.clone() },
            // What was not tried counts as if only its weakest share held; without a strength there was nothing to scale.
            None if score.start.strength().is_some() => score.log_likelihood_gain *= (2.0 - SHARES[2]) * SHARES[2],
            None => {}
        }
    }
    Ok(())
}
