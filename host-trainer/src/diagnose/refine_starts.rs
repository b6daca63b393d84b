//! Refinement of screened starts: parameters and times are scanned one by one.

use crate::rig::effect::{EffectKind, ParameterKey};
use std::f64::consts::TAU;

use realfft::num_complex::Complex;

use super::hypothesis::Start;
use super::residual::EDGE;
use super::start_score::{Angles, NullPrediction, StartScore, Strength, Trial, evaluate};
use crate::identify::likelihood::align;
use crate::identify::likelihood::tachometer::Reading;
use crate::identify::likelihood::whittle::means;
use crate::rig::{Rig, RigError};

/// Start with width, angle and depth of a defect scanned finely. A ball takes a few periods of the fastest mode to cross it, so
/// that widths half a period apart are similar and a search would stop at a local optimum; likewise for the angles, fixed by
/// the pulses and by the ball passes.
///
/// # Errors
/// Errors of the simulation before it runs.
pub fn scanned(null: &NullPrediction, rig: &Rig, score: &StartScore) -> Result<StartScore, RigError> {
    let Some(machine) = rig.bearing() else { return Ok(score.clone()) };
    let orders = machine.bearing.geometry().orders();
    let shaft_hz = null.observed.iter().map(|o| o.condition.shaft_hz).sum::<f64>() / null.observed.len() as f64;
    // Turns of the ball against the pit for each turn of the shaft.
    let passing = match score.start.effect.kind {
        EffectKind::OuterRaceDefect => orders.ftf,
        EffectKind::InnerRaceDefect => 1.0 - orders.ftf,
        _ => orders.bsf,
    };
    let resonator = &machine.resonator;
    let fastest_hz =
        (resonator.stiffness_n_per_m * (1.0 / resonator.mass_kg + 1.0 / machine.outer.mass_kg)).sqrt() / TAU;
    let step = TAU * passing * shaft_hz / (2.0 * fastest_hz.max(500.0));
    let mut best = score.clone();
    for scan in [Scan::Width, Scan::Place, Scan::Depth, Scan::Width, Scan::Place] {
        let other = |key: ParameterKey, value: f64| Trial {
            hypothesis: best.hypothesis,
            start: best.start.with(key, value),
            angles: Angles::Near(best.angles.clone()),
        };
        let now = |key: ParameterKey| best.start.number(key);
        let trials: Vec<Trial> = match scan {
            Scan::Place => turned(&best),
            Scan::Width => (1..=48).map(|k| other(ParameterKey::WidthRad, 0.6 * step * f64::from(k))).collect(),
            Scan::Depth => {
                (-8..=8).map(|k| other(ParameterKey::DepthM, now(ParameterKey::DepthM) * 1.12f64.powi(k))).collect()
            }
        };
        best = better(null, rig, &trials, best)?;
    }
    Ok(best)
}

/// The most promising of the trials, where it scores more than the best so far.
fn better(null: &NullPrediction, rig: &Rig, trials: &[Trial], best: StartScore) -> Result<StartScore, RigError> {
    let found = evaluate(null, rig, trials, Strength::Scaled)?.into_iter().next();
    Ok(found.filter(|f| f.log_likelihood_gain > best.log_likelihood_gain).unwrap_or(best))
}

/// What of a pit is scanned.
#[derive(Clone, Copy)]
enum Scan {
    Width,
    Place,
    Depth,
}

/// Start with frequency and damping of a mode scanned finely, for either sign: from half the frequency, or from the wrong sign,
/// a search ends at the wrong mode.
///
/// # Errors
/// Errors of the simulation before it runs.
pub fn tuned(null: &NullPrediction, rig: &Rig, score: &StartScore) -> Result<StartScore, RigError> {
    let mut best = score.clone();
    for (key, factor, reach, gains) in [WIDELY, DAMPING, FINELY, DAMPING] {
        let of = |(k, gain): (i32, &f64)| {
            let start = best.start.with(key, best.start.number(key) * factor.powi(k));
            let start = start.with(ParameterKey::Gain, gain * best.start.number(ParameterKey::Gain));
            Trial { hypothesis: best.hypothesis, start, angles: Angles::Given(best.angles.clone()) }
        };
        let trials: Vec<Trial> =
            (-reach..=reach).flat_map(|k| gains.iter().map(move |gain| (k, gain))).map(of).collect();
        best = better(null, rig, &trials, best)?;
    }
    Ok(best)
}

