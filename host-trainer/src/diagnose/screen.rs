//! A first look at every hypothesis: many short runs side by side, and what each promises.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::hypothesis::{Hypothesis, Start};
use crate::rig::{OperatingCondition, Rig, RigError};
use crate::whittle::align;
use crate::whittle::likelihood::{Expected, judged, means, variance};
use crate::whittle::observed::{Coefficients, Observed};

/// Runs that are held in memory at a time.
const BATCH: usize = 128;

/// What a start promises.
#[derive(Clone, Debug)]
pub struct Promise {
    /// Which hypothesis.
    pub hypothesis: usize,
    /// Where from, its strength scaled where that promises more.
    pub start: Start,
    /// Angles at the beginning of each recording.
    pub angles: Vec<[f64; 2]>,
    /// Gain in ln L.
    pub gain: f64,
}

/// Recordings under the rig without anything more.
pub struct Ground<'o> {
    /// The recordings.
    pub observed: &'o [Observed],
    /// Their angles.
    pub angles: Vec<[f64; 2]>,
    /// What the rig says of them.
    pub expected: Vec<Expected>,
}

/// A start with the angles to begin at: those of the ground, those that suit it best, or its own.
#[derive(Clone, Debug)]
pub struct Try {
    /// Which hypothesis.
    pub hypothesis: usize,
    /// Where from.
    pub start: Start,
    /// How the angles are chosen.
    pub angles: Angles,
}

/// How the angles of a try are chosen.
#[derive(Clone, Debug)]
pub enum Angles {
    /// Those of the rig without the effect.
    Ground,
    /// Those that suit the rig with the effect: a pit's pulses outweigh what the balls' passing gives.
    Aligned,
    /// These.
    Given(Vec<[f64; 2]>),
}

/// The best start of each hypothesis that can be simulated at all.
///
/// # Errors
/// What the simulation refuses before it runs.
pub fn screen(ground: &Ground, rig: &Rig, hypotheses: &[(usize, &Hypothesis)]) -> Result<Vec<Promise>, RigError> {
    let of = |n: usize, h: &Hypothesis, start: &Start| Try {
        hypothesis: n,
        start: start.clone(),
        angles: if h.is_pit() { Angles::Aligned } else { Angles::Ground },
    };
    let tries: Vec<Try> = hypotheses.iter().flat_map(|(n, h)| h.starts.iter().map(move |s| of(*n, h, s))).collect();
    let mut best: Vec<Promise> = Vec::new();
    for promise in evaluate(ground, rig, &tries)? {
        if !best.iter().any(|b| b.hypothesis == promise.hypothesis) {
            best.push(promise);
        }
    }
    for promise in &mut best {
        let Some((_, hypothesis)) = hypotheses.iter().find(|(n, _)| *n == promise.hypothesis) else { continue };
        if hypothesis.is_pit() {
            *promise = scanned(ground, rig, promise)?;
        } else if promise.start.effect.parameters.contains_key("time_s") {
            *promise = timed(ground, rig, promise)?;
        }
    }
    Ok(best)
}

/// Every start that can be simulated, the most promising first.
///
/// # Errors
/// What the simulation refuses before it runs.
pub fn evaluate(ground: &Ground, rig: &Rig, tries: &[Try]) -> Result<Vec<Promise>, RigError> {
    let tries: Vec<(&Try, Rig)> = tries
        .iter()
        .map(|t| (t, rig.clone().with_effect(t.start.effect.clone())))
        .filter(|(_, r)| r.check().is_ok())
        .collect();
    let variances = ground.expected.iter().map(|e| e.variance.clone()).collect::<Vec<_>>();
    let mut promises: Vec<Promise> = Vec::new();
    for batch in tries.chunks((BATCH / ground.observed.len()).max(1)) {
        let turned: Vec<&Rig> =
            batch.iter().filter(|(t, _)| matches!(t.angles, Angles::Aligned)).map(|(_, rig)| rig).collect();
        let mut found = align::angles_of_many(&turned, ground.observed, &variances)?.into_iter();
        let angles: Vec<Vec<[f64; 2]>> = batch
            .iter()
            .map(|(t, _)| match &t.angles {
                Angles::Ground => ground.angles.clone(),
                Angles::Aligned => found.next().flatten().unwrap_or_else(|| ground.angles.clone()),
                Angles::Given(angles) => angles.clone(),
            })
            .collect();
        let mut runs: Vec<(&Rig, OperatingCondition, [f64; 2])> = Vec::new();
        for ((_, rig), angles) in batch.iter().zip(&angles) {
            runs.extend(ground.observed.iter().zip(angles).map(|(o, a)| (rig, o.condition, *a)));
        }
        let means = means(&runs)?;
        let judged: Vec<Option<Promise>> = batch
            .par_iter()
            .zip(&angles)
            .zip(means.par_chunks(ground.observed.len()))
            .map(|(((t, rig), angles), means)| {
                let means: Vec<&[Coefficients; 2]> = means.iter().map(|m| m.as_ref().ok()).collect::<Option<_>>()?;
                promise(ground, t.hypothesis, &t.start, rig, angles, &means)
            })
            .collect();
        promises.extend(judged.into_iter().flatten());
    }
    promises.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    Ok(promises)
}

