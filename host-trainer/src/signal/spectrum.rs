//! Power spectral density (Welch 1967), theory (70), and amplitude spectrum, theory (71).

use std::ops::Range;

use super::Sample;
use super::settings::SpectrumSettings;
use super::transform::{forward_plan, hann};

/// A quantity over evenly spaced frequencies from 0 on.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Step from 0 Hz, Hz.
    pub step_hz: f64,
    /// Values, one per step.
    pub values: Vec<f64>,
}

impl Spectrum {
    /// Frequency and value, in order.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.values.iter().enumerate().map(|(k, v)| (k as f64 * self.step_hz, *v))
    }

    /// Sum over a band times the step: for a density, the power in it.
    pub fn integral(&self, band_hz: &Range<f64>) -> f64 {
        self.points().filter(|(f, _)| band_hz.contains(f)).map(|(_, v)| v).sum::<f64>() * self.step_hz
    }
}

/// Share of the band up to Nyquist's frequency within a converter's passband.
pub const USABLE: f64 = SpectrumSettings::DEFAULT.passband_share;

fn windowed<S: Sample>(samples: &[S], window: &[f64]) -> Vec<f64> {
    let mean = samples.iter().map(|v| (*v).into()).sum::<f64>() / samples.len().max(1) as f64;
    samples.iter().zip(window).map(|(v, w)| ((*v).into() - mean) * w).collect()
}

/// One-sided power spectral density in (unit of the samples)²/Hz, theory (70): segments overlap by half, each without
/// its mean and under a Hann window, averaged over all segments of all recordings.
///
/// `None` if `segment` is under 8 samples or longer than every recording.
pub fn welch<S: Sample>(recordings: &[&[S]], sample_rate_hz: f64, segment: usize) -> Option<Spectrum> {
    if segment < 8 {
        return None;
    }
    let window = hann(segment);
    let transform = forward_plan(segment);
    let mut bins = transform.make_output_vec();
    let mut values = vec![0.0; bins.len()];
    let mut segments = 0;
    for recording in recordings {
        for start in (0..=recording.len().checked_sub(segment).map_or(0, |s| s)).step_by(segment / 2) {
            let Some(part) = recording.get(start..start + segment) else { continue };
            transform.process(&mut windowed(part, &window), &mut bins).ok()?;
            values.iter_mut().zip(&bins).for_each(|(v, b)| *v += b.norm_sqr());
            segments += 1;
        }
    }
    if segments == 0 {
        return None;
    }
    let scale = 1.0 / (sample_rate_hz * window.iter().map(|w| w * w).sum::<f64>() * f64::from(segments));
    let last = values.len() - 1;
    for (k, value) in values.iter_mut().enumerate() {
        // All but the mean and Nyquist's frequency count twice.
        let sides = if k == 0 || (k == last && segment.is_multiple_of(2)) { 1.0 } else { 2.0 };
        *value *= sides * scale;
    }
    Some(Spectrum { step_hz: sample_rate_hz / segment as f64, values })
}

/// Amplitude spectrum in the unit of the samples (peak, not RMS), theory (71): a tone a·cos shows as a. Hann window
/// over the whole length, mean removed, powers averaged over recordings, all cut to the shortest.
///
/// `None` for no recording, or one of under 8 samples.
pub fn amplitudes<S: Sample>(recordings: &[&[S]], sample_rate_hz: f64) -> Option<Spectrum> {
    let length = recordings.iter().map(|r| r.len()).min().filter(|length| *length >= 8)?;
    let window = hann(length);
    let weight = window.iter().sum::<f64>();
    let transform = forward_plan(length);
    let mut bins = transform.make_output_vec();
    let mut values = vec![0.0; bins.len()];
    for recording in recordings {
        let samples = || recording.iter().zip(&window).map(|(v, w)| ((*v).into(), w));
        // The mean under the window, so that none of it leaks to the lowest frequencies.
        let mean = samples().map(|(v, w)| v * w).sum::<f64>() / weight;
        let mut shaped: Vec<f64> = samples().map(|(v, w)| (v - mean) * w * 2.0 / weight).collect();
        transform.process(&mut shaped, &mut bins).ok()?;
        values.iter_mut().zip(&bins).for_each(|(v, b)| *v += b.norm_sqr() / recordings.len() as f64);
    }
    values.iter_mut().for_each(|v| *v = v.sqrt());
    Some(Spectrum { step_hz: sample_rate_hz / length as f64, values })
}

