//! The angles at which a recording began.
//!
//! A run of constant speed is a function of time alone: what starts at (φ₀ + ω_c τ, ψ₀ + ω τ) is what started at
//! (φ₀, ψ₀), τ later. As cage and shaft turn at incommensurable speeds, one long run passes close to every pair of
//! angles, and the correlation of the recording with it, over all τ by one Fourier transform, is a search over all of
//! them.

mod shift;
mod spin;

use crate::rig::effect::{EffectKind, ParameterKey};
use std::f64::consts::TAU;

use rayon::prelude::*;
use realfft::num_complex::Complex;

use crate::identify::likelihood::likelihood::{Noise, NoiseFreeRun, Prediction, means, neg_log_likelihood, noises_in};
use crate::identify::likelihood::observed::{CHANNELS, Coefficients, Observed};
use crate::identify::likelihood::tachometer::Reading;
use crate::recording::Recording;
use crate::rig::simulate::{assemble, fewest_substeps, shortest_settling_s, simulate_all};
use crate::rig::{EffectEntry, OperatingCondition, Rig, RigError, Run, Start, simulate_many};
use crate::signal::transform::{forward_plan, inverse_plan};

pub use shift::{correlation, lag, moved_angles, moved_mean};
use spin::{respin, spins, spun};

/// How far from where a tachometer has the shaft a search may find it, rad: in each of some twenty turns the balls pass by
/// a tenth of a pitch meanwhile, so that together they are everywhere.
const NEAR_THE_MARK_RAD: f64 = 0.15;
/// Places of the cage that are tried, evenly over a pitch of its balls.
const PLACES: usize = 48;
/// Time that a run is searched over, in turns of the shaft: some hundred positions of the balls, each at another angle
/// of the shaft.
const TURNS: f64 = 24.0;

/// Angles of cage and shaft at t = 0, rad, for each recording: those with which the silent rig is most like it, weighted
/// by the variance of its random part, `noise[recording][channel]`.
///
/// # Errors
/// What the simulation refuses.
pub fn angles(rig: &Rig, observed: &[Observed], noise: &[Noise]) -> Result<Vec<[f64; 2]>, RigError> {
    let (even, rate_per_s) = at_even_speed(rig);
    let cage_per_shaft = cage_per_shaft(rig);
    let long = simulate_many(&long_runs(&even, observed, noise))?;
    let each = observed.iter().zip(noise).zip(&long);
    let of = |((o, v), run): ((&Observed, &Noise), &Recording)| {
        of_long_run(&o.at_even_speed(rate_per_s), v, run, cage_per_shaft, reading(rig, o))
    };
    let long: Vec<_> = each.map(of).collect();
    let mut found = marked(rig, observed, &long);
    if rig.effects.iter().any(EffectEntry::is_on_shaft) && observed.iter().any(|o| reading(rig, o).is_some()) {
        found = best_of(rig, observed, noise, &around_a_pitch(rig, &found))?;
    }
    if rig.effects.iter().any(spins) {
        let mut plain = rig.clone();
        plain.effects.retain(|e| !spins(e));
        let known = angles(&plain, observed, noise)?;
        respin(rig, &mut found, &known);
        let apart = spun(rig, &plain, observed, noise, &known)?;
        found = best_of(rig, observed, noise, &[found, apart])?;
    }
    latched(rig, observed, noise, found)
}

/// Angles with the shaft where tachometers have it.
fn marked(rig: &Rig, observed: &[Observed], angles: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let at = |o, shaft| reading(rig, o).map_or(shaft, |reading| reading.next_to(shaft));
    observed.iter().zip(angles).map(|(o, [cage, shaft])| [*cage, at(o, *shaft)]).collect()
}

/// Angles with the cage all over a pitch: what is on a shaft that stands still as they move tells balls and races apart.
fn around_a_pitch(rig: &Rig, angles: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
    let pitch = TAU / rig.bearing().map_or(1.0, |machine| machine.bearing.balls as f64);
    let turned = |k: usize| {
        let by = pitch * k as f64 / PLACES as f64;
        angles.iter().map(|[cage, shaft]| [cage + by, *shaft]).collect()
    };
    (0..PLACES).map(turned).collect()
}

/// What the tachometer of a recording says of the shaft's angle of a rig; nothing where a ball's spin goes with that angle.
pub fn reading(rig: &Rig, o: &Observed) -> Option<Reading> {
    o.tachometer.filter(|_| !rig.effects.iter().any(spins))
}

/// Angles of a rig with a wavy inner race, the shaft where it suits best by whole waves: what moves by one looks alike but
/// for what else turns with the shaft.
///
/// # Errors
/// What the simulation refuses, a run that diverges among it.
pub fn latched(
    rig: &Rig,
    observed: &[Observed],
    noise: &[Noise],
    angles: Vec<[f64; 2]>,
) -> Result<Vec<[f64; 2]>, RigError> {
    let wavy = rig.effects.iter().find(|e| e.kind == EffectKind::InnerRaceWaviness);
    let Some(lobes) = wavy.and_then(|e| e.number(ParameterKey::Lobes)) else { return Ok(angles) };
    let turned = |k: usize| angles.iter().map(|[cage, shaft]| [*cage, shaft + TAU * k as f64 / lobes]).collect();
    best_of(rig, observed, noise, &(0..lobes as usize).map(turned).collect::<Vec<_>>())
}

