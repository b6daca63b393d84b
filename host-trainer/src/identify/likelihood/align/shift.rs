//! Shifts of a prediction in time against a recording.

use std::f64::consts::TAU;

use realfft::num_complex::Complex;

use super::{SETTINGS, cage_per_shaft, reading};
use crate::identify::likelihood::observed::{Coefficients, Observed};
use crate::identify::likelihood::whittle::judged_bins;
use crate::rig::Rig;
use crate::signal::transform::inverse_plan;

/// Correlation of one signal, made of the recording's coefficients, with another that is moved ahead by each lag, in
/// samples: the part of ln L that depends on the lag, over the bins of [`judged_bins`].
pub fn correlation(
    o: &Observed,
    variance: &[Vec<f64>; 2],
    one: impl Fn(usize, usize, Complex<f64>) -> Complex<f64>,
    other: impl Fn(usize, usize) -> Complex<f64>,
) -> Vec<f64> {
    let samples = o.condition.samples;
    let mut together = vec![Complex::<f64>::default(); samples / 2 + 1];
    for (channel, (spectrum, variance)) in o.spectra.iter().zip(variance).enumerate() {
        let Some(spectrum) = spectrum else { continue };
        for k in judged_bins(spectrum, 1.0) {
            together[k] += one(channel, k, spectrum[k]).conj() * other(channel, k) / variance[k];
        }
    }
    let inverse = inverse_plan(samples);
    let mut correlation = inverse.make_output_vec();
    inverse.process(&mut together, &mut correlation).unwrap_or_default();
    correlation
}

/// Lag in samples, half a ball pass at most, by which a prediction suits a recording best: where an effect changes the
/// balls' passing, angles that were found without it lag or lead.
pub fn lag(rig: &Rig, o: &Observed, variance: &[Vec<f64>; 2], mean: &[Coefficients; 2]) -> i64 {
    let orders = rig.bearing().map(|machine| machine.bearing.geometry().orders());
    let passes_hz = o.condition.shaft_hz * orders.map_or(1.0, |orders| orders.bpfo);
    let reach = (0.5 * o.condition.sample_rate_hz / passes_hz.max(1.0)) as usize;
    let samples = o.condition.samples;
    let correlation = correlation(o, variance, |_, _, x| x, |c, k| mean[c][k]);
    let reach = reach.min(samples / 4) as i64;
    let at = |lag: i64| correlation[lag.rem_euclid(samples as i64) as usize];
    let lag = (-reach..=reach).max_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap_or_default();
    if at(lag) - at(0) < SETTINGS.min_move_gain { 0 } else { lag }
}

/// Angles moved by a lag; the shaft's stays if a tachometer gives it.
pub fn moved_angles(rig: &Rig, o: &Observed, lag: i64, [cage, shaft]: [f64; 2]) -> [f64; 2] {
    let turned = TAU * o.condition.shaft_hz * lag as f64 / o.condition.sample_rate_hz;
    let shaft = if reading(rig, o).is_some() { shaft } else { shaft + turned };
    [cage + cage_per_shaft(rig) * turned, shaft]
}

/// Prediction of a recording, moved by a lag.
pub fn moved_mean(o: &Observed, lag: i64, mean: &[Coefficients; 2]) -> [Coefficients; 2] {
    let step = Complex::from_polar(1.0, TAU * lag as f64 / o.condition.samples as f64);
    let turn = |mean: &Coefficients| {
        let mut by = Complex::new(1.0, 0.0);
        let turned = mean.iter().map(|d| {
            let turned = d * by;
            by *= step;
            turned
        });
        turned.collect()
    };
    [turn(&mean[0]), turn(&mean[1])]
}
