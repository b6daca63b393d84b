//! Log-spectral distance.

use super::settings::CalibrationSettings;
use crate::signal::spectrum::welch;

const SETTINGS: CalibrationSettings = CalibrationSettings::DEFAULT;

/// Log-spectral distance of two recordings of a channel, dB, theory (61): root mean square over frequencies of ten times
/// the logarithm of the ratio of their power densities (A. Gray, J. Markel, "Distance measures for speech processing", IEEE
/// Trans. ASSP 24 (1976) 380–391, eq. 5; Welch's densities, Hann windows of 2048 samples), up to 1/2.56 of the sample rate.
///
/// `None` for recordings of under 8 samples.
pub fn log_spectral(measured: &[f64], predicted: &[f64], sample_rate_hz: f64) -> Option<f64> {
    let segment = SETTINGS.segment.min(measured.len()).min(predicted.len());
    let density = |samples: &[f64]| welch(&[samples], sample_rate_hz, segment);
    let (p, q) = (density(measured)?.values, density(predicted)?.values);
    let floor = SETTINGS.density_floor * p.iter().copied().fold(0.0, f64::max);
    let pairs = p.iter().zip(&q).take(within_pass_band(p.len())).filter(|(p, _)| **p > floor);
    let (sum, count) = pairs.fold((0.0, 0usize), |(sum, count), (p, q)| {
        (sum + (10.0 * ((p + 1e-30) / (q + 1e-30)).log10()).powi(2), count + 1)
    });
    (count > 0).then(|| (sum / count as f64).sqrt())
}

/// How many of the frequencies from 0 to half the sample rate are compared.
pub fn within_pass_band(frequencies: usize) -> usize {
    (SETTINGS.pass_band * frequencies as f64).ceil() as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twice_the_amplitude_is_six_decibels_apart() {
        let one: Vec<f64> = (0..8192u64).map(|i| ((i * i * 7919) % 1013) as f64 - 506.0).collect();
        let two: Vec<f64> = one.iter().map(|v| 2.0 * v).collect();
        let distance = log_spectral(&one, &two, 1000.0).unwrap();
        assert!((distance - 20.0 * 2f64.log10()).abs() < 1e-5, "{distance}");
        assert_eq!(log_spectral(&one, &one, 1000.0), Some(0.0));
        assert_eq!(log_spectral(&one[..4], &two, 1000.0), None);
    }
}