/// Of several choices of angles, the one that suits each recording best, of those that can be simulated.
///
/// # Errors
/// What the simulation refuses, of a recording for which it refuses all.
pub fn best_of(
    rig: &Rig,
    observed: &[Observed],
    noise: &[Noise],
    choices: &[Vec<[f64; 2]>],
) -> Result<Vec<[f64; 2]>, RigError> {
    let runs: Vec<_> = choices.iter().flat_map(|angles| noise_free_runs(rig, observed, noise, angles)).collect();
    let mut best: Vec<Option<Judged>> = observed.iter().map(|_| None).collect();
    for (n, (mean, NoiseFreeRun { angles, .. })) in means(&runs)?.into_iter().zip(&runs).enumerate() {
        let n = n % observed.len();
        let judged = mean.map(|mean| {
            let expected = Prediction { mean, noise: noise[n].clone() };
            let tachometer = reading(rig, &observed[n]).map_or(0.0, |reading| reading.neg_log_likelihood(angles[1]));
            (neg_log_likelihood(&observed[n], &expected, 1.0) + tachometer, *angles)
        });
        best[n] = Some(match best[n].take() {
            Some(other) => better(other, judged),
            None => judged,
        });
    }
    best.into_iter().flatten().map(|found| Ok(found?.1)).collect()
}

/// Angles with their neg_log_likelihood.
type Judged = Result<(f64, [f64; 2]), RigError>;

fn better(one: Judged, other: Judged) -> Judged {
    match (&one, &other) {
        (Ok((a, _)), Ok((b, _))) if b < a => other,
        (Err(_), Ok(_)) => other,
        _ => one,
    }
}

/// Angles of recordings that have something of their own time in them, a step or an impact: those of the rig without it,
/// once the change that `with` gives at `angles` has been taken out.
///
/// # Errors
/// What the simulation refuses, a run that diverges among it.
pub fn angles_apart(
    without: &Rig,
    with: &Rig,
    observed: &[Observed],
    angles: &[[f64; 2]],
) -> Result<Vec<[f64; 2]>, RigError> {
    let noise = noises_in(&[without], observed)?;
    let of = |rig| -> Result<Vec<[Coefficients; 2]>, RigError> {
        means(&noise_free_runs(rig, observed, &noise, angles))?.into_iter().collect()
    };
    let (old, new) = (of(without)?, of(with)?);
    let mut rest = observed.to_vec();
    for (o, (old, new)) in rest.iter_mut().zip(old.iter().zip(&new)) {
        for (spectrum, (old, new)) in o.spectra.iter_mut().zip(old.iter().zip(new)) {
            let Some(spectrum) = spectrum else { continue };
            spectrum.iter_mut().zip(old.iter().zip(new)).for_each(|(x, (old, new))| *x -= new - old);
        }
    }
    self::angles(without, &rest, &noise)
}

/// The same for many rigs side by side; nothing for a rig whose simulation diverges. `known` are the angles of the rig
/// that they all are variations of. What the last effect of a rig has on the shaft is at an angle that is not known yet, so
/// that the shaft is sought whatever a tachometer says.
///
/// # Errors
/// What the simulation refuses before it runs.
pub fn angles_of_many(
    rigs: &[&Rig],
    observed: &[Observed],
    noise: &[Noise],
    known: &[[f64; 2]],
) -> Result<Vec<Option<Vec<[f64; 2]>>>, RigError> {
    let even: Vec<(Rig, f64)> = rigs.iter().map(|rig| at_even_speed(rig)).collect();
    let runs: Vec<Run> = even.iter().flat_map(|(rig, _)| long_runs(rig, observed, noise)).collect();
    let long = simulate_all(&runs)?;
    let of = |((rig, rate_per_s), runs): (&(Rig, f64), &[Result<Recording, RigError>])| {
        let anywhere = rig.effects.last().is_some_and(EffectEntry::is_on_shaft);
        let of = |((o, v), run): ((&Observed, &Noise), &Result<Recording, RigError>)| {
            let reading = reading(rig, o).filter(|_| !anywhere);
            Some(of_long_run(&o.at_even_speed(*rate_per_s), v, run.as_ref().ok()?, cage_per_shaft(rig), reading))
        };
        let long: Vec<_> = observed.iter().zip(noise).zip(runs).map(of).collect::<Option<_>>()?;
        let mut found = if anywhere { long } else { marked(rig, observed, &long) };
        respin(rig, &mut found, known);
        Some(found)
    };
    Ok(even.par_iter().zip(long.par_chunks(observed.len().max(1))).map(of).collect())
}

