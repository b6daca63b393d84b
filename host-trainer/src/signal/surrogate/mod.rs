//! Surrogates: recordings that have a recording's spectrum, and no dynamics but those of a linear filter driven by noise;
//! theory (24).
//!
//! A surrogate is made of the innovations of the recording's autoregression, and coloured by it again. Without the
//! whitening the jump from the recording's end back to its start leaks over the whole spectrum, makes every surrogate a
//! little less predictable than its recording, and lets a linear recording beat its null (measured on a resonance driven
//! by noise: next-sample R² 0.8398 against 0.8384 ± 0.0001). Spectral lines leak likewise, and no autoregression whitens
//! them: they are taken out first and put back with random phases.

pub(crate) mod autoregression;
mod lines;

use std::f64::consts::TAU;

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};

use super::settings::SurrogateSettings;
use crate::signal::transform::{forward_plan, inverse_plan};
use autoregression::Autoregression;
use lines::take_lines;

const SETTINGS: SurrogateSettings = SurrogateSettings::DEFAULT;

/// Kind of a surrogate, by what it has of the recording besides mean and variance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum SurrogateKind {
    /// Nothing: Gaussian white noise.
    White,
    /// The spectrum; phases are random (Theiler et al. 1992), and so amplitudes are Gaussian.
    Phase,
    /// The spectrum and the distribution of the innovations (iterated as by Schreiber and Schmitz 1996).
    Amplitude,
    /// The same, and the periodic changes of the innovations' level: a bearing's ball passes make cyclostationary noise.
    #[default]
    Cyclostationary,
}

impl SurrogateKind {
    /// All kinds, from what has least of the recording to what has most.
    pub const ALL: [Self; 4] = [Self::White, Self::Phase, Self::Amplitude, Self::Cyclostationary];

    /// Surrogate of a recording, of the same length.
    pub fn of(self, recording: &[f32], seed: u64) -> Vec<f32> {
        let n = recording.len();
        let mean = recording.iter().map(|v| f64::from(*v)).sum::<f64>() / n as f64;
        let mut centred: Vec<f64> = recording.iter().map(|v| f64::from(*v) - mean).collect();
        let variance = centred.iter().map(|v| v * v).sum::<f64>() / n as f64;
        if n < 3 || variance <= 0.0 {
            return recording.to_vec();
        }
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        if self == Self::White {
            let sample = |_| (mean + variance.sqrt() * rng.sample::<f64, _>(StandardNormal)) as f32;
            return (0..n).map(sample).collect();
        }
        let lines = take_lines(&mut centred);
        let filter = Autoregression::new(&centred);
        let innovations = filter.innovations(&centred);
        let innovations = match self {
            Self::White | Self::Phase => randomise(innovations, &mut rng),
            Self::Amplitude => shuffle(&innovations, &mut rng),
            Self::Cyclostationary => {
                let level = level(&innovations);
                let stationary: Vec<f64> = innovations.iter().zip(&level).map(|(e, level)| e / level).collect();
                shuffle(&stationary, &mut rng).iter().zip(&level).map(|(e, level)| e * level).collect()
            }
        };
        let mut surrogate = filter.coloured(&innovations, n);
        for line in &lines {
            let phase = rng.random_range(0.0..TAU);
            let sample = |t: usize| line.amplitude() * (line.step * t as f64 + phase).cos();
            surrogate.iter_mut().enumerate().for_each(|(t, v)| *v += sample(t));
        }
        surrogate.iter().map(|v| (v + mean) as f32).collect()
    }
}

/// Periodic RMS of the innovations at each sample: the mean of their squares and its spectral lines.
fn level(innovations: &[f64]) -> Vec<f64> {
    let squares: Vec<f64> = innovations.iter().map(|e| e * e).collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    let mut centred: Vec<f64> = squares.iter().map(|e| e - mean).collect();
    let lines = take_lines(&mut centred);
    if mean <= 0.0 {
        return vec![1.0; squares.len()];
    }
    let power = |t: usize| mean + lines.iter().map(|line| line.at(t)).sum::<f64>();
    (0..squares.len()).map(|t| power(t).max(SETTINGS.min_level * mean).sqrt()).collect()
}

