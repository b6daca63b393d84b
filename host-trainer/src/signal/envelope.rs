//! Envelope of a band by its analytic signal, theory (72), and its spectrum, theory (71).

use std::ops::Range;

use realfft::num_complex::Complex;

use super::Sample;
use super::spectrum::{Spectrum, amplitudes};
use super::transform::{forward_plan, inverse_plan};

/// Envelope of a recording in a band: the magnitude of its analytic signal. `None` for under 8 samples.
///
/// The band has sharp edges, and the transform takes the recording for periodic: the first and last few periods of
/// the band's width are in error.
pub fn envelope<S: Sample>(samples: &[S], sample_rate_hz: f64, band_hz: &Range<f64>) -> Option<Vec<f64>> {
    let n = samples.len();
    if n < 8 {
        return None;
    }
    let (forward, inverse) = (forward_plan(n), inverse_plan(n));
    let mut real: Vec<f64> = samples.iter().map(|v| (*v).into()).collect();
    let mut bins = forward.make_output_vec();
    forward.process(&mut real, &mut bins).ok()?;
    let last = bins.len() - 1;
    for (k, bin) in bins.iter_mut().enumerate() {
        // The mean and Nyquist's frequency have no quadrature.
        let inside = band_hz.contains(&(k as f64 * sample_rate_hz / n as f64)) && k != 0 && k != last;
        *bin = if inside { *bin / n as f64 } else { Complex::default() };
    }
    let mut quadrature_bins: Vec<_> = bins.iter().map(|b| b * Complex::new(0.0, -1.0)).collect();
    let mut quadrature = vec![0.0; n];
    inverse.process(&mut bins, &mut real).ok()?;
    inverse.process(&mut quadrature_bins, &mut quadrature).ok()?;
    Some(real.iter().zip(&quadrature).map(|(a, b)| a.hypot(*b)).collect())
}

/// Amplitude spectrum of the envelope in a band, in the unit of the samples (peak, not RMS): a tone that modulates
/// with amplitude a shows as a. Hann window, mean removed, powers averaged over recordings, all cut to the shortest.
/// `None` for no recording or under 8 samples.
pub fn envelope_spectrum<S: Sample>(
    recordings: &[&[S]],
    sample_rate_hz: f64,
    band_hz: &Range<f64>,
) -> Option<Spectrum> {
    of_envelopes(recordings, sample_rate_hz, band_hz, |v| v)
}

/// Amplitude spectrum of the squared envelope, in the unit of the samples squared; otherwise as [`envelope_spectrum`].
/// Powers of random parts add, so that the noise level is flat (Antoni, Mechanical Systems and Signal Processing 21
/// (2007) 597–630).
pub fn squared_envelope_spectrum<S: Sample>(
    recordings: &[&[S]],
    sample_rate_hz: f64,
    band_hz: &Range<f64>,
) -> Option<Spectrum> {
    of_envelopes(recordings, sample_rate_hz, band_hz, |v| v * v)
}

fn of_envelopes<S: Sample>(
    recordings: &[&[S]],
    sample_rate_hz: f64,
    band_hz: &Range<f64>,
    shape: fn(f64) -> f64,
) -> Option<Spectrum> {
    let length = recordings.iter().map(|r| r.len()).min()?;
    // One at a time, so that only one is held.
    let mut sum: Option<Spectrum> = None;
    for recording in recordings {
        let mut envelope = envelope(recording.get(..length)?, sample_rate_hz, band_hz)?;
        envelope.iter_mut().for_each(|v| *v = shape(*v));
        let mut spectrum = amplitudes(&[&envelope], sample_rate_hz)?;
        spectrum.values.iter_mut().for_each(|v| *v *= *v);
        match &mut sum {
            None => sum = Some(spectrum),
            Some(sum) => sum.values.iter_mut().zip(&spectrum.values).for_each(|(s, v)| *s += v),
        }
    }
    let mut mean = sum?;
    mean.values.iter_mut().for_each(|v| *v = (*v / recordings.len() as f64).sqrt());
    Some(mean)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const RATE: f64 = 12_800.0;

    fn signal(count: usize, f: impl Fn(f64) -> f64) -> Vec<f32> {
        (0..count).map(|i| f(i as f64 / RATE) as f32).collect()
    }

    #[test]
    fn the_envelope_of_a_modulated_carrier_is_its_modulation() {
        let modulation = |t: f64| 2.0 + 0.5 * (TAU * 90.0 * t).cos();
        let samples = signal(12_800, |t| modulation(t) * (TAU * 3000.0 * t).sin() + 9.0 * (TAU * 400.0 * t).sin());
        let band = 2000.0..4000.0;
        let got = envelope(&samples, RATE, &band).unwrap();
        for (i, v) in got.iter().enumerate() {
            assert!((v - modulation(i as f64 / RATE)).abs() < 1e-4, "{i} {v}");
        }
        let spectrum = envelope_spectrum(&[&samples, &samples], RATE, &band).unwrap();
        assert!((spectrum.values[90] - 0.5).abs() < 1e-4, "{}", spectrum.values[90]);
        let elsewhere = spectrum.points().filter(|(f, _)| (f - 90.0).abs() > 2.5).map(|(_, v)| v).fold(0.0, f64::max);
        assert!(elsewhere < 1e-3, "{elsewhere}");
    }

    #[test]
    fn the_squared_envelope_of_two_tones_is_their_beat() {
        // |a + b exp(iδt)|² = a² + b² + 2ab cos δt.
        let tone = |t: f64, hz: f64| (TAU * hz * t).sin();
        let samples: Vec<f64> =
            (0..12_800).map(|i| i as f64 / RATE).map(|t| 3.0 * tone(t, 2000.0) + 0.5 * tone(t, 2100.0)).collect();
        let spectrum = squared_envelope_spectrum(&[&samples], RATE, &(1500.0..2500.0)).unwrap();
        assert!((spectrum.values[100] - 3.0).abs() < 1e-9, "{}", spectrum.values[100]);
        assert!(spectrum.values[200] < 1e-9);
    }
}
