//! The band whose squared envelope shows given lines best, theory (75).
//!
//! Kurtosis measures impulsiveness, and one shock decides it. A fault modulates the power at its own rate, which
//! second-order cyclostationarity measures: lines of the squared envelope's spectrum over its mean (ICS2: A. Raad, J.
//! Antoni, M. Sidahmed, Mechanical Systems and Signal Processing 22 (2008) 574–587), here each line over the noise
//! around it. As in J. Antoni, "The infogram", Mechanical Systems and Signal Processing 74 (2016) 73–94, the band must
//! exceed what noise gives.

use std::ops::Range;

use rayon::prelude::*;
use realfft::num_complex::Complex;

use super::Sample;
use super::kurtogram::Bank;
use super::lines::{floor, half_width};
use super::settings::BandSettings;
use super::spectrum::{Spectrum, amplitudes};

const SETTINGS: BandSettings = BandSettings::DEFAULT;

/// Band that shows given lines best.
#[derive(Clone, Debug, PartialEq)]
pub struct LineBand {
    /// Level in the kurtogram's tree.
    pub level: f64,
    /// Edges of the band, Hz.
    pub band_hz: Range<f64>,
    /// Common factor from the requested frequencies to those found.
    pub scale: f64,
    /// Mean over the lines of power over the noise around.
    pub strength: f64,
    /// ln of the p-value over all bands and factors tried.
    pub log_p_value: f64,
    /// Power over the noise around of each requested line, in their order; 0 beyond the spectrum.
    pub ratios: Vec<f64>,
}

/// Band of the kurtogram's tree whose squared envelope shows `lines_hz` with the least p-value, theory (75), over
/// common factors within `1 ± tolerance`: balls slip by a percent or so.
///
/// Only bands that can show all the lines and whose middle is above them: in a band of a few shaft harmonics, their
/// beats are lines without impacts. `None` for no lines, or a recording too short for a band.
pub fn band_for_lines<S: Sample>(
    samples: &[S],
    sample_rate_hz: f64,
    lines_hz: &[f64],
    tolerance: f64,
) -> Option<LineBand> {
    let highest = lines_hz.iter().copied().max_by(f64::total_cmp).filter(|f| *f > 0.0)?;
    let bank = Bank::new(samples, sample_rate_hz)?;
    let step_hz = 1.0 / bank.counted_s();
    let steps = (tolerance * highest / (SETTINGS.scale_step * step_hz)).ceil() as i32;
    let scales: Vec<f64> = (-steps..=steps).map(|k| 1.0 + tolerance * f64::from(k) / f64::from(steps.max(1))).collect();
    let mut tree = bank.tree(highest * (1.0 + tolerance) / SETTINGS.usable_share);
    tree.retain(|(_, band)| 0.5 * (band.start + band.end) > highest);
    let trials = (tree.len() * scales.len()) as f64;
    let bands = tree.into_par_iter().filter_map(|(level, band_hz)| {
        let spectrum = squared_envelope(&bank, &band_hz)?;
        let powers: Vec<f64> = spectrum.values.iter().map(|v| v * v).collect();
        let floor = floor(&powers, half_width(spectrum.step_hz));
        let seen = SETTINGS.usable_share * (band_hz.end - band_hz.start);
        let ratio = |f: f64| {
            let at = (f / spectrum.step_hz).round() as usize;
            if f > seen || floor.get(at).is_none_or(|v| *v <= 0.0) { 0.0 } else { powers[at] / floor[at] }
        };
        let sum = |scale: f64| lines_hz.iter().map(|f| ratio(f * scale)).sum::<f64>();
        let scale = scales.iter().copied().max_by(|a, b| sum(*a).total_cmp(&sum(*b)))?;
        let ratios: Vec<f64> = lines_hz.iter().map(|f| ratio(f * scale)).collect();
        let shown = lines_hz.iter().filter(|f| **f * scale <= seen).count();
        let log_p_value = (log_gamma_tail(shown, sum(scale)) + trials.ln()).min(0.0);
        Some(LineBand { level, band_hz, scale, strength: sum(scale) / shown.max(1) as f64, log_p_value, ratios })
    });
    // Ties, at p = 1, go to the widest.
    bands.min_by(|a, b| a.log_p_value.total_cmp(&b.log_p_value).then(a.level.total_cmp(&b.level)))
}

