use std::f64::consts::TAU;

use super::*;

fn sine(frequency_hz: f64, rate_hz: f64, count: usize) -> Vec<f64> {
    (0..count).map(|n| (TAU * frequency_hz * n as f64 / rate_hz + 0.4).sin()).collect()
}

/// The largest error against `expected` away from the ends, where the reflection is not the sine.
fn error(found: &[f64], expected: &[f64], edge: usize) -> f64 {
    let inside = edge..found.len() - edge;
    let pairs = found[inside.clone()].iter().zip(&expected[inside]);
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

const RATES: [(f64, f64); 5] = [
    (25_600.0, 12_000.0),
    (48_000.0, 12_000.0),
    (12_000.0, 25_600.0),
    (48_828.0, 25_600.0),
    (25_600.0, 25_600.0 / 1.5),
];

/// Invariant: a sine in the pass band is the same sine at the new rate.
#[test]
fn pass_band() {
    for (from, to) in RATES {
        let nyquist = 0.5 * from.min(to);
        for part in [0.001, 0.1, 0.5, 0.8, PASS_BAND] {
            let found = samples(&sine(part * nyquist, from, 8000), from, to);
            let expected = sine(part * nyquist, to, found.len());
            let error = error(&found, &expected, 300);
            assert!(error < 2e-5, "{from} to {to} Hz, {part} of Nyquist: {error}");
        }
    }
}

/// Invariant: what lies beyond the new Nyquist frequency neither passes nor folds back.
#[test]
fn stop_band() {
    let limit = 10_f64.powf(-STOP_BAND_DB / 20.0);
    for (from, to) in RATES.into_iter().filter(|(from, to)| from > to) {
        for part in [1.0, 1.01, 1.1, 1.3] {
            let found = samples(&sine(part * 0.5 * to, from, 16_000), from, to);
            let error = error(&found, &vec![0.0; found.len()], 200);
            assert!(error < limit, "{from} to {to} Hz, {part} of Nyquist: {error}");
        }
    }
}

/// Invariant: a sine above the old Nyquist frequency does not appear when the rate is raised.
#[test]
fn no_images() {
    let (from, to) = (12_000.0, 25_600.0);
    let found = samples(&sine(5000.0, from, 12_000), from, to);
    // The image of 5 kHz would lie at 7 kHz: correlate with it over whole periods.
    let middle = &found[1280..1280 + 12_800];
    let part = |quadrature: f64| {
        let phase = |n: usize| TAU * 7000.0 * n as f64 / to + quadrature;
        let sum: f64 = middle.iter().enumerate().map(|(n, x)| x * phase(n).sin()).sum();
        2.0 * sum / middle.len() as f64
    };
    let image = part(0.0).hypot(part(0.25 * TAU));
    assert!(image < 1e-5, "{image}");
}

#[test]
fn a_constant_and_a_short_signal_stay_what_they_are() {
    for count in [1, 2, 7, 1000] {
        let found = samples(&vec![9.81; count], 25_600.0, 12_000.0);
        assert_eq!(found.len(), (count * 15).div_ceil(32));
        assert!(found.iter().all(|x| (x - 9.81).abs() < 1e-12), "{found:?}");
    }
}

#[test]
fn rates_become_fractions() {
    assert_eq!(ratio(12_000.0 / 25_600.0), (15, 32));
    assert_eq!(ratio(12_000.0 / 48_828.0), (1000, 4069));
    assert_eq!(ratio(1.0), (1, 1));
    assert_eq!(ratio(3.0), (3, 1));
    let (up, down) = ratio(std::f64::consts::PI / 4.0);
    assert!((up as f64 / down as f64 / (std::f64::consts::PI / 4.0) - 1.0).abs() < 1e-7);
    // Far beyond any sensible request, but it must not hang or divide by zero.
    for extreme in [1e-9, 1e9, f64::MIN_POSITIVE] {
        let (up, down) = ratio(extreme);
        assert!(up > 0 && down > 0, "{extreme}");
    }
}

#[test]
fn tacho_pulses_are_moved_and_not_filtered() {
    let mut tacho = vec![0.0; 3200];
    for pulse in [0, 1000, 2001, 3199] {
        tacho[pulse] = 1.0;
    }
    let channel = Channel { name: "tacho".into(), location: None, samples: tacho };
    let original = Recording { channels: vec![channel], sample_rate_hz: 25_600.0, ..Recording::default() };
    let moved = recording(original, 12_000.0);
    let samples = &moved.channels[0].samples;
    assert_eq!(samples.len(), 1500);
    assert_eq!(moved.sample_rate_hz, 12_000.0);
    let pulses: Vec<usize> = (0..1500).filter(|&n| samples[n] != 0.0).collect();
    assert_eq!(pulses, [0, 469, 938, 1499]);
}