/// Values in random order, and then in the order of those of a signal that has their amplitudes' spectrum, so that in the end
/// both the values and, nearly, their spectrum are the same (Schreiber and Schmitz 1996).
fn shuffle(values: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let n = values.len();
    let (forward, inverse) = (forward_plan(n), inverse_plan(n));
    let mut spectrum = forward.make_output_vec();
    let mut scratch = values.to_vec();
    forward.process(&mut scratch, &mut spectrum).expect("buffers are the plan's own");
    let amplitudes: Vec<f64> = spectrum.iter().map(|bin| bin.norm()).collect();
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mut shuffled = values.to_vec();
    shuffled.shuffle(rng);
    for _ in 0..SETTINGS.iterations {
        scratch.copy_from_slice(&shuffled);
        forward.process(&mut scratch, &mut spectrum).expect("buffers are the plan's own");
        for (bin, amplitude) in spectrum.iter_mut().zip(&amplitudes).filter(|(bin, _)| bin.norm() > 0.0) {
            *bin *= amplitude / bin.norm();
        }
        inverse.process(&mut spectrum, &mut scratch).expect("buffers are the plan's own");
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|a, b| scratch[*a].total_cmp(&scratch[*b]));
        order.iter().zip(&sorted).for_each(|(t, value)| shuffled[*t] = *value);
    }
    shuffled
}

