//! Likelihood of recordings under a rig, theory (54).
//!
//! A recording is the rig's response to its rotation, which angles and parameters fix to the last sample, and a random part:
//! process force through the structure, and sensor noise. The likelihood (P. Whittle, "Estimation and
//! information in stationary time series", Arkiv för Matematik 2 (1953) 423–434) takes both at once: X are the recording's
//! Fourier coefficients, D those of the noise-free rig, S is the variance of the random part,
//!
//! −ln L = Σ_k ln S_k + |X_k − D_k|²/S_k
//!
//! so that phases count where they are fixed and only powers where they are random. Gradient and expected information
//! (D. R. Brillinger, "Time Series", 1981, section 5) are theory (55) and (56).

use rayon::prelude::*;
use realfft::num_complex::Complex;

use super::observed::{CHANNELS, Coefficients, Observed, coefficients, padded};
use crate::rig::random_part::{Asked, Driven, RandomPart, random_parts};
use crate::rig::simulate::{fewest_substeps, shortest_settling_s, simulate_all};
use crate::rig::state::VelocityCovariance;
use crate::rig::{OperatingCondition, Rig, RigError, Run, Start};
use crate::signal::transform::inverse_plan;

/// Prediction of one recording by a rig.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// Mean D of `ax` and `ay`.
    pub mean: [Coefficients; 2],
    /// Random part.
    pub noise: Noise,
}

/// Random part of a recording under a rig.
#[derive(Clone, Debug)]
pub struct Noise {
    /// Variance S of `ax` and `ay`, one per bin, (m/s²)².
    pub variance: [Vec<f64>; 2],
    /// Share of the process force in it.
    pub process_share: [Vec<f64>; 2],
    /// Velocity covariance under the process force.
    pub velocity_covariance: VelocityCovariance,
}

/// A noise-free run: the mean motion under the noise that it leaves out.
#[derive(Clone, Copy, Debug)]
pub struct NoiseFreeRun<'a> {
    /// The rig.
    pub rig: &'a Rig,
    /// Operating condition.
    pub condition: OperatingCondition,
    /// Angles of cage and shaft at t = 0, rad.
    pub angles: [f64; 2],
    /// Velocity covariance of the left-out noise.
    pub scatter: VelocityCovariance,
}

/// Random part of each recording by each of the rigs, recording after recording.
///
/// # Errors
/// As [`simulate`](crate::rig::simulate()).
pub fn noises_in(rigs: &[&Rig], observed: &[Observed]) -> Result<Vec<Noise>, RigError> {
    let asked =
        observed.iter().flat_map(|o| rigs.iter().map(move |rig| Asked { rig, condition: o.condition, known: None }));
    noises(&asked.collect::<Vec<_>>()).into_iter().collect()
}

/// Random parts of recordings, theory (51): sensor noise, and process force and random forces of effects through the structure.
///
/// # Errors
/// For each its own, as [`random_parts`].
pub fn noises(asked: &[Asked]) -> Vec<Result<Noise, RigError>> {
    let parts = random_parts(asked);
    asked.par_iter().zip(parts).map(|(of, part)| Ok(seen(of.rig, &of.condition, part?))).collect()
}

/// Random part in the recording's channels, theory (51).
fn seen(rig: &Rig, condition: &OperatingCondition, part: RandomPart) -> Noise {
    let noise = rig.bearing().map_or(0.0, |machine| machine.sensor.noise_std_m_per_s2.powi(2));
    let RandomPart { process, effects, noise_gain, scatter } = part;
    let power_of = |driven: &Driven, channel: usize| -> Vec<f64> {
        let of_channel: Vec<&[f64]> = driven.responses.iter().map(|r| r[channel].as_slice()).collect();
        mean_power(&of_channel, condition.samples).iter().map(|power| driven.variance_n2 * power).collect()
    };
    let process = [0, 1].map(|channel| power_of(&process, channel));
    let mut variance = [0, 1].map(|channel| -> Vec<f64> {
        let noise = noise * noise_gain[channel].powi(2);
        let mut sum: Vec<f64> = process[channel].iter().map(|process| noise + process).collect();
        for effect in &effects {
            sum.iter_mut().zip(power_of(effect, channel)).for_each(|(sum, power)| *sum += power);
        }
        sum.iter().map(|sum| sum.max(f64::MIN_POSITIVE)).collect()
    });
    let process_share =
        [0, 1].map(|channel| process[channel].iter().zip(&variance[channel]).map(|(p, v)| p / v).collect());
    for path in &rig.paths {
        for (_, variance) in CHANNELS.iter().zip(&mut variance).filter(|(channel, _)| **channel == path.channel) {
            variance.iter_mut().zip(path.power(condition.samples)).for_each(|(s, h)| *s *= h);
        }
    }
    Noise { variance, process_share, velocity_covariance: scatter }
}

