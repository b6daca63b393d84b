//! Phase-randomised surrogates (Theiler et al. 1992): the recording's power spectrum with random phases, theory (24).
//!
//! The randomised phases are those of the recording whitened by an autoregression, which colours the result again.
//! Without the whitening the jump from the recording's end back to its start leaks over the whole spectrum, makes
//! every surrogate a little less predictable than its recording, and lets a linear recording beat its null (measured
//! on a resonance driven by noise: next-sample R² 0.8398 against 0.8384 ± 0.0001). Spectral lines leak likewise, and
//! no autoregression whitens them: they are taken out first and put back with random phases.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::settings::SurrogateSettings;
use crate::signal::transform::{forward_plan, inverse_plan};
use crate::stats::optimise::golden_section;

const SETTINGS: SurrogateSettings = SurrogateSettings::DEFAULT;

/// A surrogate of a recording: same length, mean and power spectrum, random phases.
pub fn phase_randomised(recording: &[f32], seed: u64) -> Vec<f32> {
    let n = recording.len();
    let order = SETTINGS.max_order.min(n / SETTINGS.samples_per_order);
    if n < 3 {
        return recording.to_vec();
    }
    let mean = recording.iter().map(|v| f64::from(*v)).sum::<f64>() / n as f64;
    let mut centred: Vec<f64> = recording.iter().map(|v| f64::from(*v) - mean).collect();
    let lines = take_lines(&mut centred);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let filter = burg(&centred, order);
    let innovations: Vec<f64> = centred
        .windows(order + 1)
        .map(|w| w[order] + filter.iter().zip(w.iter().rev().skip(1)).map(|(c, v)| c * v).sum::<f64>())
        .collect();
    let innovations = randomise(innovations, &mut rng);
    // Twice around: the first time settles the filter.
    let mut coloured: Vec<f64> = Vec::with_capacity(innovations.len() + n);
    for innovation in innovations.iter().cycle().take(innovations.len() + n) {
        let past: f64 = filter.iter().zip(coloured.iter().rev()).map(|(c, v)| c * v).sum();
        coloured.push(innovation - past);
    }
    let mut surrogate = coloured.split_off(innovations.len());
    for line in &lines {
        let phase = rng.random_range(0.0..TAU);
        surrogate.iter_mut().enumerate().for_each(|(t, v)| *v += line.amplitude * (line.step * t as f64 + phase).cos());
    }
    surrogate.iter().map(|v| (v + mean) as f32).collect()
}

/// A spectral line.
#[derive(Clone, Copy, Debug)]
struct Line {
    /// Frequency, rad/sample.
    step: f64,
    amplitude: f64,
}

/// Subtracts spectral lines, the strongest first, each fitted by least squares.
fn take_lines(values: &mut [f64]) -> Vec<Line> {
    let n = values.len();
    let window: Vec<f64> = (0..n).map(|t| 0.5 - 0.5 * (TAU * (t as f64 + 0.5) / n as f64).cos()).collect();
    let forward = forward_plan(n);
    let mut spectrum = forward.make_output_vec();
    let mut lines = Vec::new();
    while lines.len() < SETTINGS.max_lines {
        let mut windowed: Vec<f64> = values.iter().zip(&window).map(|(v, w)| v * w).collect();
        forward.process(&mut windowed, &mut spectrum).expect("buffers are the plan's own");
        let power: Vec<f64> = spectrum.iter().map(|bin| bin.norm_sqr()).collect();
        let Some(bin) = strongest_line(&power) else { break };
        let at = |step: f64| -> f64 {
            let (mut re, mut im) = (0.0, 0.0);
            for (t, (v, w)) in values.iter().zip(&window).enumerate() {
                let (s, c) = (step * t as f64).sin_cos();
                re += v * w * c;
                im -= v * w * s;
            }
            re * re + im * im
        };
        let step = golden_section(&at, TAU * (bin as f64 - 1.0) / n as f64, TAU * (bin as f64 + 1.0) / n as f64);
        // Least squares for c cos + s sin.
        let (mut cc, mut cs, mut ss, mut vc, mut vs) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (t, v) in values.iter().enumerate() {
            let (s, c) = (step * t as f64).sin_cos();
            (cc, cs, ss, vc, vs) = (cc + c * c, cs + c * s, ss + s * s, vc + v * c, vs + v * s);
        }
        let determinant = cc * ss - cs * cs;
        let (c, s) = ((vc * ss - vs * cs) / determinant, (vs * cc - vc * cs) / determinant);
        for (t, v) in values.iter_mut().enumerate() {
            let (sine, cosine) = (step * t as f64).sin_cos();
            *v -= c * cosine + s * sine;
        }
        lines.push(Line { step, amplitude: c.hypot(s) });
    }
    lines
}

/// Bin of the strongest line, if any.
fn strongest_line(power: &[f64]) -> Option<usize> {
    let (far, near) = (SETTINGS.neighbourhood_bins, SETTINGS.guard_bins);
    let ratio = |k: usize| {
        let around = (k.saturating_sub(far)..(k + far + 1).min(power.len())).filter(|j| j.abs_diff(k) > near);
        let mut around: Vec<f64> = around.map(|j| power[j]).collect();
        around.sort_by(f64::total_cmp);
        let median = around.get(around.len() / 2).copied().unwrap_or(f64::INFINITY);
        power[k] / median.max(f64::MIN_POSITIVE)
    };
    let peaks = (2..power.len().saturating_sub(2)).filter(|k| power[*k] >= power[k - 1] && power[*k] >= power[k + 1]);
    let outstanding = peaks.filter(|k| ratio(*k) > SETTINGS.line_ratio);
    outstanding.max_by(|a, b| power[*a].total_cmp(&power[*b]))
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

/// Prediction-error filter 1 + Σ c_k q⁻ᵏ by Burg's method (1967): always stable.
fn burg(x: &[f64], order: usize) -> Vec<f64> {
    let (mut forward, mut backward) = (x.to_vec(), x.to_vec());
    let mut filter: Vec<f64> = Vec::new();
    for m in 0..order {
        let pairs = || forward[m + 1..].iter().zip(&backward[m..]);
        let cross: f64 = pairs().map(|(f, b)| f * b).sum();
        let power: f64 = pairs().map(|(f, b)| f * f + b * b).sum();
        if power <= 0.0 {
            break;
        }
        let reflection = -2.0 * cross / power;
        let reversed: Vec<f64> = filter.iter().rev().copied().collect();
        filter.iter_mut().zip(&reversed).for_each(|(a, b)| *a += reflection * b);
        filter.push(reflection);
        for t in (m + 1..x.len()).rev() {
            let (f, b) = (forward[t], backward[t - 1]);
            forward[t] = f + reflection * b;
            backward[t] = b + reflection * f;
        }
    }
    filter.resize(order, 0.0);
    filter
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
            let surrogate = phase_randomised(&recording, 1);
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
            assert_eq!(surrogate, phase_randomised(&recording, 1));
            assert_ne!(surrogate, phase_randomised(&recording, 2));
        }
    }

    #[test]
    fn literature_burg_finds_an_autoregression() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut a, mut b) = (0.0, 0.0);
        let x: Vec<f64> = (0..20_000)
            .map(|_| {
                (b, a) = (a, 1.6 * a - 0.9 * b + rng.random_range(-1.0..1.0));
                a
            })
            .collect();
        let filter = burg(&x, 4);
        for (got, expected) in filter.iter().zip([-1.6, 0.9, 0.0, 0.0]) {
            assert!((got - expected).abs() < 0.02, "{filter:?}");
        }
    }
}