/// Randomises the phase of every frequency but the mean's and Nyquist's, which are real.
fn randomise(mut values: Vec<f64>, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let n = values.len();
    let forward = forward_plan(n);
    let inverse = inverse_plan(n);
    let mut spectrum = forward.make_output_vec();
    forward.process(&mut values, &mut spectrum).expect("buffers are the plan's own");
    let last = if n.is_multiple_of(2) { n / 2 } else { spectrum.len() };
    for bin in &mut spectrum[1..last] {
        let angle = rng.random_range(0.0..TAU);
        *bin *= realfft::num_complex::Complex::from_polar(1.0, angle);
    }
    inverse.process(&mut spectrum, &mut values).expect("buffers are the plan's own");
    values.iter_mut().for_each(|v| *v /= n as f64);
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    fn autocovariance(v: &[f32], lag: usize) -> f64 {
        let mean = v.iter().map(|v| f64::from(*v)).sum::<f64>() / v.len() as f64;
        let products = v.iter().zip(&v[lag..]).map(|(a, b)| (f64::from(*a) - mean) * (f64::from(*b) - mean));
        products.sum::<f64>() / v.len() as f64
    }

    #[test]
    fn keeps_the_autocovariance_and_nothing_else() {
        for n in [4000, 4001] {
            // Pulses through a resonance: all phases in line.
            let (mut a, mut b) = (0.0f32, 0.0);
            let recording: Vec<f32> = (0..n)
                .map(|i| {
                    let drive = if i % 97 == 0 { 5.0 } else { 0.01 * (i as f32 * 1.3).sin() };
                    (b, a) = (a, 1.7 * a - 0.9 * b + drive);
                    a + 3.0
                })
                .collect();
            let surrogate = SurrogateKind::Phase.of(&recording, 1);
            assert_eq!(surrogate.len(), n);
            let power = autocovariance(&recording, 0);
            for lag in [0, 1, 7, 25, 97] {
                let difference = autocovariance(&recording, lag) - autocovariance(&surrogate, lag);
                assert!(difference.abs() < 0.05 * power, "{n} {lag} {difference} {power}");
            }
            // The pulses are gone from the fourth moment.
            let kurtosis = |v: &[f32]| {
                let m = v.iter().sum::<f32>() / n as f32;
                let moment = |k: i32| v.iter().map(|v| f64::from(v - m).powi(k)).sum::<f64>() / n as f64;
                moment(4) / moment(2).powi(2)
            };
            assert!(kurtosis(&recording) > 4.0 && kurtosis(&surrogate) < 3.6);
            assert_eq!(surrogate, SurrogateKind::Phase.of(&recording, 1));
            assert_ne!(surrogate, SurrogateKind::Phase.of(&recording, 2));
        }
    }

    /// Innovations by their amplitudes' distribution, and a resonance driven by them whose level swings.
    fn resonance(n: usize, seed: u64, swing: f64, innovation: impl Fn(f64) -> f64) -> Vec<f32> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (mut a, mut b) = (0.0, 0.0);
        let step = |t: usize| {
            let level = 1.0 + swing * (TAU * 0.0137 * t as f64).cos();
            (b, a) = (a, 1.5 * a - 0.8 * b + level * innovation(rng.random_range(0.0..1.0)));
            a as f32
        };
        (0..n).map(step).collect()
    }

    #[test]
    fn invariant_the_spectrum_stays_and_what_is_stated_besides() {
        let skewed = |u: f64| -(1.0 - u).ln() - 1.0;
        let recording = resonance(8192, 3, 0.8, skewed);
        let power = autocovariance(&recording, 0);
        let skewness = |v: &[f32]| {
            let innovations = innovations(v);
            let square = innovations.iter().map(|e| e * e).sum::<f64>() / innovations.len() as f64;
            innovations.iter().map(|e| e.powi(3)).sum::<f64>() / innovations.len() as f64 / square.powf(1.5)
        };
        // Line of the innovations' squares at the frequency of the swing, over their mean.
        let swing = |v: &[f32]| {
            let squares: Vec<f64> = innovations(v).iter().map(|e| e * e).collect();
            let mean = squares.iter().sum::<f64>() / squares.len() as f64;
            let (re, im) = squares.iter().enumerate().fold((0.0, 0.0), |(re, im), (t, e)| {
                let (s, c) = (TAU * 0.0137 * t as f64).sin_cos();
                (re + e * c, im + e * s)
            });
            2.0 * f64::hypot(re, im) / squares.len() as f64 / mean
        };
        assert!(skewness(&recording) > 1.5 && swing(&recording) > 1.0);
        for (kind, is_skewed, swings) in [
            (SurrogateKind::Phase, false, false),
            (SurrogateKind::Amplitude, true, false),
            (SurrogateKind::Cyclostationary, true, true),
        ] {
            let surrogate = kind.of(&recording, 1);
            for lag in [0, 1, 5, 20] {
                let difference = autocovariance(&recording, lag) - autocovariance(&surrogate, lag);
                assert!(difference.abs() < 0.1 * power, "{kind:?} {lag} {difference} {power}");
            }
            assert_eq!(skewness(&surrogate) > 1.0, is_skewed, "{kind:?} {}", skewness(&surrogate));
            assert_eq!(swing(&surrogate) > 0.8, swings, "{kind:?} {}", swing(&surrogate));
        }
        let white = SurrogateKind::White.of(&recording, 1);
        assert!((autocovariance(&white, 0) / power - 1.0).abs() < 0.1 && autocovariance(&white, 1).abs() < 0.1 * power);
    }

    fn innovations(v: &[f32]) -> Vec<f64> {
        let v: Vec<f64> = v.iter().map(|v| f64::from(*v)).collect();
        Autoregression::new(&v).innovations(&v)
    }

    #[test]
    fn a_recording_too_short_for_a_spectrum_is_its_own_surrogate() {
        for kind in SurrogateKind::ALL {
            assert_eq!(kind.of(&[1.0, 2.0], 1), [1.0, 2.0]);
            assert_eq!(kind.of(&[2.0; 100], 1), [2.0; 100]);
        }
    }
}
