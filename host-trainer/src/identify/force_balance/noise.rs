//! Noise floor of a sensor, and band of the signal above it.

use super::settings::BalanceSettings;
use crate::signal::transform::forward_plan;

const SETTINGS: BalanceSettings = BalanceSettings::DEFAULT;

/// Noise and band of a measured signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Standard deviation of white noise in each sample; an upper bound where the signal fills the whole band.
    pub noise_std: f64,
    /// Lowest frequency of the signal above the noise, Hz.
    pub low_hz: f64,
    /// Highest frequency of the signal above the noise, Hz.
    pub high_hz: f64,
}

/// Power in each of `segment/2 + 1` frequencies, normalised so that white noise of variance s² has s² in each;
/// segments overlap by half under a Blackman–Harris window, whose side lobes lie 92 dB down (F. J. Harris, Proc. IEEE 66
/// (1978) 51–83): position spectra fall as steeply as f⁻⁴.
pub fn power(signals: &[&[f64]], segment: usize) -> Vec<f64> {
    let window: Vec<f64> = (0..segment)
        .map(|i| {
            let x = std::f64::consts::TAU * i as f64 / segment as f64;
            0.35875 - 0.48829 * x.cos() + 0.14128 * (2.0 * x).cos() - 0.01168 * (3.0 * x).cos()
        })
        .collect();
    let transform = forward_plan(segment);
    let mut bins = transform.make_output_vec();
    let (mut sum, mut count) = (vec![0.0; bins.len()], 0.0);
    for signal in signals {
        for start in (0..=signal.len().saturating_sub(segment)).step_by(segment / 2) {
            let Some(part) = signal.get(start..start + segment) else { continue };
            let mean = part.iter().sum::<f64>() / segment as f64;
            let mut real: Vec<f64> = part.iter().zip(&window).map(|(x, w)| (x - mean) * w).collect();
            if transform.process(&mut real, &mut bins).is_err() {
                continue;
            }
            sum.iter_mut().zip(&bins).for_each(|(s, b)| *s += b.norm_sqr());
            count += 1.0;
        }
    }
    let scale = window.iter().map(|w| w * w).sum::<f64>() * f64::max(count, 1.0);
    sum.iter_mut().for_each(|s| *s /= scale);
    sum
}

/// Noise and band of signals of one sample rate. `None` for signals shorter than 64 samples.
pub fn band(signals: &[&[f64]], sample_rate_hz: f64) -> Option<Band> {
    let shortest = signals.iter().map(|s| s.len()).min()?;
    if shortest < SETTINGS.min_segment {
        return None;
    }
    let segment = SETTINGS.segment.min(shortest / 4 * 2).max(SETTINGS.min_segment);
    let power = power(signals, segment);
    let step_hz = sample_rate_hz / segment as f64;
    // The window's main lobe smears the subtracted mean.
    let first = 1;
    let top = ((1.0 - SETTINGS.noise_share) * power.len() as f64) as usize;
    let mut highest: Vec<f64> = power[top..power.len() - 1].to_vec();
    highest.sort_by(f64::total_cmp);
    // The median over the mean of averaged periodograms is within a few percent of 1; a line there does not count.
    let floor = highest[highest.len() / 2];
    let above = |k: &usize| power[*k] > SETTINGS.band_power_ratio * floor;
    let mut inside: Vec<usize> = (first..power.len()).filter(above).collect();
    // A single bin, such as an electrical line, is no band: the highest of at least three in a row.
    inside.retain(|k| *k <= 2 || (above(&(k - 1)) && above(&(k - 2))));
    let high = inside.last().copied().unwrap_or(4).max(4);
    let low = inside.first().copied().unwrap_or(1);
    Some(Band { noise_std: floor.sqrt(), low_hz: low as f64 * step_hz, high_hz: high as f64 * step_hz })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_noise_and_band_of_a_low_passed_signal() {
        let noise = super::super::testing::white(3, 1.0, 40_000);
        let slow = crate::identify::force_balance::filter::Kernel::gaussian(8.0, 0, 1.0).everywhere(&noise);
        let sensor = super::super::testing::white(4, 1e-3, 40_000);
        let sum: Vec<f64> = slow.iter().zip(&sensor).map(|(a, b)| a + b).collect();
        let band = band(&[&sum], 1000.0).unwrap();
        assert!((band.noise_std / 1e-3 - 1.0).abs() < 0.05, "{band:?}");
        // The spectrum of the slow part is 1e-5 of white noise's where exp(−4π²σ²f²) is.
        let expected = 1000.0 * (1e5f64.ln() / 4.0).sqrt() / (std::f64::consts::PI * 8.0);
        assert!((band.high_hz / expected - 1.0).abs() < 0.15, "{band:?} {expected}");
    }
}
