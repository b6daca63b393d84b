//! Swing: a level that rises and falls within a recording, as of a loose connector, or a tone that sweeps through a band. A power
//! spectrum has no time and shows little of it.

use realfft::num_complex::Complex;
use statrs::statistics::Statistics;

use super::observation::Observation;
use super::settings::SwingSettings;
use crate::signal::coherence::short_time;
use crate::signal::transform::{hann, median};

const SETTINGS: SwingSettings = SwingSettings::DEFAULT;

/// Standard deviation of the logarithm of the level over the parts of a recording, in the median over the recordings; `None` if it
/// is that of a steady machine.
pub fn swing(observations: &[Observation]) -> Option<f64> {
    let of = |o: &Observation| o.samples.iter().flatten().map(|s| unsteadiness(s)).fold(0.0, f64::max);
    let mut all: Vec<f64> = observations.iter().map(of).collect();
    median(&mut all).filter(|swing| *swing > SETTINGS.swing)
}

/// Standard deviation of the logarithm of the RMS of the differences over the parts of a signal.
fn unsteadiness(samples: &[f64]) -> f64 {
    let length = samples.len() / SETTINGS.parts;
    if length < 2 {
        return 0.0;
    }
    let level = |part: &[f64]| {
        let power = part.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum::<f64>() / (length - 1) as f64;
        0.5 * power.max(f64::MIN_POSITIVE).ln()
    };
    samples.chunks_exact(length).map(level).population_std_dev()
}

/// Whether the power of a band comes and goes in most recordings, as of a tone that sweeps through it: a mode rings all the time.
pub fn is_fleeting(observations: &[Observation], around_hz: f64, half_power_hz: f64) -> bool {
    let reach = SETTINGS.widths * half_power_hz;
    let of = |o: &Observation| {
        let fleeting =
            |samples: &Vec<f64>| fleeting(samples, [around_hz - reach, around_hz + reach], o.condition.sample_rate_hz);
        o.samples.iter().flatten().map(fleeting).fold(0.0, f64::max)
    };
    let mut all: Vec<f64> = observations.iter().map(of).collect();
    median(&mut all).is_some_and(|found| found > SETTINGS.fleeting)
}

/// Mean square of the short-time power of a band over the square of its mean at each frequency; 0 if the band is too narrow.
fn fleeting(samples: &[f64], [from_hz, to_hz]: [f64; 2], sample_rate_hz: f64) -> f64 {
    let window = samples.len() / SETTINGS.parts;
    if window < 2 {
        return 0.0;
    }
    let bin = |hz: f64| (hz.max(0.0) * window as f64 / sample_rate_hz).round() as usize;
    let rows = short_time(samples, &hann(window), (window / 2).max(1));
    let band = bin(from_hz).min(rows.len())..(bin(to_hz) + 1).min(rows.len());
    let ratio = |row: &Vec<Complex<f64>>| {
        let mean = row.iter().map(Complex::norm_sqr).mean();
        row.iter().map(|v| v.norm_sqr().powi(2)).mean() / (mean * mean).max(f64::MIN_POSITIVE)
    };
    if band.is_empty() { 0.0 } else { rows[band].iter().map(ratio).mean() }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    #[test]
    fn a_tone_that_sweeps_is_fleeting_and_noise_and_a_still_tone_are_not() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let noise: Vec<f64> = (0..25_600).map(|_| StandardNormal.sample(&mut random)).collect();
        let mut turn = 0.0;
        let mut tone = |hz: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let of = |(k, noise): (usize, &f64)| {
                turn += std::f64::consts::TAU * hz(k as f64 / 25_600.0) / 25_600.0;
                f64::sin(turn) + 0.01 * noise
            };
            noise.iter().enumerate().map(of).collect()
        };
        let of = |samples: &[f64]| fleeting(samples, [440.0, 560.0], 25_600.0);
        let sweeping = tone(&|time| 420.0 + 190.0 * time);
        assert!(of(&sweeping) > SETTINGS.fleeting, "{}", of(&sweeping));
        let still = tone(&|_| 500.0);
        for steady in [of(&noise), of(&still)] {
            assert!(steady < 2.2, "{steady}");
        }
    }

    #[test]
    fn a_swinging_level_is_unsteady_and_a_tone_is_not() {
        let signal = |swing: f64| -> Vec<f64> {
            let of = |n: i32| (1.0 + swing * (f64::from(n) * 2e-3).sin()) * (f64::from(n) * 0.7).sin();
            (0..8000).map(of).collect()
        };
        assert!(unsteadiness(&signal(0.0)) < 0.01 && unsteadiness(&signal(0.6)) > SETTINGS.swing);
        assert_eq!(unsteadiness(&[1.0, 2.0]), 0.0);
    }
}
