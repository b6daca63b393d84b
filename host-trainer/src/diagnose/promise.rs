//! What a start promises: one run of it, beside what the rig says without it.

use rayon::prelude::*;

use super::hypothesis::Start;
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

/// Recordings, and what the rig says of them without anything more: what promises are seen against.
pub struct Backdrop<'o> {
    /// The recordings.
    pub observed: &'o [Observed],
    /// Their angles.
    pub angles: Vec<[f64; 2]>,
    /// What the rig says of them.
    pub expected: Vec<Expected>,
}

/// A start with the angles to begin at: those of the backdrop, those that suit it best, or its own.
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
    Bare,
    /// Those that suit the rig with the effect: a pit's pulses outweigh what the balls' passing gives, and the shaft's
    /// angle shows only in what turns with it.
    Aligned,
    /// Those of the rig without the effect, each recording's moved by so many samples.
    Moved(Vec<i64>),
    /// These.
    Given(Vec<[f64; 2]>),
    /// These, moved in time to where they suit the rig with the effect better.
    Near(Vec<[f64; 2]>),
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
pub fn evaluate(backdrop: &Backdrop, rig: &Rig, tries: &[Try], strength: Strength) -> Result<Vec<Promise>, RigError> {
    let tries: Vec<(&Try, Rig)> = tries
        .iter()
        .map(|t| (t, rig.clone().with_effect(t.start.effect.clone())))
        .filter(|(_, r)| r.check().is_ok())
        .collect();
    let variances = backdrop.expected.iter().map(|e| e.variance.clone()).collect::<Vec<_>>();
    let mut promises: Vec<Promise> = Vec::new();
    for batch in tries.chunks((BATCH / backdrop.observed.len()).max(1)) {
        let turned: Vec<&Rig> =
            batch.iter().filter(|(t, _)| matches!(t.angles, Angles::Aligned)).map(|(_, rig)| rig).collect();
        let mut found = align::angles_of_many(&turned, backdrop.observed, &variances, &backdrop.angles)?.into_iter();
        let angles: Vec<Vec<[f64; 2]>> = batch
            .iter()
            .map(|(t, _)| match &t.angles {
                Angles::Bare => backdrop.angles.clone(),
                Angles::Aligned => found.next().flatten().unwrap_or_else(|| backdrop.angles.clone()),
                Angles::Moved(leads) => {
                    let each = backdrop.observed.iter().zip(leads).zip(&backdrop.angles);
                    each.map(|((o, lead), a)| align::moved_angles(rig, o, *lead, *a)).collect()
                }
                Angles::Given(angles) | Angles::Near(angles) => angles.clone(),
            })
            .collect();
        let mut runs: Vec<(&Rig, OperatingCondition, [f64; 2])> = Vec::new();
        for ((_, rig), angles) in batch.iter().zip(&angles) {
            runs.extend(backdrop.observed.iter().zip(angles).map(|(o, a)| (rig, o.condition, *a)));
        }
        let means = means(&runs)?;
        let judged: Vec<Option<Promise>> = batch
            .par_iter()
            .zip(&angles)
            .zip(means.par_chunks(backdrop.observed.len()))
            .map(|(((t, rig), angles), means)| {
                let means: Vec<&[Coefficients; 2]> = means.iter().map(|m| m.as_ref().ok()).collect::<Option<_>>()?;
                let as_it_is = promise(backdrop, t, rig, &Runs { angles, means: &means, base: None }, strength);
                // What happens at a time of its own stays there.
                if t.start.is_timed() || !matches!(t.angles, Angles::Bare | Angles::Near(_)) {
                    return as_it_is;
                }
                let moved = moved(backdrop, t, rig, angles, &means, strength);
                as_it_is.into_iter().chain(moved).max_by(|a, b| a.gain.total_cmp(&b.gain))
            })
            .collect();
        promises.extend(judged.into_iter().flatten());
    }
    promises.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    Ok(promises)
}

/// The same, moved in time to where it suits the recordings better; nothing where it need not be.
fn moved(
    backdrop: &Backdrop,
    of: &Try,
    rig: &Rig,
    angles: &[[f64; 2]],
    means: &[&[Coefficients; 2]],
    strength: Strength,
) -> Option<Promise> {
    let lag = |((o, e), mean): ((&Observed, &Expected), &&[Coefficients; 2])| align::lag(rig, o, &e.variance, mean);
    let lags: Vec<i64> = backdrop.observed.iter().zip(&backdrop.expected).zip(means).map(lag).collect();
    if lags.iter().all(|lag| *lag == 0) {
        return None;
    }
    let each = || backdrop.observed.iter().zip(&lags);
    let angles: Vec<_> = each().zip(angles).map(|((o, lag), a)| align::moved_angles(rig, o, *lag, *a)).collect();
    let with: Vec<_> = each().zip(means).map(|((o, lag), mean)| align::moved_mean(o, *lag, mean)).collect();
    let base: Vec<_> =
        each().zip(&backdrop.expected).map(|((o, lag), e)| align::moved_mean(o, *lag, &e.mean)).collect();
    let with: Vec<_> = with.iter().collect();
    promise(backdrop, of, rig, &Runs { angles: &angles, means: &with, base: Some(&base) }, strength)
}

/// A try's runs.
struct Runs<'a> {
    angles: &'a [[f64; 2]],
    /// What is expected with the effect.
    means: &'a [&'a [Coefficients; 2]],
    /// What is expected without it where both have been moved in time; otherwise that is the backdrop's.
    base: Option<&'a [[Coefficients; 2]]>,
}

/// The gain of one run. Where it is scaled, what it changes is taken to grow with its strength.
fn promise(backdrop: &Backdrop, of: &Try, rig: &Rig, runs: &Runs, strength: Strength) -> Option<Promise> {
    let moves_variance = !of.start.effect.definition().is_some_and(|d| d.deterministic);
    let (mut gain, mut along, mut square, mut lost) = (0.0, 0.0, 0.0, 0.0);
    for (n, (o, without)) in backdrop.observed.iter().zip(&backdrop.expected).enumerate() {
        let own = if moves_variance { Some(variance(rig, &o.condition).ok()?) } else { None };
        let base = runs.base.map_or(&without.mean, |base| &base[n]);
        for channel in 0..2 {
            let Some(x) = &o.spectra[channel] else { continue };
            let s = &without.variance[channel];
            let t = own.as_ref().map_or(s, |own| &own[channel]);
            for k in judged(x, 1.0) {
                let with = runs.means[n][channel][k];
                let before = (x[k] - without.mean[channel][k]).norm_sqr() / s[k];
                gain += s[k].ln() + before - t[k].ln() - (x[k] - with).norm_sqr() / t[k];
                let (residual, change) = (x[k] - base[channel][k], with - base[channel][k]);
                lost += residual.norm_sqr() / s[k] - before;
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
    let scaled = if square > 0.0 { along * along / square - lost } else { 0.0 };
    if strength == Strength::Scaled
        && scaled > gain
        && (0.02..50.0).contains(&scale)
        && let Some(key) = start.strength()
    {
        start = start.with(key, start.nothing + (start.number(key) - start.nothing) * scale);
        gain = scaled;
    }
    Some(Promise { hypothesis: of.hypothesis, start, angles: runs.angles.to_vec(), gain })
}
