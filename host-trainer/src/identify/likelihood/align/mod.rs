//! Angles of cage and shaft at a recording's start, theory (58).
//!
//! A run of constant speed is a function of time alone: the run from (φ₀ + ω_c τ, ψ₀ + ω τ) is the run from (φ₀, ψ₀),
//! τ later. As cage and shaft turn at incommensurable speeds, one long run passes close to every pair of angles, and its
//! correlation with the recording, over all τ by one Fourier transform, is a search over all of them.

mod shift;
mod spin;

use crate::rig::effect::{EffectKind, ParameterKey};
use std::f64::consts::TAU;

use realfft::num_complex::Complex;

use crate::identify::likelihood::observed::{CHANNELS, Observed};
use crate::identify::likelihood::settings::AlignmentSettings;
use crate::identify::likelihood::tachometer::Reading;
use crate::identify::likelihood::whittle::{Noise, NoiseFreeRun, Prediction, means, neg_log_likelihood};
use crate::recording::Recording;
use crate::rig::simulate::{assemble, fewest_substeps, shortest_settling_s};
use crate::rig::{EffectEntry, OperatingCondition, Rig, RigError, Run, Start, simulate_many};
use crate::signal::transform::{forward_plan, inverse_plan};

use spin::{respin, spins, spun};

const SETTINGS: AlignmentSettings = AlignmentSettings::DEFAULT;

/// Angles of cage and shaft at t = 0, rad, for each recording: those of greatest correlation with the noise-free rig,
/// weighted by the variance of the random part, `noise[recording]`.
///
/// # Errors
/// A run that the simulation refuses.
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

/// Angles with the shaft's taken from the tachometers.
fn marked(rig: &Rig, observed: &[Observed], angles: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let at = |o, shaft| reading(rig, o).map_or(shaft, |reading| reading.next_to(shaft));
    observed.iter().zip(angles).map(|(o, [cage, shaft])| [*cage, at(o, *shaft)]).collect()
}

/// Angles with the cage at positions all over a pitch: with the shaft fixed, its effects distinguish the balls' positions.
fn around_a_pitch(rig: &Rig, angles: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
    let pitch = TAU / rig.bearing().map_or(1.0, |machine| machine.bearing.balls as f64);
    let turned = |k: usize| {
        let by = pitch * k as f64 / SETTINGS.cage_positions as f64;
        angles.iter().map(|[cage, shaft]| [cage + by, *shaft]).collect()
    };
    (0..SETTINGS.cage_positions).map(turned).collect()
}

/// Tachometer reading of a recording; `None` for a rig with a ball defect, whose spin goes with the shaft's angle.
pub fn reading(rig: &Rig, o: &Observed) -> Option<Reading> {
    o.tachometer.filter(|_| !rig.effects.iter().any(spins))
}

/// Angles of a rig with a wavy inner race, the shaft moved by whole waves to where it suits best: a move by one wave changes
/// only what else turns with the shaft.
///
/// # Errors
/// A run that the simulation refuses, or that diverges.
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

/// Angles of greatest likelihood for each recording, of several choices that can be simulated.
///
/// # Errors
/// The simulation's error for a recording whose choices it refuses all.
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

/// Negative log-likelihood and angles.
type Judged = Result<(f64, [f64; 2]), RigError>;

fn better(one: Judged, other: Judged) -> Judged {
    match (&one, &other) {
        (Ok((a, _)), Ok((b, _))) if b < a => other,
        (Err(_), Ok(_)) => other,
        _ => one,
    }
}

/// Rig without speed drift, and its rate, 1/s: recordings are resampled to an even speed instead.
fn at_even_speed(rig: &Rig) -> (Rig, f64) {
    let mut even = rig.clone();
    even.effects.retain(|e| e.kind != EffectKind::SpeedDrift);
    (even, assemble(rig).speed_rate_per_s)
}

fn long_runs<'r>(rig: &'r Rig, observed: &[Observed], noise: &[Noise]) -> Vec<Run<'r>> {
    let run = |(o, noise): (&Observed, &Noise)| {
        let more = SETTINGS.turns / o.condition.shaft_hz.max(1.0) * o.condition.sample_rate_hz;
        let most = SETTINGS.max_recordings * o.condition.samples as f64;
        let samples = o.condition.samples + more.min(most).ceil() as usize;
        let scatter = Some(noise.velocity_covariance);
        let substeps = Some(fewest_substeps(rig, scatter, &o.condition));
        let settle_s = shortest_settling_s(rig);
        let start = Start { substeps, settle_s, velocity_covariance: scatter, ..Start::noise_free(0.0, 0.0) };
        Run { rig, condition: OperatingCondition { samples, ..o.condition }, start }
    };
    observed.iter().zip(noise).map(run).collect()
}

/// Noise-free runs of a rig from given angles, for each recording.
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
    let near = |lag: usize| reading.is_none_or(|reading| reading.off(shaft(lag)).abs() < SETTINGS.near_tachometer_rad);
    let shaft = shaft(best_lag(o, variance, &channels, near));
    // The shaft's whole turns count: by them a ball's spin differs.
    [(cage_per_shaft * shaft).rem_euclid(TAU), shaft]
}

/// Wanted lag, in samples, of greatest correlation Σ Re(X* D)/S over all bins, the mean's included, theory (58); D's own
/// power is taken as the same at all lags.
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

/// Removes rounding from the ends of a real signal's spectrum, which the inverse transform wants real.
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
