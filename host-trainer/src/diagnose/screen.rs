//! A first look at every hypothesis: many short runs side by side, and what each promises.

use std::f64::consts::TAU;

use rayon::prelude::*;
use realfft::num_complex::Complex;

use super::hypothesis::{Hypothesis, Start};
use super::residual::EDGE;
use crate::rig::{OperatingCondition, Rig, RigError};
use crate::whittle::align;
use crate::whittle::likelihood::{Expected, judged, means, variance};
use crate::whittle::observed::{Coefficients, Observed};

/// Share of the greatest promise.
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
    /// Those that suit the rig with the effect: a pit's pulses outweigh what the balls' passing gives.
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
    for scan in [Scan::Width, Scan::Place, Scan::Depth, Scan::Width, Scan::Place] {
        let other = |key: &str, value: f64| Try {
            hypothesis: best.hypothesis,
            start: best.start.with(key, value),
            angles: Angles::Near(best.angles.clone()),
        };
        let now = |key: &str| best.start.number(key);
        let tries: Vec<Try> = match scan {
            Scan::Place => turned(&best),
            Scan::Width => (1..=48).map(|k| other("width_rad", 0.6 * step * f64::from(k))).collect(),
            Scan::Depth => (-8..=8).map(|k| other("depth_m", now("depth_m") * 1.12f64.powi(k))).collect(),
        };
        if let Some(found) = evaluate(ground, rig, &tries)?.into_iter().next().filter(|f| f.gain > best.gain) {
            best = found;
        }
    }
    Ok(best)
}

/// What of a pit is scanned.
#[derive(Clone, Copy)]
enum Scan {
    Width,
    Place,
    Depth,
}

/// A time, first where the residual is most like what the effect gives, then scanned ever finer: a step or an impact has to
/// be met to a part of the fastest mode's period.
fn timed(ground: &Ground, rig: &Rig, promise: &Promise) -> Result<Promise, RigError> {
    let sample_s = 1.0 / ground.observed.first().map_or(1.0, |o| o.condition.sample_rate_hz);
    let mut best = promise.clone();
    for step in [0.0, 8.0, 1.0, 0.2] {
        let of = |time_s: f64| Try {
            hypothesis: best.hypothesis,
            start: best.start.with("time_s", time_s),
            angles: Angles::Given(best.angles.clone()),
        };
        let now = best.start.number("time_s");
        let times: Vec<f64> = if step == 0.0 {
            matched(ground, rig, &best)?
        } else {
            (-12..=12).map(|k| now + f64::from(k) * step * sample_s).collect()
        };
        // The strength is no longer the one that suited another time: from a tenth of it on, it is scaled, either way.
        let weaker = |t: Try| match best.start.strength() {
            Some(key) => {
                let by = |share: f64| Try { start: t.start.with(key, share * t.start.number(key)), ..t.clone() };
                vec![t.clone(), by(0.1), by(-0.1)]
            }
            None => vec![t],
        };
        let tries: Vec<Try> = times.into_iter().map(of).flat_map(weaker).collect();
        if let Some(found) = evaluate(ground, rig, &tries)?.into_iter().next().filter(|f| f.gain > best.gain) {
            best = found;
        }
    }
    if best.start.strength().is_some() {
        let with = rig.clone().with_effect(best.start.effect.clone());
        best.angles = align::angles_apart(rig, &with, ground.observed, &best.angles)?;
    }
    Ok(best)
}

/// Times at which the residual of all recordings together is most like what the effect changes, of either sign: a matched
/// filter.
fn matched(ground: &Ground, rig: &Rig, promise: &Promise) -> Result<Vec<f64>, RigError> {
    // In the middle of the shortest recording, so that it is whole.
    let Some(shortest) = ground.observed.iter().map(|o| o.condition.samples).min() else { return Ok(Vec::new()) };
    let rate = ground.observed[0].condition.sample_rate_hz;
    let time_s = 0.5 * shortest as f64 / rate;
    let with = rig.clone().with_effect(promise.start.with("time_s", time_s).effect);
    if with.check().is_err() {
        return Ok(Vec::new());
    }
    let runs: Vec<_> = ground.observed.iter().zip(&promise.angles).map(|(o, a)| (&with, o.condition, *a)).collect();
    let mut sum = vec![0.0; shortest];
    for ((o, without), mean) in ground.observed.iter().zip(&ground.expected).zip(means(&runs)?) {
        let Ok(mean) = mean else { return Ok(Vec::new()) };
        let change = |c: usize, k: usize| mean[c][k] - without.mean[c][k];
        let residual = |c: usize, k: usize, x: Complex<f64>| x - without.mean[c][k];
        let correlation = align::correlation(o, &without.variance, residual, change);
        // Moved ahead by as much, it is from the middle at that sample.
        let lag =
            |i: usize| ((time_s * rate).round() as i64 - i as i64).rem_euclid(o.condition.samples as i64) as usize;
        sum.iter_mut().enumerate().for_each(|(i, s)| *s += correlation[lag(i)]);
    }
    // At the ends of a recording there is a jump that is nothing but the ends.
    let inner = EDGE..shortest.saturating_sub(EDGE);
    let greatest = |sign: f64| inner.clone().max_by(|a, b| (sign * sum[*a]).total_cmp(&(sign * sum[*b])));
    Ok([1.0, -1.0].into_iter().filter_map(greatest).map(|i| i as f64 / rate).collect())
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
    if scaled > gain
        && (0.02..50.0).contains(&scale)
        && let Some(strength) = start.strength()
    {
        start = start.with(strength, start.nothing + (start.number(strength) - start.nothing) * scale);
        gain = scaled;
    }
    Some(Promise { hypothesis, start, angles: angles.to_vec(), gain })
}