/// What of a mode is scanned, by which factor from try to try, how many of them up and down, and with which shares of the gain:
/// that of the random part is in no proportion to it.
type Tuning = (ParameterKey, f64, i32, &'static [f64]);
const WIDELY: Tuning = (ParameterKey::FrequencyHz, 1.1, 6, &[0.3, 1.0, 2.0, 4.0, 8.0, -0.3, -1.0, -2.0, -4.0, -8.0]);
const FINELY: Tuning = (ParameterKey::FrequencyHz, 1.03, 3, &[0.7, 0.85, 1.0, 1.2, 1.4]);
const DAMPING: Tuning = (ParameterKey::DampingRatio, 1.35, 5, &[1.0]);

/// Start with its time at the maximum of a matched filter and, if that scores `least`, scanned ever finer: a step or an impact
/// must be met to a part of the fastest mode's period.
///
/// # Errors
/// Errors of the simulation before it runs; a run of the best time that diverges.
pub fn timed(null: &NullPrediction, rig: &Rig, score: &StartScore, least: f64) -> Result<StartScore, RigError> {
    let sample_s = 1.0 / null.observed.first().map_or(1.0, |o| o.condition.sample_rate_hz);
    let mut best = score.clone();
    for step in [0.0, 1.0, 0.2] {
        let of = |time_s: f64| Trial {
            hypothesis: best.hypothesis,
            start: best.start.with(ParameterKey::TimeS, time_s),
            angles: Angles::Given(best.angles.clone()),
        };
        let now = best.start.number(ParameterKey::TimeS);
        let times: Vec<f64> = if step == 0.0 {
            matched(null, rig, &best)?
        } else if best.log_likelihood_gain > least {
            (-10..=10).map(|k| now + f64::from(k) * step * sample_s).collect()
        } else {
            break;
        };
        // The strength is no longer the one that suited another time: it is scaled from there, and from a tenth, either way.
        let other = |t: Trial| match best.start.strength() {
            Some(key) => {
                let by = |share: f64| Trial { start: t.start.with(key, share * t.start.number(key)), ..t.clone() };
                vec![by(-1.0), by(0.1), by(-0.1), t]
            }
            None => vec![t],
        };
        let trials: Vec<Trial> = times.into_iter().map(of).flat_map(other).collect();
        best = better(null, rig, &trials, best)?;
    }
    let Some(strength) = best.start.strength() else { return Ok(best) };
    let with = rig.clone().with_effect(best.start.effect.clone());
    let apart = align::angles_apart(rig, &with, null.observed, &best.angles)?;
    // Angles that were found with it missing are off by it, where nothing but the balls' passing tells them.
    let mut angles = vec![apart.clone()];
    if !rig.effects.is_empty() {
        angles.push(best.angles.clone());
    }
    best.angles = apart;
    if best.log_likelihood_gain > least {
        // What is strong is in no proportion to its strength.
        for (key, step, factor) in [(strength, 0.0, 1.1f64), (ParameterKey::TimeS, 0.2 * sample_s, 1.0)] {
            let of = |k: i32| best.start.with(key, best.start.number(key) * factor.powi(k) + f64::from(k) * step);
            let trials = given(best.hypothesis, (-10..=10).map(of), &angles);
            best = evaluate(null, rig, &trials, Strength::Given)?.into_iter().next().unwrap_or(best);
            angles = vec![best.angles.clone()];
        }
    }
    Ok(best)
}

/// Every start with each of these angles.
fn given(hypothesis: usize, starts: impl Iterator<Item = Start>, angles: &[Vec<[f64; 2]>]) -> Vec<Trial> {
    let with = |start: Start| angles.iter().map(move |angles| (start.clone(), Angles::Given(angles.clone())));
    starts.flat_map(with).map(|(start, angles)| Trial { hypothesis, start, angles }).collect()
}

/// Times at which the residual of all recordings together is most like what the effect changes, of either sign: a matched
/// filter.
fn matched(null: &NullPrediction, rig: &Rig, score: &StartScore) -> Result<Vec<f64>, RigError> {
    // In the middle of the shortest recording, so that it is whole.
    let Some(shortest) = null.observed.iter().map(|o| o.condition.samples).min() else { return Ok(Vec::new()) };
    let rate = null.observed[0].condition.sample_rate_hz;
    let time_s = 0.5 * shortest as f64 / rate;
    let with = rig.clone().with_effect(score.start.with(ParameterKey::TimeS, time_s).effect);
    if with.check().is_err() {
        return Ok(Vec::new());
    }
    let runs = align::noise_free_runs(&with, null.observed, &null.noise(), &score.angles);
    let mut sum = vec![0.0; shortest];
    for ((o, without), mean) in null.observed.iter().zip(&null.expected).zip(means(&runs)?) {
        let Ok(mean) = mean else { return Ok(Vec::new()) };
        let change = |c: usize, k: usize| mean[c][k] - without.mean[c][k];
        let residual = |c: usize, k: usize, x: Complex<f64>| x - without.mean[c][k];
        let correlation = align::correlation(o, &without.noise.variance, residual, change);
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

/// Moves `scores` of effects fixed to the shaft, found at a free shaft angle, to the angle of the tachometers that fits best.
///
/// # Errors
/// Errors of the simulation before it runs.
pub fn by_tachometers(null: &NullPrediction, rig: &Rig, scores: &mut [StartScore]) -> Result<(), RigError> {
    let on_shaft = scores.iter().enumerate().filter(|(_, p)| p.start.effect.is_on_shaft());
    let trials: Vec<Trial> = on_shaft.flat_map(|(number, score)| at_tachometers(null, rig, number, score)).collect();
    let found = evaluate(null, rig, &trials, Strength::Scaled)?;
    for (number, score) in scores.iter_mut().enumerate() {
        if let Some(best) = found.iter().find(|f| f.hypothesis == number) {
            *score = StartScore { hypothesis: score.hypothesis, ..best.clone() };
        }
    }
    Ok(())
}

/// What is tried of one for that, its number as the hypothesis.
fn at_tachometers(null: &NullPrediction, rig: &Rig, number: usize, score: &StartScore) -> Vec<Trial> {
    let with = rig.clone().with_effect(score.start.effect.clone());
    let readings: Vec<_> = null.observed.iter().map(|o| align::reading(&with, o)).collect();
    let each = || readings.iter().zip(&score.angles);
    // The balls meet it at the same times where the cage turns with it.
    let met = |by: f64, reading: Option<Reading>, [cage, shaft]: [f64; 2]| match reading {
        Some(reading) => [cage + by - reading.off(shaft), reading.next_to(shaft)],
        None => [cage, shaft - by],
    };
    let to = |by: f64| Trial {
        hypothesis: number,
        start: score.start.turned_on_shaft(by),
        angles: Angles::Given(each().map(|(reading, angles)| met(by, *reading, *angles)).collect()),
    };
    let asked = each().filter_map(|(reading, [_, shaft])| Some(reading.as_ref()?.off(*shaft)));
    asked.map(to).collect()
}

/// The same pulses with a race's pit elsewhere: a ball meets it at the same times where the cage turns with a pit of the
/// outer race, or the shaft against one of the inner.
fn turned(score: &StartScore) -> Vec<Trial> {
    let of = |by: f64, turn: &dyn Fn([f64; 2]) -> [f64; 2]| Trial {
        hypothesis: score.hypothesis,
        start: score.start.with(ParameterKey::AngleRad, score.start.number(ParameterKey::AngleRad) + by),
        angles: Angles::Given(score.angles.iter().copied().map(turn).collect()),
    };
    let with_cage = |by: f64| of(by, &|[cage, shaft]| [cage + by, shaft]);
    let against_shaft = |by: f64| of(by, &|[cage, shaft]| [cage, shaft - by]);
    match score.start.effect.kind {
        EffectKind::OuterRaceDefect => (-30..=30).map(|k| with_cage(0.02 * f64::from(k))).collect(),
        EffectKind::InnerRaceDefect => (0..24).map(|k| against_shaft(TAU / 24.0 * f64::from(k))).collect(),
        // A ball's spin goes with the angles.
        _ => Vec::new(),
    }
}