/// Mean squared magnitude of the Fourier coefficients of short signals, each padded with zeros to `length`. For many, by
/// their mean autocorrelation: long transforms of each would be most of the work.
pub(super) fn mean_power(signals: &[&[f64]], length: usize) -> Vec<f64> {
    let longest = signals.iter().map(|s| s.len()).max().unwrap_or_default();
    let short = (2 * longest).next_power_of_two();
    if signals.len() == 1 || short > length {
        return mean(signals.iter().map(|s| squares(s, length)));
    }
    let mut power: Vec<Complex<f64>> =
        mean(signals.iter().map(|s| squares(s, short))).into_iter().map(Complex::from).collect();
    let inverse = inverse_plan(short);
    let mut lags = inverse.make_output_vec();
    // Both buffers have the transform's length.
    inverse.process(&mut power, &mut lags).unwrap_or_default();
    let mut apart = vec![0.0; length];
    apart[..short / 2].copy_from_slice(&lags[..short / 2]);
    (1..short / 2).for_each(|lag| apart[length - lag] = lags[short - lag]);
    padded(&apart, length, 1.0 / short as f64).iter().map(|power| power.re).collect()
}

fn squares(signal: &[f64], length: usize) -> Vec<f64> {
    padded(signal, length, 1.0).iter().map(|h| h.norm_sqr()).collect()
}

fn mean(many: impl ExactSizeIterator<Item = Vec<f64>>) -> Vec<f64> {
    let share = 1.0 / many.len().max(1) as f64;
    many.reduce(|mut sum, one| {
        sum.iter_mut().zip(one).for_each(|(sum, one)| *sum += one);
        sum
    })
    .unwrap_or_default()
    .into_iter()
    .map(|sum| share * sum)
    .collect()
}

/// Means D of many noise-free runs.
///
/// # Errors
/// A run that the simulation refuses; one that diverges is an error of its own in the list.
pub fn means(runs: &[NoiseFreeRun]) -> Result<Vec<Result<[Coefficients; 2], RigError>>, RigError> {
    let runs: Vec<Run> = runs
        .iter()
        .map(|&NoiseFreeRun { rig, condition, angles: [cage, shaft], scatter }| {
            let scatter = Some(scatter);
            let substeps = Some(fewest_substeps(rig, scatter, &condition));
            let settle_s = shortest_settling_s(rig);
            Run {
                rig,
                condition,
                start: Start { substeps, settle_s, velocity_covariance: scatter, ..Start::noise_free(cage, shaft) },
            }
        })
        .collect();
    let transform = |recording: crate::recording::Recording| {
        CHANNELS.map(|name| recording.channel(name).map_or_else(Vec::new, |c| coefficients(&c.samples)))
    };
    Ok(simulate_all(&runs)?.into_par_iter().map(|run| run.map(transform)).collect())
}

/// Bins of the likelihood, up to a share of half the sample rate: all but the first and the last. The first is real, the
/// last too for an even number of samples.
pub fn judged_bins(spectrum: &[Complex<f64>], band: f64) -> std::ops::Range<usize> {
    let last = spectrum.len().saturating_sub(1);
    1..((band * last as f64) as usize).clamp(1, last.max(1))
}

/// Negative log-likelihood −ln L of a recording, up to a share of half the sample rate, theory (54) without tachometer.
pub fn neg_log_likelihood(observed: &Observed, expected: &Prediction, band: f64) -> f64 {
    let channel = |c: usize| {
        let Some(x) = &observed.spectra[c] else { return 0.0 };
        let (d, s) = (&expected.mean[c], &expected.noise.variance[c]);
        judged_bins(x, band).map(|k| s[k].ln() + (x[k] - d[k]).norm_sqr() / s[k]).sum::<f64>()
    };
    channel(0) + channel(1)
}
