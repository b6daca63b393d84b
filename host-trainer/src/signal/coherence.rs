//! Cyclic spectral coherence, theory (76): strength of the power's modulation over carrier and cyclic frequency.
//!
//! The fast spectral correlation of J. Antoni, G. Xin, N. Hamzaoui, "Fast computation of the spectral correlation",
//! Mechanical Systems and Signal Processing 92 (2017) 248–277: products of short-time spectra p frequency steps apart
//! are transformed along time, and the scans p = 0…P are added and divided by the window's own response, so that
//! rates far beyond the frequency resolution are reached. The coherence is the correlation of the whitened recording.
//! Its square, averaged over frequency, is the enhanced envelope spectrum (same paper).

use std::f64::consts::TAU;
use std::ops::Range;

use rayon::prelude::*;
use realfft::num_complex::Complex;

use super::Sample;
use super::settings::CoherenceSettings;
use super::spectrum::Spectrum;
use super::transform::{forward, forward_plan, hann};

const SETTINGS: CoherenceSettings = CoherenceSettings::DEFAULT;

/// Squared magnitude of the cyclic coherence.
#[derive(Clone, Debug, PartialEq)]
pub struct Coherence {
    /// Step of the cyclic frequency from 0, Hz.
    pub cyclic_step_hz: f64,
    /// Step of the carrier frequency from 0, Hz.
    pub step_hz: f64,
    /// |γ|², 0…1: for each carrier frequency a row over the cyclic frequencies.
    pub squares: Vec<Vec<f64>>,
}

impl Coherence {
    /// Enhanced envelope spectrum: mean of |γ|² over the carriers in a band. The value at 0 Hz is set to 0.
    pub fn enhanced_envelope_spectrum(&self, band_hz: &Range<f64>) -> Spectrum {
        let inside = |k: &usize| band_hz.contains(&(*k as f64 * self.step_hz));
        let rows: Vec<&Vec<f64>> = (0..self.squares.len()).filter(inside).map(|k| &self.squares[k]).collect();
        let length = rows.first().map_or(0, |row| row.len());
        let mean = |a: usize| rows.iter().map(|row| row[a]).sum::<f64>() / rows.len() as f64;
        let values = (0..length).map(|a| if a == 0 { 0.0 } else { mean(a) }).collect();
        Spectrum { step_hz: self.cyclic_step_hz, values }
    }
}

/// Coherence of a recording, theory (76), over carriers 0…Nyquist's frequency from windows of `window` samples, and
/// cyclic frequencies up to `highest_hz`.
///
/// `None` if the window is under 16 samples, the recording shorter than eight windows, or `highest_hz` beyond a
/// quarter of the rate.
pub fn coherence<S: Sample>(samples: &[S], sample_rate_hz: f64, window: usize, highest_hz: f64) -> Option<Coherence> {
    if window < 16 || samples.len() < 8 * window || !(highest_hz > 0.0 && highest_hz <= 0.25 * sample_rate_hz) {
        return None;
    }
    // Twice the rate that `highest_hz` needs: products of neighbouring steps reach beyond it.
    let hop = ((0.25 * sample_rate_hz / highest_hz) as usize).clamp(1, window / SETTINGS.overlap);
    let shape = hann(window);
    let mut spectra = short_time(samples, &shape, hop);
    spectra.iter_mut().for_each(|row| whiten(row));
    let frames = spectra.first()?.len();
    let step_hz = sample_rate_hz / window as f64;
    let cyclic_step_hz = sample_rate_hz / (hop * frames) as f64;
    let count = (highest_hz / cyclic_step_hz) as usize + 1;
    let scans = (highest_hz / step_hz) as usize + 1;
    let response = |cyclic_hz: f64| {
        let angle = TAU * cyclic_hz / sample_rate_hz;
        let middle = window as f64 / 2.0;
        shape.iter().enumerate().map(|(n, w)| w * w * (angle * (n as f64 - middle)).cos()).sum::<f64>()
    };
    let whole = response(0.0);
    let gains: Vec<f64> = (0..count)
        .map(|a| a as f64 * cyclic_step_hz)
        .map(|f| whole / (0..=scans).map(|p| response(f - p as f64 * step_hz)).sum::<f64>())
        .collect();
    // Without the window a rate between two bins loses up to 36 % of its amplitude.
    let along: Vec<f64> = hann(frames).iter().map(|w| 2.0 * w / frames as f64).collect();
    let squares = (0..spectra.len()).into_par_iter().map(|k| {
        let mut sum = vec![Complex::ZERO; count];
        for p in 0..=scans.min(k) {
            let products = spectra[k].iter().zip(&spectra[k - p]).map(|(a, b)| a * b.conj());
            let scan = transform_along_time(products.zip(&along).map(|(v, w)| v * w), frames);
            sum.iter_mut().zip(scan).for_each(|(s, v)| *s += v);
        }
        sum.iter().zip(&gains).map(|(s, g)| (s * g).norm_sqr().min(1.0)).collect()
    });
    Some(Coherence { cyclic_step_hz, step_hz, squares: squares.collect() })
}

