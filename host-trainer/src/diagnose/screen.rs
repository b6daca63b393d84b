//! A first look at every hypothesis: many short runs side by side, and what each promises.

use std::f64::consts::TAU;

use super::closer::{by_tachometers, scanned, timed, tuned};
use super::hypothesis::{Hypothesis, Start};
use super::promise::{Angles, Backdrop, Promise, Strength, Try, evaluate};
use crate::rig::{Rig, RigError};

/// Share of the greatest promise below which another is not looked at more closely.
const HOPELESS: f64 = 0.04;
/// The same of what happens at a time of its own, which promises little a part of a sample from there; and the share of what it
/// must gain in the end.
const HOPELESS_NEAR_ITS_TIME: f64 = 0.01;
const GAINS_NEAR_ITS_TIME: f64 = 0.5;
/// Places of a wave of the inner race that are tried, evenly over its length.
const AROUND: u32 = 4;
/// Starts of a hypothesis, and shares of their scaled strength, that are tried for what they hold.
const HELD: usize = 3;
const SHARES: [f64; 3] = [1.0, 0.4, 0.15];

/// What a first look is measured by, in ln L of the recordings that are looked at.
#[derive(Clone, Copy, Debug)]
pub struct Stakes {
    /// What a hypothesis must gain in the end.
    pub least: f64,
    /// What others are known to promise.
    pub others: f64,
}

/// The best start of each hypothesis that can be simulated at all. What promises next to nothing beside the best, or beside what
/// is at stake, is not looked at more closely.
///
/// # Errors
/// What the simulation refuses before it runs.
pub fn screen(
    backdrop: &Backdrop,
    rig: &Rig,
    hypotheses: &[(usize, &Hypothesis)],
    stakes: Stakes,
) -> Result<Vec<Promise>, RigError> {
    let of = |(n, h): &(usize, &Hypothesis)| -> Vec<Try> {
        h.starts.iter().flat_map(|start| tries_from(backdrop, *n, h, start)).collect()
    };
    let tries: Vec<Try> = hypotheses.iter().flat_map(of).collect();
    let promises = evaluate(backdrop, rig, &tries, Strength::Scaled)?;
    let mut best: Vec<Promise> = Vec::new();
    for promise in &promises {
        // Of a pit, one of each width: from the wrong one no search comes to the right one.
        let width = |p: &Promise| p.start.effect.number("width_rad");
        if !best.iter().any(|b| b.hypothesis == promise.hypothesis && width(b) == width(promise)) {
            best.push(promise.clone());
        }
    }
    let most = best.iter().map(|b| b.gain).fold(stakes.others, f64::max);
    let hopeless = HOPELESS * most.max(stakes.least);
    for promise in &mut best {
        if promise.start.is_pit() && promise.gain > hopeless {
            *promise = scanned(backdrop, rig, promise)?;
        } else if promise.start.is_mode() && promise.gain > hopeless {
            *promise = tuned(backdrop, rig, promise)?;
        } else if promise.start.is_timed() {
            let least = (HOPELESS_NEAR_ITS_TIME * most).max(GAINS_NEAR_ITS_TIME * stakes.least);
            *promise = timed(backdrop, rig, promise, least)?;
        }
    }
    by_tachometers(backdrop, rig, &mut best)?;
    hold(backdrop, rig, &promises, &mut best)?;
    Ok(best)
}

/// What is tried of a start: the angles that suit it, and of a wavy inner race, where tachometers tell the shaft's angle, those of
/// the rig without it with the lobes all around the shaft.
fn tries_from(backdrop: &Backdrop, hypothesis: usize, of: &Hypothesis, start: &Start) -> Vec<Try> {
    let angles = match &start.leads {
        Some(leads) => Angles::Moved(leads.clone()),
        None if of.has_angles_of_its_own() => Angles::Aligned,
        None => Angles::Bare,
    };
    let mut tries = vec![Try { hypothesis, start: start.clone(), angles }];
    let lobes = start.number("lobes");
    if start.effect.is_on_shaft() && lobes > 0.0 && backdrop.observed.iter().all(|o| o.tachometer.is_some()) {
        let turned = |k: u32| start.turned_on_shaft(f64::from(k) * TAU / f64::from(AROUND) / lobes);
        tries.extend((0..AROUND).map(|k| Try { hypothesis, start: turned(k), angles: Angles::Bare }));
    }
    tries
}

/// What promises hold: a strength that was found as if all were linear is tried as it is, and weaker.
fn hold(backdrop: &Backdrop, rig: &Rig, all: &[Promise], best: &mut [Promise]) -> Result<(), RigError> {
    let most = best.iter().map(|b| b.gain).fold(0.0, f64::max);
    let mut tries = Vec::new();
    for (number, promise) in best.iter().enumerate().filter(|(_, p)| p.gain > HOPELESS * most) {
        let Some(key) = promise.start.strength() else { continue };
        // Another start may hold more than the one that promises most; what was looked at more closely is past that.
        let closer = promise.start.is_timed() || promise.start.is_pit() || promise.start.is_mode();
        let others = all.iter().filter(|p| !closer && p.hypothesis == promise.hypothesis).skip(1).take(HELD - 1);
        for from in std::iter::once(promise).chain(others) {
            tries.extend(SHARES.map(|share| {
                let strength = from.start.nothing + (from.start.number(key) - from.start.nothing) * share;
                let angles = Angles::Given(from.angles.clone());
                Try { hypothesis: number, start: from.start.with(key, strength), angles }
            }));
        }
    }
    let held = evaluate(backdrop, rig, &tries, Strength::Given)?;
    for (number, promise) in best.iter_mut().enumerate() {
        match held.iter().find(|h| h.hypothesis == number) {
            Some(found) => *promise = Promise { hypothesis: promise.hypothesis, ..found.clone() },
            // What was not tried counts as if only its weakest share held; without a strength there was nothing to scale.
            None if promise.start.strength().is_some() => promise.gain *= (2.0 - SHARES[2]) * SHARES[2],
            None => {}
        }
    }
    Ok(())
}
