//! A first look at every hypothesis: many short runs side by side, and what each promises.

use rayon::prelude::*;

use super::closer::{scanned, timed};
use super::hypothesis::{Hypothesis, Start};
use crate::rig::{OperatingCondition, Rig, RigError};
use crate::whittle::align;
use crate::whittle::likelihood::{Expected, judged, means, variance};
use crate::whittle::observed::{Coefficients, Observed};

/// Share of the greatest promise below which a pit is not looked at more closely.
const HOPELESS: f64 = 0.04;
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
    let mut best: Vec<Promise> = Vec::new();
    for promise in evaluate(ground, rig, &tries)? {
        // Of a pit, one of each width: from the wrong one no search comes to the right one.
        let width = |p: &Promise| p.start.effect.number("width_rad");
        if !best.iter().any(|b| b.hypothesis == promise.hypothesis && width(b) == width(&promise)) {
            best.push(promise);
        }
    }
    let most = best.iter().map(|b| b.gain).fold(0.0, f64::max);
    for promise in &mut best {
        let Some((_, hypothesis)) = hypotheses.iter().find(|(n, _)| *n == promise.hypothesis) else { continue };
        // A pit that promises next to nothing beside others is not worth a closer look.
        if hypothesis.is_pit() && promise.gain > HOPELESS * most {
            *promise = scanned(ground, rig, promise)?;
        } else if promise.start.is_timed() {
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
                    return promise(ground, t.hypothesis, &t.start, rig, angles, &means);
                }
                let each = ground.observed.iter().zip(&ground.expected).zip(means.iter().zip(angles));
                let (means, angles): (Vec<_>, Vec<_>) =
                    each.map(|((o, e), (mean, angles))| align::moved(rig, o, &e.variance, mean, *angles)).unzip();
                promise(ground, t.hypothesis, &t.start, rig, &angles, &means.iter().collect::<Vec<_>>())
            })
            .collect();
        promises.extend(judged.into_iter().flatten());
    }
    promises.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    Ok(promises)
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
    if scaled > gain
        && (0.02..50.0).contains(&scale)
        && let Some(strength) = start.strength()
    {
        start = start.with(strength, start.nothing + (start.number(strength) - start.nothing) * scale);
        gain = scaled;
    }
    Some(Promise { hypothesis, start, angles: angles.to_vec(), gain })
}