/// Short-time spectra, a row over time for each frequency; phases count from the middle of the window.
pub fn short_time<S: Sample>(samples: &[S], shape: &[f64], hop: usize) -> Vec<Vec<Complex<f64>>> {
    let window = shape.len();
    let mean = samples.iter().map(|v| (*v).into()).sum::<f64>() / samples.len() as f64;
    let transform = forward_plan(window);
    let mut bins = transform.make_output_vec();
    let frames = (samples.len() - window) / hop + 1;
    let mut out = vec![Vec::with_capacity(frames); bins.len()];
    for frame in samples.windows(window).step_by(hop) {
        let mut shaped: Vec<f64> = frame.iter().zip(shape).map(|(v, w)| ((*v).into() - mean) * w).collect();
        transform.process(&mut shaped, &mut bins).expect("buffers are the plan's own");
        for (k, (row, bin)) in out.iter_mut().zip(&bins).enumerate() {
            // exp(πik) moves the origin to the middle of a window of even length.
            let phase =
                Complex::from_polar(1.0, std::f64::consts::PI * k as f64 * (window / 2 * 2) as f64 / window as f64);
            row.push(bin * phase);
        }
    }
    out
}

/// Scales a row to mean power 1; a row of zeros stays.
fn whiten(row: &mut [Complex<f64>]) {
    let power = row.iter().map(Complex::norm_sqr).sum::<f64>() / row.len().max(1) as f64;
    if power > 0.0 {
        row.iter_mut().for_each(|v| *v /= power.sqrt());
    }
}

/// Bins 0 to n/2 of a complex series.
fn transform_along_time(values: impl Iterator<Item = Complex<f64>>, count: usize) -> Vec<Complex<f64>> {
    let (mut re, mut im) = (Vec::with_capacity(count), Vec::with_capacity(count));
    values.for_each(|v| {
        re.push(v.re);
        im.push(v.im);
    });
    let turned = Complex::new(0.0, 1.0);
    forward(&mut re).iter().zip(forward(&mut im)).map(|(a, b)| a + turned * b).collect()
}

#[cfg(test)]
mod tests {
    use super::super::test_signals::gaussian;
    use super::*;

    const RATE: f64 = 12_000.0;

    /// White noise whose amplitude is modulated: the coherence is known in closed form.
    #[test]
    fn literature_modulated_noise_has_the_coherence_of_its_modulation() {
        // (1 + m cos αt) noise: power 1 + m²/2 + 2m cos αt/… ; γ at α is m/(1 + m²/2), at 2α m²/4/(1 + m²/2).
        let (m, rate) = (0.8, 250.0);
        let samples: Vec<f64> = gaussian(240_000, 1)
            .iter()
            .enumerate()
            .map(|(i, v)| v * (1.0 + m * (TAU * rate * i as f64 / RATE).cos()))
            .collect();
        let found = coherence(&samples, RATE, 128, 600.0).unwrap().enhanced_envelope_spectrum(&(1000.0..5000.0));
        let at = |f: f64| {
            let k = (f / found.step_hz).round() as usize;
            found.values[k - 1..=k + 1].iter().fold(0.0, |a: f64, b| a.max(*b)).sqrt()
        };
        let power = 1.0 + 0.5 * m * m;
        assert!((at(rate) - m / power).abs() < 0.06, "{} {}", at(rate), m / power);
        assert!((at(2.0 * rate) - 0.25 * m * m / power).abs() < 0.06, "{}", at(2.0 * rate));
        let elsewhere = found.points().filter(|(f, _)| *f > 5.0 && (f / rate - (f / rate).round()).abs() > 0.02);
        assert!(elsewhere.map(|(_, v)| v).fold(0.0, f64::max).sqrt() < 0.1);
    }

    #[test]
    fn null_stationary_noise_has_none() {
        // Coloured: the whitening must not make any.
        let noise = gaussian(60_000, 3);
        let samples: Vec<f64> = noise.windows(3).map(|w| w[0] + 1.6 * w[1] + 0.8 * w[2]).collect();
        let found = coherence(&samples, RATE, 128, 300.0).unwrap().enhanced_envelope_spectrum(&(0.0..6000.0));
        let most = found.points().skip(4).map(|(_, v)| v).fold(0.0, f64::max);
        assert!(most < 0.02, "{most}");
    }
}
