//! Whitened residual of recordings, and its lack of fit.

use realfft::num_complex::Complex;

use crate::identify::likelihood::observed::Observed;
use crate::identify::likelihood::whittle::{Prediction, judged_bins};
use crate::signal::transform::inverse_plan;

/// Bins of a band of the excess, and what n (m − 1 − ln m) is on average for the mean m of n of them, and its variance:
/// n (ln n − ψ(n)) and, by simulation, 0.522.
const FINE: usize = 8;
const FINE_MEAN: f64 = 0.5105;
const FINE_VARIANCE: f64 = 0.522;
/// Samples at each end of a recording that are excluded in the time domain.
pub const EDGE: usize = 128;
/// Standard deviations, and ln L of what stands out, from which a residual is not noise of the rig's kind.
const EXCESS: f64 = 6.0;
const PEAKS: f64 = 15.0;
/// How much more than one replicate's peaks those of the recordings may be.
const NOISE_PEAKS: f64 = 2.0;

/// Residual of one channel of one recording over the rig's standard deviation of it.
#[derive(Clone, Debug)]
pub struct Whitened {
    /// Index of the recording.
    pub recording: usize,
    /// Index of the channel.
    pub channel: usize,
    /// Fourier coefficients, E|w|² = 1 under the rig; the mean and the last are 0.
    pub spectrum: Vec<Complex<f64>>,
    /// Residual over time, of unit variance under the rig.
    pub signal: Vec<f64>,
    /// Samples per second.
    pub sample_rate_hz: f64,
}

/// Whitened residuals of all channels.
pub fn whitened(observed: &[Observed], expected: &[Prediction]) -> Vec<Whitened> {
    let mut out = Vec::new();
    for (recording, (o, e)) in observed.iter().zip(expected).enumerate() {
        for channel in 0..2 {
            let Some(x) = &o.spectra[channel] else { continue };
            let mut spectrum = vec![Complex::default(); x.len()];
            for k in judged_bins(x, 1.0) {
                spectrum[k] = (x[k] - e.mean[channel][k]) / e.noise.variance[channel][k].sqrt();
            }
            let inverse = inverse_plan(o.condition.samples);
            let (mut bins, mut signal) = (spectrum.clone(), inverse.make_output_vec());
            inverse.process(&mut bins, &mut signal).unwrap_or_default();
            signal.iter_mut().for_each(|v| *v /= (o.condition.samples as f64).sqrt());
            out.push(Whitened { recording, channel, spectrum, signal, sample_rate_hz: o.condition.sample_rate_hz });
        }
    }
    out
}

/// Absolute cosine similarity of two changes of the same residuals.
pub fn cosine_similarity(from: &[Whitened], one: &[Whitened], other: &[Whitened]) -> f64 {
    let (mut product, mut squares) = (0.0, [0.0; 2]);
    for ((from, one), other) in from.iter().zip(one).zip(other) {
        for ((from, one), other) in from.spectrum.iter().zip(&one.spectrum).zip(&other.spectrum) {
            let [one, other] = [one - from, other - from];
            product += (one.conj() * other).re;
            squares = [squares[0] + one.norm_sqr(), squares[1] + other.norm_sqr()];
        }
    }
    product.abs() / (squares[0] * squares[1]).sqrt().max(f64::MIN_POSITIVE)
}

/// Lack of fit: deviation of the residual from the rig's noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LackOfFit {
    /// Gain in ln L of a model with a free variance in every narrow band, and of one in every short time, less their gains
    /// on noise: sensitive to a broad lack of fit.
    pub nats: f64,
    /// Gain `nats` in standard deviations of its null distribution.
    pub z: f64,
    /// Gain in ln L of the bands and times that are significant one by one: sensitive to a local lack of fit.
    pub peaks: f64,
}

impl LackOfFit {
    /// Whether the lack of fit is significant.
    pub fn is_more_than_chance(&self) -> bool {
        self.z > EXCESS || self.peaks > PEAKS
    }

    /// Mean of several.
    pub fn mean(all: &[Self]) -> Self {
        let mean = |of: fn(&Self) -> f64| all.iter().map(of).sum::<f64>() / all.len().max(1) as f64;
        Self { nats: mean(|e| e.nats), z: mean(|e| e.z), peaks: mean(|e| e.peaks) }
    }

    /// Lack of fit beyond that of the rig's own noise.
    pub fn beyond(self, noise: Self) -> Self {
        Self {
            nats: self.nats - noise.nats.max(0.0),
            z: self.z - noise.z.max(0.0),
            peaks: self.peaks - NOISE_PEAKS * noise.peaks,
        }
    }

