//! A first look at every hypothesis: many short runs side by side, and what each promises.

use rayon::prelude::*;

use super::closer::{scanned, timed};
use super::hypothesis::{Hypothesis, Start};
use crate::rig::{OperatingCondition, Rig, RigError};
use crate::whittle::align;
use crate::whittle::likelihood::{Expected, judged, means, variance};
use crate::whittle::observed::{Coefficients, Observed};

/// Share of the greatest promise below which another is not looked at more closely.
const HOPELESS: f64 = 0.04;
/// Starts of a hypothesis, and shares of their scaled strength, that are tried for what they hold.
const HELD: usize = 3;
const SHARES: [f64; 3] = [1.0, 0.4, 0.15];
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
    /// Those that suit the rig with the effect: a pit's pulses outweigh what the balls' passing gives, and the shaft's
    /// angle shows only in what turns with it.
    Aligned,
    /// These.
    Given(Vec<[f64; 2]>),
    /// These, moved in time to where they suit the rig with the effect better.
    Near(Vec<[f64; 2]>),
}

/// The best start of each hypothesis that can be simulated at all.
///
/// # Errors
/// What the simulation refuses before it runs.
pub fn screen(ground: &Ground, rig: &Rig, hypotheses: &[(usize, &Hypothesis)]) -> Result<Vec<Promise>, RigError> {
    let of = |n: usize, h: &Hypothesis, start: &Start| Try {
        hypothesis: n,
        start: start.clone(),
        angles: if h.has_angles_of_its_own() { Angles::Aligned } else { Angles::Ground },
    };
    let tries: Vec<Try> = hypotheses.iter().flat_map(|(n, h)| h.starts.iter().map(move |s| of(*n, h, s))).collect();
    let promises = evaluate(ground, rig, &tries, Strength::Scaled)?;
    let mut best: Vec<Promise> = Vec::new();
    for promise in &promises {
        // Of a pit, one of each width: from the wrong one no search comes to the right one.
        let width = |p: &Promise| p.start.effect.number("width_rad");
        if !best.iter().any(|b| b.hypothesis == promise.hypothesis && width(b) == width(promise)) {
            best.push(promise.clone());
        }
    }
    let most = best.iter().map(|b| b.gain).fold(0.0, f64::max);
    for promise in &mut best {
        // A pit that promises next to nothing beside others is not worth a closer look.
        if promise.start.is_pit() && promise.gain > HOPELESS * most {
            *promise = scanned(ground, rig, promise)?;
        } else if promise.start.is_timed() {
            *promise = timed(ground, rig, promise)?;
        }
    }
    hold(ground, rig, &promises, &mut best)?;
    Ok(best)
}

/// What promises hold: a strength that was found as if all were linear is tried as it is, and weaker.
fn hold(ground: &Ground, rig: &Rig, all: &[Promise], best: &mut [Promise]) -> Result<(), RigError> {
    let most = best.iter().map(|b| b.gain).fold(0.0, f64::max);
    let mut tries = Vec::new();
    for (number, promise) in best.iter().enumerate().filter(|(_, p)| p.gain > HOPELESS * most) {
        let Some(key) = promise.start.strength() else { continue };
        // Another start may hold more than the one that promises most; what was looked at more closely is past that.
        let closer = promise.start.is_timed() || promise.start.is_pit();
        let others = all.iter().filter(|p| !closer && p.hypothesis == promise.hypothesis).skip(1).take(HELD - 1);
        for from in std::iter::once(promise).chain(others) {
            tries.extend(SHARES.map(|share| {
                let strength = from.start.nothing + (from.start.number(key) - from.start.nothing) * share;
                let angles = Angles::Given(from.angles.clone());
                Try { hypothesis: number, start: from.start.with(key, strength), angles }
            }));
        }
    }
    let held = evaluate(ground, rig, &tries, Strength::Given)?;
    for (number, promise) in best.iter_mut().enumerate() {
        if let Some(found) = held.iter().find(|h| h.hypothesis == number) {
            *promise = Promise { hypothesis: promise.hypothesis, ..found.clone() };
        }
    }
    Ok(())
}

/// Which strength a try is judged at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strength {
    /// Its own.
    Given,
    /// The one that would promise most if what it changes were in proportion to it.
    Scaled,
}

/// Every start that can be simulated, the most promising first.
///
/// # Errors
/// What the simulation refuses before it runs.
pub fn evaluate(ground: &Ground, rig: &Rig, tries: &[Try], strength: Strength) -> Result<Vec<Promise>, RigError> {
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
        let mut found = align::angles_of_many(&turned, ground.observed, &variances, &ground.angles)?.into_iter();
        let angles: Vec<Vec<[f64; 2]>> = batch
            .iter()
            .map(|(t, _)| match &t.angles {
                Angles::Ground => ground.angles.clone(),
                Angles::Aligned => found.next().flatten().unwrap_or_else(|| ground.angles.clone()),
                Angles::Given(angles) | Angles::Near(angles) => angles.clone(),
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
                // What happens to the machine at a time of its own stays there; what is missing in a file is not the machine's.
                let stays = t.start.is_timed() && t.start.strength().is_some();
                if stays || !matches!(t.angles, Angles::Ground | Angles::Near(_)) {
                    return promise(ground, t, rig, angles, &means, strength);
                }
                let each = ground.observed.iter().zip(&ground.expected).zip(means.iter().zip(angles));
                let (means, angles): (Vec<_>, Vec<_>) =
                    each.map(|((o, e), (mean, angles))| align::moved(rig, o, &e.variance, mean, *angles)).unzip();
                promise(ground, t, rig, &angles, &means.iter().collect::<Vec<_>>(), strength)
            })
            .collect();
        promises.extend(judged.into_iter().flatten());
    }
    promises.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    Ok(promises)
}

fn promise(
    ground: &Ground,
    of: &Try,
    rig: &Rig,
    angles: &[[f64; 2]],
    means: &[&[Coefficients; 2]],
    strength: Strength,
) -> Option<Promise> {
    let moves_variance = !of.start.effect.definition().is_some_and(|d| d.deterministic);
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
    let mut start = of.start.clone();
    let scale = if square > 0.0 { along / square } else { 1.0 };
    let scaled = if square > 0.0 { along * along / square } else { 0.0 };
    if strength == Strength::Scaled
        && scaled > gain
        && (0.02..50.0).contains(&scale)
        && let Some(key) = start.strength()
    {
        start = start.with(key, start.nothing + (start.number(key) - start.nothing) * scale);
        gain = scaled;
    }
    Some(Promise { hypothesis: of.hypothesis, start, angles: angles.to_vec(), gain })
}
