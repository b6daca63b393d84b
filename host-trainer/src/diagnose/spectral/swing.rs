//! Swing: a level that rises and falls within a recording, as of a loose connector. A power spectrum has no time and shows little
//! of it.

use statrs::statistics::Statistics;

use super::observation::Observation;
use super::settings::SwingSettings;
use crate::signal::transform::median;

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

#[cfg(test)]
mod tests {
    use super::*;

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