    /// Explained share, given the remaining lack of fit `left`.
    pub fn explained(&self, left: &Self) -> f64 {
        let (all, left) = if self.z > EXCESS { (self.nats, left.nats) } else { (self.peaks, left.peaks) };
        if all > 0.0 { 1.0 - left.max(0.0) / all } else { 1.0 }
    }
}

/// Signal without its ends, where its Fourier series has a jump.
pub fn inner(signal: &[f64]) -> &[f64] {
    signal.get(EDGE..signal.len().saturating_sub(EDGE)).unwrap_or_default()
}

/// Lack of fit of all channels together.
pub fn lack_of_fit(residuals: &[Whitened]) -> LackOfFit {
    let mut gains = Vec::new();
    for w in residuals {
        gains.extend(w.spectrum[judged_bins(&w.spectrum, 1.0)].chunks_exact(FINE).map(|band| gain(mean_square(band))));
        // Half as many degrees of freedom to a real number: n (m − 1 − ln m) with n half the samples.
        let mean = |block: &[f64]| block.iter().map(|v| v * v).sum::<f64>() / block.len() as f64;
        gains.extend(inner(&w.signal).chunks_exact(2 * FINE).map(|block| gain(mean(block))));
    }
    let count = gains.len().max(1) as f64;
    let nats = gains.iter().sum::<f64>() - FINE_MEAN * gains.len() as f64;
    // By chance one of all goes beyond ln(count).
    let peaks = gains.iter().map(|g| (g - count.ln() - 2.0).max(0.0)).sum();
    LackOfFit { nats, z: nats / (FINE_VARIANCE * count).sqrt(), peaks }
}

/// What a free variance gains in ln L where the mean square of [`FINE`] numbers is `m`.
fn gain(m: f64) -> f64 {
    FINE as f64 * (m - 1.0 - m.max(1e-12).ln())
}

fn mean_square(bins: &[Complex<f64>]) -> f64 {
    bins.iter().map(|w| w.norm_sqr()).sum::<f64>() / bins.len().max(1) as f64
}

#[cfg(test)]
mod tests_of_residuals {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn noise(seed: u64, gain: impl Fn(usize) -> f64) -> Whitened {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut unit = || -> f64 { StandardNormal.sample(&mut rng) };
        let half = 0.5f64.sqrt();
        let spectrum: Vec<_> = (0..4097).map(|k| Complex::new(unit() * half, unit() * half) * gain(k)).collect();
        let signal = (0..8192).map(|_| unit()).collect();
        Whitened { recording: 0, channel: 1, spectrum, signal, sample_rate_hz: 8192.0 }
    }

    #[test]
    fn changes_of_the_same_bands_are_alike_and_of_others_are_not() {
        let from = noise(1, |_| 1.0);
        let changed = |bins: std::ops::Range<usize>, by: f64| {
            let mut spectrum = from.spectrum.clone();
            spectrum[bins].iter_mut().for_each(|x| *x += by);
            [Whitened { spectrum, ..from.clone() }]
        };
        let like =
            |one: [Whitened; 1], other: [Whitened; 1]| cosine_similarity(std::slice::from_ref(&from), &one, &other);
        assert!((like(changed(100..200, 1.0), changed(100..200, -3.0)) - 1.0).abs() < 1e-9);
        assert!((like(changed(100..200, 1.0), changed(150..250, 1.0)) - 0.5).abs() < 1e-9);
        assert!(like(changed(100..200, 1.0), changed(300..400, 1.0)) < 1e-9);
    }

    #[test]
    fn null_noise_has_no_excess() {
        let z: Vec<f64> = (0..40).map(|seed| lack_of_fit(&[noise(seed, |_| 1.0)]).z).collect();
        let mean = z.iter().sum::<f64>() / 40.0;
        let square = z.iter().map(|d| d * d).sum::<f64>() / 40.0;
        assert!(mean.abs() < 0.5 && (0.5..1.6).contains(&square), "{mean} {square}");
    }

    #[test]
    fn a_band_with_twice_the_power_stands_out() {
        let w = noise(1, |k| if (1000..1400).contains(&k) { 2.0f64.sqrt() } else { 1.0 });
        assert!(lack_of_fit(std::slice::from_ref(&w)).z > 4.0);
    }

    #[test]
    fn a_line_shows_though_it_is_nothing_in_all() {
        let plain = lack_of_fit(&[noise(1, |_| 1.0)]);
        assert!(plain.peaks < 1.0 && !plain.is_more_than_chance(), "{plain:?}");
        let mut line = noise(1, |_| 1.0);
        line.spectrum[1200] = Complex::new(9.0, 0.0);
        let line = lack_of_fit(&[line]);
        assert!(line.z < EXCESS && line.peaks > PEAKS && line.is_more_than_chance(), "{line:?}");
    }
}