/// A pit's width and place, scanned finely: a ball takes a time over the pit that is a few periods of the fastest mode, so
/// that widths half a period apart look alike and a search would stop at the wrong one; likewise the pulses, which hold
/// the ball's angle to the pit's, and the balls' passing, which holds it to the load's.
fn scanned(ground: &Ground, rig: &Rig, promise: &Promise) -> Result<Promise, RigError> {
    let Some(machine) = rig.bearing() else { return Ok(promise.clone()) };
    let orders = machine.bearing.geometry().orders();
    let shaft_hz = ground.observed.iter().map(|o| o.condition.shaft_hz).sum::<f64>() / ground.observed.len() as f64;
    // Turns of the ball against the pit for each turn of the shaft.
    let passing = match promise.start.effect.name.as_str() {
        "outer-race-defect" => orders.ftf,
        "inner-race-defect" => 1.0 - orders.ftf,
        _ => orders.bsf,
    };
    let resonator = &machine.resonator;
    let fastest_hz =
        (resonator.stiffness_n_per_m * (1.0 / resonator.mass_kg + 1.0 / machine.outer.mass_kg)).sqrt() / TAU;
    let step = TAU * passing * shaft_hz / (2.0 * fastest_hz.max(500.0));
    let mut best = promise.clone();
    for scan in 0..3 {
        let tries: Vec<Try> = if scan == 1 {
            turned(&best)
        } else {
            let widths = (1..=48).map(|k| 0.6 * step * f64::from(k)).chain([best.start.number("width_rad")]);
            widths
                .map(|w| Try {
                    hypothesis: best.hypothesis,
                    start: best.start.with("width_rad", w),
                    angles: Angles::Given(best.angles.clone()),
                })
                .collect()
        };
        if let Some(found) = evaluate(ground, rig, &tries)?.into_iter().next().filter(|f| f.gain > best.gain) {
            best = found;
        }
    }
    Ok(best)
}

/// A time, scanned ever finer: a step or an impact has to be met to a part of the fastest mode's period.
fn timed(ground: &Ground, rig: &Rig, promise: &Promise) -> Result<Promise, RigError> {
    let sample_s = 1.0 / ground.observed.first().map_or(1.0, |o| o.condition.sample_rate_hz);
    let mut best = promise.clone();
    for step in [8.0, 1.0, 0.2] {
        let of = |k: i32| Try {
            hypothesis: best.hypothesis,
            start: best.start.with("time_s", best.start.number("time_s") + f64::from(k) * step * sample_s),
            angles: Angles::Ground,
        };
        // The strength is no longer the one that suited another time: from a tenth of it on, it is scaled.
        let strength = best.start.free[1];
        let weak = |mut t: Try| {
            t.start = t.start.with(strength, 0.1 * t.start.number(strength));
            t
        };
        let tries: Vec<Try> = (-12..=12).flat_map(|k| [of(k), weak(of(k))]).collect();
        if let Some(found) = evaluate(ground, rig, &tries)?.into_iter().next().filter(|f| f.gain > best.gain) {
            best = found;
        }
    }
    Ok(best)
}

/// The same pulses with the balls elsewhere under the load.
fn turned(promise: &Promise) -> Vec<Try> {
    let of = |by: f64| {
        let key = promise.start.free[2];
        let moves_cage = promise.start.effect.name == "outer-race-defect";
        let angles = promise.angles.iter().map(
            |[cage, shaft]| {
                if moves_cage { [cage + by, *shaft] } else { [*cage, shaft - by] }
            },
        );
        Try {
            hypothesis: promise.hypothesis,
            start: promise.start.with(key, promise.start.number(key) + by),
            angles: Angles::Given(angles.collect()),
        }
    };
    match promise.start.effect.name.as_str() {
        "outer-race-defect" => (-30..=30).map(|k| of(0.02 * f64::from(k))).collect(),
        "inner-race-defect" => (0..24).map(|k| of(TAU / 24.0 * f64::from(k))).collect(),
        _ => Vec::new(),
    }
}

fn promise(
    ground: &Ground,
    hypothesis: usize,
    start: &Start,
    rig: &Rig,
    angles: &[[f64; 2]],
    means: &[&[Coefficients; 2]],
) -> Option<Promise> {
    let moves_variance = !start.effect.definition().is_some_and(|d| d.deterministic);
    let (mut gain, mut along, mut square) = (0.0, 0.0, 0.0);
    for ((o, without), mean) in ground.observed.iter().zip(&ground.expected).zip(means) {
        let own = if moves_variance { Some(variance(rig, &o.condition).ok()?) } else { None };
        for channel in 0..2 {
            let Some(x) = &o.spectra[channel] else { continue };
            let s = &without.variance[channel];
            let t = own.as_ref().map_or(s, |own| &own[channel]);
            for k in judged(x, 1.0) {
                let residual = x[k] - without.mean[channel][k];
                let change = mean[channel][k] - without.mean[channel][k];
                gain += s[k].ln() + residual.norm_sqr() / s[k] - t[k].ln() - (residual - change).norm_sqr() / t[k];
                along += (residual.conj() * change).re / s[k];
                square += change.norm_sqr() / s[k];
            }
        }
    }
    if !gain.is_finite() {
        return None;
    }
    let mut start = start.clone();
    let scale = if square > 0.0 { along / square } else { 1.0 };
    let scaled = if square > 0.0 { along * along / square } else { 0.0 };
    if scaled > gain && (0.02..50.0).contains(&scale) {
        // A time is no strength.
        let strength = *start.free.iter().find(|key| **key != "time_s")?;
        start = start.with(strength, start.number(strength) * scale);
        gain = scaled;
    }
    Some(Promise { hypothesis, start, angles: angles.to_vec(), gain })
}
