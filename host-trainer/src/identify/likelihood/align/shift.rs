//! Shifts of a prediction in time against a recording.

use realfft::num_complex::Complex;

use crate::identify::likelihood::observed::Observed;
use crate::identify::likelihood::whittle::judged_bins;
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
