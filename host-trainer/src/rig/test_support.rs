//! Rigs and spectra that the tests share.

use std::{f64::consts::TAU, path::Path};

use realfft::num_complex::Complex;

use super::effect::{EffectKind, ParameterKey};
use super::{EffectEntry, OperatingCondition, Rig, Start, simulate};
use crate::recording::Recording;
use crate::signal::transform::{forward_plan, inverse_plan};

/// Rig A of the reference data: 9 balls, outer race at 174 Hz, resonator at 5.4 kHz.
pub const RIG: &str = r#"# nominal rig: what the engineer knows
[bearing]
balls = 9
ball_diameter_m = 0.00794  # from the catalogue
pitch_diameter_m = 0.0385
contact_angle_rad = 0.0
radial_clearance_m = 2e-06
contact_stiffness_n_per_m1_5 = 8753000000.0
contact_exponent = 1.5
[inner]
mass_kg = 1.2638
stiffness_n_per_m = 5000000.0
damping_n_s_per_m = 1376.8
[outer]
mass_kg = 12.638
stiffness_n_per_m = 15100000.0
damping_n_s_per_m = 2210.7
[resonator]
mass_kg = 1.0
stiffness_n_per_m = 1070000000.0
damping_n_s_per_m = 1960.0
[excitation]
unbalance_kg_m = 0.0002
process_force_psd_n2_per_hz = 2e-05
[sensor]
noise_std_m_per_s2 = 0.02
vertical = "resonator-y"
horizontal = "outer-x"
"#;

pub const SDOF: &str = "kind = \"sdof\"\nmass_kg = 2.0\ndamping_n_s_per_m = 0.0\nstiffness_n_per_m = 800.0\n\
                        input_gain_n_per_unit = 3.0\nrestoring = \"linear\"\ngravity_n = 0.0\n";

pub const RATE: f64 = 25_600.0;

pub fn parse(text: &str) -> Rig {
    Rig::parse(text, Path::new("rig.toml")).unwrap()
}

pub fn nominal() -> Rig {
    parse(RIG)
}

pub fn condition(shaft_hz: f64, load_n: f64, samples: usize) -> OperatingCondition {
    OperatingCondition { shaft_hz, load_n, sample_rate_hz: RATE, samples }
}

/// Half a second at 30 Hz and 500 N without noise, which makes lines sharp and the background their leakage.
pub fn noise_free(rig: &Rig) -> Recording {
    simulate(rig, &condition(30.0, 500.0, 12_800), &Start::noise_free(0.3, 0.7)).unwrap()
}

pub fn with(kind: EffectKind, numbers: &[(ParameterKey, f64)]) -> Rig {
    nominal().with_effect(EffectEntry::new(kind, numbers))
}

pub fn samples<'a>(recording: &'a Recording, channel: &str) -> &'a [f64] {
    &recording.channel(channel).unwrap().samples
}

pub fn rms(signal: &[f64]) -> f64 {
    (signal.iter().map(|v| v * v).sum::<f64>() / signal.len() as f64).sqrt()
}

fn hann(index: usize, count: usize) -> f64 {
    0.5 - 0.5 * (TAU * (index as f64 + 0.5) / count as f64).cos()
}

/// Amplitude of the line at a frequency, Hann window.
pub fn line(signal: &[f64], rate: f64, frequency: f64) -> f64 {
    let mean = signal.iter().sum::<f64>() / signal.len() as f64;
    let sum: Complex<f64> = signal
        .iter()
        .enumerate()
        .map(|(i, v)| Complex::from_polar((v - mean) * hann(i, signal.len()), TAU * frequency * i as f64 / rate))
        .sum();
    4.0 * sum.norm() / signal.len() as f64
}

/// Frequency of the highest line between `from` and `to`, Hz.
pub fn peak(signal: &[f64], rate: f64, from: f64, to: f64) -> f64 {
    let steps = 800;
    let at = |k: usize| from + (to - from) * k as f64 / steps as f64;
    let highest = (0..=steps).map(|k| (line(signal, rate, at(k)), at(k)));
    highest.fold((0.0, from), |a, b| if b.0 > a.0 { b } else { a }).1
}

/// Squared envelope of a band.
pub fn envelope(signal: &[f64], rate: f64, from: f64, to: f64) -> Vec<f64> {
    let n = signal.len();
    let (forward, inverse) = (forward_plan(n), inverse_plan(n));
    let mut spectrum = forward.make_output_vec();
    forward.process(&mut signal.to_vec(), &mut spectrum).unwrap();
    let mut parts = [Complex::new(1.0, 0.0), Complex::new(0.0, -1.0)].map(|turn| {
        let band = |(k, v): (usize, &Complex<f64>)| {
            let frequency = k as f64 * rate / n as f64;
            if (from..to).contains(&frequency) { v * turn } else { Complex::ZERO }
        };
        let mut bins: Vec<_> = spectrum.iter().enumerate().map(band).collect();
        let mut part = inverse.make_output_vec();
        inverse.process(&mut bins, &mut part).unwrap();
        part
    });
    let [quadrature, direct] = [parts[1].split_off(0), parts[0].split_off(0)];
    direct.iter().zip(&quadrature).map(|(a, b)| (a * a + b * b) / (n * n) as f64).collect()
}