/// Band of a width in which `late` has gained most power over `early`, both of the same step. Bands beyond [`USABLE`]
/// of Nyquist's frequency do not count: a converter's filter leaves so little there that any change is a large ratio.
pub fn band_of_most_gain(early: &Spectrum, late: &Spectrum, width_hz: f64) -> Range<f64> {
    let nyquist = (early.values.len().saturating_sub(1)) as f64 * early.step_hz;
    let width = width_hz.min(nyquist);
    let starts = ((USABLE * nyquist - width) / early.step_hz).max(0.0) as usize;
    let gain = |band: &Range<f64>| late.integral(band) / early.integral(band).max(f64::MIN_POSITIVE);
    let bands = (1..=starts.max(1)).map(|k| k as f64 * early.step_hz).map(|from| from..from + width);
    bands.max_by(|a, b| gain(a).total_cmp(&gain(b))).unwrap_or(0.0..nyquist)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::f64::consts::TAU;

    const RATE: f64 = 12_800.0;

    fn noise(count: usize) -> Vec<f32> {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        (0..count).map(|_| rng.random_range(-1.0..1.0f32)).collect()
    }

    fn signal(count: usize, f: impl Fn(f64) -> f64) -> Vec<f32> {
        (0..count).map(|i| f(i as f64 / RATE) as f32).collect()
    }

    #[test]
    fn invariant_parseval_of_one_segment() {
        for count in [1024, 1023] {
            let samples = noise(count);
            let spectrum = welch(&[&samples], RATE, count).unwrap();
            let window = hann(count);
            let power: f64 = windowed(&samples, &window).iter().map(|v| v * v).sum();
            let expected = power / window.iter().map(|w| w * w).sum::<f64>();
            let got = spectrum.integral(&(0.0..RATE));
            assert!((got / expected - 1.0).abs() < 1e-12, "{got} {expected}");
        }
    }

    #[test]
    fn literature_white_noise_is_flat_at_its_variance_over_the_band() {
        // Uniform in ±1: variance 1/3, one-sided over RATE/2.
        let spectrum = welch(&[&noise(400_000)], RATE, 256).unwrap();
        let expected = 1.0 / 3.0 / (RATE / 2.0);
        for (f, v) in spectrum.points().skip(2).take(124) {
            assert!((v / expected - 1.0).abs() < 0.12, "{f} {v} {expected}");
        }
        assert!((spectrum.integral(&(0.0..RATE)) - 1.0 / 3.0).abs() < 0.005);
    }

    #[test]
    fn a_tone_has_half_its_squared_amplitude_and_no_mean_is_left() {
        let samples = signal(12_800, |t| 50.0 + 3.0 * (TAU * 1000.0 * t).sin());
        let spectrum = welch(&[&samples], RATE, 1024).unwrap();
        let around = spectrum.integral(&(900.0..1100.0));
        assert!((around - 4.5).abs() < 1e-3, "{around}");
        assert!(spectrum.integral(&(0.0..900.0)) < 1e-3);
        assert_eq!(welch(&[&samples[..100]], RATE, 1024), None);
        assert_eq!(welch::<f32>(&[], RATE, 1024), None);
    }

    #[test]
    fn the_band_of_most_gain_holds_what_was_added() {
        let early = noise(12_800);
        let tone = signal(12_800, |t| 0.5 * (TAU * 4000.0 * t).sin());
        let late: Vec<f32> = early.iter().zip(&tone).map(|(a, b)| a + b).collect();
        let of = |samples: &[f32]| welch(&[samples], RATE, 256).unwrap();
        let band = band_of_most_gain(&of(&early), &of(&late), 800.0);
        assert!(band.contains(&4000.0) && (band.end - band.start - 800.0).abs() < 1e-9, "{band:?}");
    }
}
