//! The angles at which a recording began.
//!
//! A run of constant speed is a function of time alone: what starts at (φ₀ + ω_c τ, ψ₀ + ω τ) is what started at
//! (φ₀, ψ₀), τ later. As cage and shaft turn at incommensurable speeds, one long run passes close to every pair of
//! angles, and the correlation of the recording with it, over all τ by one Fourier transform, is a search over all of
//! them.

use std::f64::consts::TAU;

use rayon::prelude::*;
use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

use super::observed::{CHANNELS, Observed};
use crate::recording::Recording;
use crate::rig::simulate::{fewest_substeps, shortest_settling_s, simulate_all};
use crate::rig::{OperatingCondition, Rig, RigError, Run, Start, simulate_many};

/// Time that a run is searched over, in turns of the shaft: some hundred positions of the balls, each at another angle
/// of the shaft.
const TURNS: f64 = 24.0;

/// Angles of cage and shaft at t = 0, rad, for each recording: those with which the silent rig is most like it, weighted
/// by the variance of its random part, `variances[recording][channel]`.
///
/// # Errors
/// What the simulation refuses.
pub fn angles(rig: &Rig, observed: &[Observed], variances: &[[Vec<f64>; 2]]) -> Result<Vec<[f64; 2]>, RigError> {
    let (runs, cage_per_shaft) = (long_runs(rig, observed), cage_per_shaft(rig));
    let long = simulate_many(&runs)?;
    Ok(observed.iter().zip(variances).zip(&long).map(|((o, v), run)| best(o, v, run, cage_per_shaft)).collect())
}

/// The same for many rigs side by side; nothing for a rig whose simulation diverges.
///
/// # Errors
/// What the simulation refuses before it runs.
pub fn angles_of_many(
    rigs: &[&Rig],
    observed: &[Observed],
    variances: &[[Vec<f64>; 2]],
) -> Result<Vec<Option<Vec<[f64; 2]>>>, RigError> {
    let runs: Vec<Run> = rigs.iter().flat_map(|rig| long_runs(rig, observed)).collect();
    let long = simulate_all(&runs)?;
    let of = |(rig, runs): (&&Rig, &[Result<Recording, RigError>])| {
        let found = observed.iter().zip(variances).zip(runs);
        found.map(|((o, v), run)| Some(best(o, v, run.as_ref().ok()?, cage_per_shaft(rig)))).collect()
    };
    Ok(rigs.par_iter().zip(long.par_chunks(observed.len().max(1))).map(of).collect())
}

fn long_runs<'r>(rig: &'r Rig, observed: &[Observed]) -> Vec<Run<'r>> {
    let run = |o: &Observed| {
        let more = TURNS / o.condition.shaft_hz.max(1.0) * o.condition.sample_rate_hz;
        let samples = o.condition.samples + more.min(4.0 * o.condition.samples as f64).ceil() as usize;
        let substeps = Some(fewest_substeps(rig, o.condition.sample_rate_hz));
        let settle_s = shortest_settling_s(rig);
        let start = Start { substeps, settle_s, ..Start::silent(0.0, 0.0) };
        Run { rig, condition: OperatingCondition { samples, ..o.condition }, start }
    };
    observed.iter().map(run).collect()
}

fn cage_per_shaft(rig: &Rig) -> f64 {
    rig.bearing().map_or(0.0, |machine| machine.bearing.geometry().orders().ftf)
}

fn best(o: &Observed, variance: &[Vec<f64>; 2], run: &Recording, cage_per_shaft: f64) -> [f64; 2] {
    let lag = best_lag(o, variance, &CHANNELS.map(|c| run.channel(c).map_or(&[][..], |c| &c.samples)));
    let shaft = TAU * o.condition.shaft_hz * lag as f64 / o.condition.sample_rate_hz;
    [(cage_per_shaft * shaft).rem_euclid(TAU), shaft.rem_euclid(TAU)]
}

/// The lag at which the misfit Σ|X − D|²/S is least.
fn best_lag(observed: &Observed, variance: &[Vec<f64>; 2], long: &[&[f64]; 2]) -> usize {
    let samples = observed.condition.samples;
    let total = long[0].len();
    let lags = total - samples + 1;
    let mut planner = RealFftPlanner::<f64>::new();
    let (small, forward, inverse) =
        (planner.plan_fft_inverse(samples), planner.plan_fft_forward(total), planner.plan_fft_inverse(total));
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
    score.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(lag, _)| lag)
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
