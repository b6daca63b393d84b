//! Identification of the structure between rig and sensor, theory (53).

use realfft::num_complex::Complex;

use super::settings::CalibrationSettings;
use crate::identify::likelihood::observed::{CHANNELS, accelerations};
use crate::recording::Recording;
use crate::rig::transfer_path::TransmissionPath;
use crate::signal::spectrum::{Spectrum, welch};
use crate::signal::transform::{forward_plan, inverse_plan};

const SETTINGS: CalibrationSettings = CalibrationSettings::DEFAULT;

/// Transmission path of each measured channel, from the density of `simulated` to the density of `measured`. The number of
/// poles is chosen on the second halves of the measured recordings, with the filter from the first halves; the filter
/// returned is fitted to both.
pub fn identify(measured: &[Recording], simulated: &[Recording]) -> Vec<TransmissionPath> {
    (0..2).filter_map(|channel| of_channel(measured, simulated, channel)).collect()
}

fn of_channel(measured: &[Recording], simulated: &[Recording], channel: usize) -> Option<TransmissionPath> {
    let rate = measured.first()?.sample_rate_hz;
    let (measured, simulated) = (signals(measured, channel), signals(simulated, channel));
    let shortest = measured.iter().map(|s| s.len()).min()?;
    let segment = SETTINGS.segment.min(shortest / 2);
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
    let poles = SETTINGS
        .path_poles
        .into_iter()
        .filter(|p| 4 * p < segment)
        .min_by(|a, b| neg_log_likelihood(a).total_cmp(&neg_log_likelihood(b)))?;
    let all: Vec<f64> = first.iter().zip(&second).map(|(a, b)| 0.5 * (a + b)).collect();
    Some(filter(&all, poles))
}

fn signals(recordings: &[Recording], channel: usize) -> Vec<&[f64]> {
    recordings.iter().filter_map(|r| accelerations(r)[channel]).map(|c| c.samples.as_slice()).collect()
}

/// Power smoothed in the cepstrum to as many cosines (A. V. Oppenheim, R. W. Schafer, "Discrete-Time Signal Processing",
/// chapter 13): lines, which come from the machine's rotation and not its structure, are levelled.
fn smoothed(power: &[f64], cosines: usize) -> Vec<f64> {
    let length = 2 * (power.len() - 1);
    let (inverse, forward) = (inverse_plan(length), forward_plan(length));
    let mut log: Vec<Complex<f64>> = power.iter().map(|p| Complex::new(p.max(f64::MIN_POSITIVE).ln(), 0.0)).collect();
    // The mean was removed before, so that the lowest bin takes its neighbour's value.
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
