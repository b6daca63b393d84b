//! Identification of the structure between rig and sensor.

use realfft::num_complex::Complex;

use crate::identify::likelihood::observed::{CHANNELS, accelerations};
use crate::recording::Recording;
use crate::rig::transfer_path::TransmissionPath;
use crate::signal::spectrum::{Spectrum, welch};
use crate::signal::transform::{forward_plan, inverse_plan};

/// Samples in a segment of the densities.
const SEGMENT: usize = 2048;
/// Numbers of poles that are tried.
const POLES: [usize; 10] = [2, 4, 8, 12, 16, 24, 32, 48, 64, 96];

/// The path of each channel that was measured: that which takes the density of `simulated` to the density of `measured`.
/// The number of poles is chosen on the second half of the measured recordings, with the filter from the first, and the
/// filter then taken from all.
pub fn identify(measured: &[Recording], simulated: &[Recording]) -> Vec<TransmissionPath> {
    (0..2).filter_map(|channel| of_channel(measured, simulated, channel)).collect()
}

fn of_channel(measured: &[Recording], simulated: &[Recording], channel: usize) -> Option<TransmissionPath> {
    let rate = measured.first()?.sample_rate_hz;
    let (measured, simulated) = (signals(measured, channel), signals(simulated, channel));
    let shortest = measured.iter().map(|s| s.len()).min()?;
    let segment = SEGMENT.min(shortest / 2);
    let density = |signals: &[&[f64]]| welch(signals, rate, segment);
    let rig = density(&simulated)?;
    let half = |from: usize| -> Vec<&[f64]> {
        measured.iter().map(|s| if from == 0 { &s[..s.len() / 2] } else { &s[s.len() / 2..] }).collect()
    };
    let (first, second) = (density(&half(0))?, density(&half(1))?);
    let ratio =
        |of: &Spectrum| -> Vec<f64> { of.values.iter().zip(&rig.values).map(|(p, q)| p / q.max(1e-300)).collect() };
    let (first, second) = (ratio(&first), ratio(&second));
    let filter =
        |power: &[f64], poles| TransmissionPath::of_power(CHANNELS[channel], rate, &smoothed(power, poles), poles);
    let neg_log_likelihood = |poles: &usize| -> f64 {
        let h = filter(&first, *poles).power(segment);
        second.iter().zip(&h).skip(1).map(|(r, h)| (r / h).ln().powi(2)).sum()
    };
    let poles = POLES
        .into_iter()
        .filter(|p| 4 * p < segment)
        .min_by(|a, b| neg_log_likelihood(a).total_cmp(&neg_log_likelihood(b)))?;
    let all: Vec<f64> = first.iter().zip(&second).map(|(a, b)| 0.5 * (a + b)).collect();
    Some(filter(&all, poles))
}

fn signals(recordings: &[Recording], channel: usize) -> Vec<&[f64]> {
    recordings.iter().filter_map(|r| accelerations(r)[channel]).map(|c| c.samples.as_slice()).collect()
}

/// The power whose logarithm has no finer structure than as many cosines: what is left of lines, which are the machine's
/// turning and not its structure, is their mean in decibels (cepstral smoothing; A. V. Oppenheim, R. W. Schafer,
/// "Discrete-Time Signal Processing", chapter 13).
fn smoothed(power: &[f64], cosines: usize) -> Vec<f64> {
    let length = 2 * (power.len() - 1);
    let (inverse, forward) = (inverse_plan(length), forward_plan(length));
    let mut log: Vec<Complex<f64>> = power.iter().map(|p| Complex::new(p.max(f64::MIN_POSITIVE).ln(), 0.0)).collect();
    // The mean was taken out before, so that nothing is known of the lowest bin; it is as its neighbour.
    log[0] = log[1];
    let mut cepstrum = inverse.make_output_vec();
    inverse.process(&mut log, &mut cepstrum).unwrap_or_default();
    for (k, value) in cepstrum.iter_mut().enumerate() {
        let kept = k <= cosines || k >= length - cosines;
        *value = if kept { *value / length as f64 } else { 0.0 };
    }
    let mut smooth = forward.make_output_vec();
    forward.process(&mut cepstrum, &mut smooth).unwrap_or_default();
    smooth.iter().map(|v| v.re.exp()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smoothing_keeps_what_is_smooth_and_levels_a_line() {
        let slow = |k: usize| (2.0 * (std::f64::consts::PI * k as f64 / 256.0).cos()).exp();
        let mut power: Vec<f64> = (0..=256).map(slow).collect();
        power[100] *= 1e4;
        let smooth = smoothed(&power, 8);
        assert!((smooth[200] / slow(200)).ln().abs() < 0.1, "{}", smooth[200] / slow(200));
        // The line's ln 1e4 = 9.2 is spread over 512/17 bins.
        assert!((smooth[100] / slow(100)).ln() < 0.7, "{}", smooth[100] / slow(100));
    }
}