/// The rig without what changes its speed: recordings are brought to an even one instead.
fn at_even_speed(rig: &Rig) -> (Rig, f64) {
    let mut even = rig.clone();
    even.effects.retain(|e| e.kind != EffectKind::SpeedDrift);
    (even, assemble(rig).speed_rate_per_s)
}

fn long_runs<'r>(rig: &'r Rig, observed: &[Observed], noise: &[Noise]) -> Vec<Run<'r>> {
    let run = |(o, noise): (&Observed, &Noise)| {
        let more = TURNS / o.condition.shaft_hz.max(1.0) * o.condition.sample_rate_hz;
        let samples = o.condition.samples + more.min(4.0 * o.condition.samples as f64).ceil() as usize;
        let scatter = Some(noise.velocity_covariance);
        let substeps = Some(fewest_substeps(rig, scatter, &o.condition));
        let settle_s = shortest_settling_s(rig);
        let start = Start { substeps, settle_s, velocity_covariance: scatter, ..Start::noise_free(0.0, 0.0) };
        Run { rig, condition: OperatingCondition { samples, ..o.condition }, start }
    };
    observed.iter().zip(noise).map(run).collect()
}

/// Runs of a rig from these angles, for each recording.
pub fn noise_free_runs<'r>(
    rig: &'r Rig,
    observed: &[Observed],
    noise: &[Noise],
    angles: &[[f64; 2]],
) -> Vec<NoiseFreeRun<'r>> {
    let run = |((o, noise), angles): ((&Observed, &Noise), &[f64; 2])| NoiseFreeRun {
        rig,
        condition: o.condition,
        angles: *angles,
        scatter: noise.velocity_covariance,
    };
    observed.iter().zip(noise).zip(angles).map(run).collect()
}

fn cage_per_shaft(rig: &Rig) -> f64 {
    rig.bearing().map_or(0.0, |machine| machine.bearing.geometry().orders().ftf) * assemble(rig).cage_factor
}

fn of_long_run(
    o: &Observed,
    Noise { variance, .. }: &Noise,
    run: &Recording,
    cage_per_shaft: f64,
    reading: Option<Reading>,
) -> [f64; 2] {
    let channels = CHANNELS.map(|c| run.channel(c).map_or(&[][..], |c| &c.samples));
    let shaft = |lag: usize| TAU * o.condition.shaft_hz * lag as f64 / o.condition.sample_rate_hz;
    let near = |lag: usize| reading.is_none_or(|reading| reading.off(shaft(lag)).abs() < NEAR_THE_MARK_RAD);
    let shaft = shaft(best_lag(o, variance, &channels, near));
    // The shaft's whole turns count: by them a ball's spin differs.
    [(cage_per_shaft * shaft).rem_euclid(TAU), shaft]
}

/// The lag, of those that are wanted, at which the neg_log_likelihood Σ|X − D|²/S is least.
fn best_lag(
    observed: &Observed,
    variance: &[Vec<f64>; 2],
    long: &[&[f64]; 2],
    wanted: impl Fn(usize) -> bool,
) -> usize {
    let samples = observed.condition.samples;
    let total = long[0].len();
    let lags = total - samples + 1;
    let (small, forward, inverse) = (inverse_plan(samples), forward_plan(total), inverse_plan(total));
    let mut score = vec![0.0; lags];
    for channel in 0..2 {
        let Some(spectrum) = &observed.spectra[channel] else { continue };
        // X/S back in time, so that its product with D, lag by lag, is a correlation.
        let mut weighted: Vec<Complex<f64>> = spectrum.iter().zip(&variance[channel]).map(|(x, s)| x / *s).collect();
        real_ends(&mut weighted, samples);
        let mut signal = small.make_output_vec();
        small.process(&mut weighted, &mut signal).unwrap_or_default();
        signal.iter_mut().for_each(|v| *v /= (samples as f64).sqrt());
        signal.resize(total, 0.0);
        let (mut a, mut b) = (forward.make_output_vec(), forward.make_output_vec());
        forward.process(&mut signal, &mut a).unwrap_or_default();
        forward.process(&mut long[channel].to_vec(), &mut b).unwrap_or_default();
        let mut product: Vec<_> = a.iter().zip(&b).map(|(a, b)| a.conj() * b / total as f64).collect();
        real_ends(&mut product, total);
        let mut correlation = inverse.make_output_vec();
        inverse.process(&mut product, &mut correlation).unwrap_or_default();
        score.iter_mut().zip(&correlation).for_each(|(s, c)| *s += c);
    }
    let wanted = score.iter().enumerate().filter(|(lag, _)| wanted(*lag));
    wanted.max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(lag, _)| lag)
}

/// The ends of a real signal's spectrum are real; rounding says otherwise, and the transform refuses.
fn real_ends(spectrum: &mut [Complex<f64>], samples: usize) {
    if let Some(first) = spectrum.first_mut() {
        first.im = 0.0;
    }
    if samples.is_multiple_of(2)
        && let Some(last) = spectrum.last_mut()
    {
        last.im = 0.0;
    }
}