/// Amplitude spectrum of a band's squared envelope, without the recording's ends.
pub(super) fn squared_envelope(bank: &Bank, band_hz: &Range<f64>) -> Option<Spectrum> {
    let envelope = bank.envelope(band_hz, 2);
    let squares: Vec<f64> = envelope.counted().iter().map(Complex::norm_sqr).collect();
    amplitudes(&[&squares], envelope.rate_hz)
}

/// ln of the probability that `count` exponential values of mean 1 sum to more than `sum` (Erlang's distribution).
fn log_gamma_tail(count: usize, sum: f64) -> f64 {
    let mut term = 1.0;
    let mut total = 0.0;
    // Σ_{i<count} sumⁱ/i!, scaled by the last term's size where it would overflow.
    let mut log_scale = 0.0;
    for i in 0..count {
        total += term;
        term *= sum / (i + 1) as f64;
        if term > 1e200 {
            (term, total, log_scale) = (term * 1e-200, total * 1e-200, log_scale + 200.0 * std::f64::consts::LN_10);
        }
    }
    if count == 0 { 0.0 } else { (total.ln() + log_scale - sum).min(0.0) }
}

#[cfg(test)]
mod tests {
    use super::super::kurtogram::kurtogram;
    use super::super::test_signals::{gaussian, impacts};
    use super::*;

    const RATE: f64 = 12_000.0;
    const LINES: [f64; 3] = [97.0, 194.0, 291.0];

    #[test]
    fn literature_the_tail_of_erlangs_distribution() {
        // χ² of 10 degrees of freedom beyond 18.307: 0.05. And one value: e⁻ˣ.
        assert!((log_gamma_tail(5, 18.307 / 2.0).exp() - 0.05).abs() < 1e-5);
        assert!((log_gamma_tail(1, 700.0) + 700.0).abs() < 1e-9);
        assert!(log_gamma_tail(40, 5000.0) < -4700.0);
    }

    #[test]
    fn one_shock_deceives_kurtosis_but_not_the_lines() {
        let mut samples: Vec<f64> = impacts(24_000, RATE, 97.3, 4600.0, 200.0)
            .iter()
            .zip(gaussian(24_000, 5))
            .map(|(a, b)| 0.6 * a + b)
            .collect();
        let shock = impacts(300, RATE, 1.0, 1500.0, 100.0);
        samples[9000..9300].iter_mut().zip(shock).for_each(|(v, s)| *v += 40.0 * s);
        let kurtosis = kurtogram(&samples, RATE, 300.0).unwrap();
        assert!(kurtosis.best().unwrap().centre_hz < 2500.0, "{:?}", kurtosis.best());
        let lines = band_for_lines(&samples, RATE, &LINES, 0.01).unwrap();
        assert!(lines.band_hz.contains(&4600.0), "{lines:?}");
        assert!(lines.log_p_value < -20.0 && (lines.scale - 97.3 / 97.0).abs() < 2e-3, "{lines:?}");
    }

    #[test]
    fn null_noise_gives_even_probabilities_at_most() {
        let p = |seed| band_for_lines(&gaussian(12_000, seed), RATE, &LINES, 0.01).unwrap().log_p_value.exp();
        let p: Vec<f64> = (0..60).map(p).collect();
        assert!(p.iter().filter(|p| **p < 0.05).count() <= 7, "{p:?}");
        assert_eq!(band_for_lines(&gaussian(12_000, 0), RATE, &[], 0.01), None);
    }
}
