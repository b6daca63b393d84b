//! Fast kurtogram, theory (73): the band that holds the impacts.
//!
//! J. Antoni, "Fast computation of the kurtogram for the detection of transient faults", Mechanical Systems and
//! Signal Processing 21 (2007) 108–124. The tree of bands is his 1/3-binary one: level k cuts 0…Nyquist into 2^k
//! bands, level k + 0.6 into 3·2^(k−1). His cascade of short filters is replaced by one Fourier transform, from
//! which each band is cut with raised-cosine flanks: the same cost, no drift of the bands' edges with the depth.
//!
//! Known weakness: one strong shock has a greater kurtosis than a train of weak impacts. For known fault frequencies
//! use [`band_for_lines`](super::band::band_for_lines).

use std::ops::Range;

use rayon::prelude::*;
use realfft::num_complex::Complex;

use super::Sample;
use super::settings::KurtogramSettings;
use super::transform::{forward, inverse_complex};

const SETTINGS: KurtogramSettings = KurtogramSettings::DEFAULT;

/// A band of the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Level: logarithm to base 2 of the number of bands, k for 2^k, k + 0.585 for 3·2^(k−1).
    pub level: f64,
    /// Middle of the band, Hz.
    pub centre_hz: f64,
    /// Width of the band, Hz.
    pub bandwidth_hz: f64,
    /// Kurtosis ⟨|c|⁴⟩/⟨|c|²⟩² − 2 of the complex envelope c: 0 for stationary Gaussian noise, −1 for a tone.
    pub kurtosis: f64,
    /// Independent samples of the envelope, width times duration.
    pub samples: f64,
}

impl Cell {
    /// Edges of the band, Hz.
    pub fn band_hz(&self) -> Range<f64> {
        self.centre_hz - 0.5 * self.bandwidth_hz..self.centre_hz + 0.5 * self.bandwidth_hz
    }

    /// Kurtosis over its standard deviation for Gaussian noise, 2/√n for n independent samples.
    pub fn significance(&self) -> f64 {
        0.5 * self.kurtosis * self.samples.sqrt()
    }
}

/// Kurtosis of each band of the tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Kurtogram {
    /// Cells by level, within a level from 0 Hz up.
    pub cells: Vec<Cell>,
    /// Nyquist's frequency, Hz.
    pub nyquist_hz: f64,
}

/// Significance above which a band is not noise: `KurtogramSettings::significance_bound`.
pub const NOISE_BOUND: f64 = SETTINGS.significance_bound;

impl Kurtogram {
    /// Band of greatest kurtosis among those beyond [`NOISE_BOUND`], if any.
    pub fn best(&self) -> Option<&Cell> {
        let beyond = self.cells.iter().filter(|c| c.significance() > NOISE_BOUND);
        beyond.max_by(|a, b| a.kurtosis.total_cmp(&b.kurtosis))
    }
}

/// Kurtogram of a recording, theory (73), in bands of at least `min_bandwidth_hz` (twice the fastest repetition to be
/// resolved, say) and at least 64 independent samples.
///
/// `None` for a recording of fewer.
pub fn kurtogram<S: Sample>(samples: &[S], sample_rate_hz: f64, min_bandwidth_hz: f64) -> Option<Kurtogram> {
    kurtogram_of_pieces(&[samples], sample_rate_hz, min_bandwidth_hz)
}

/// Kurtogram of a recording in pieces of one length, as [`kurtogram`]: the moments are those of all pieces.
pub fn kurtogram_of_pieces<S: Sample>(
    pieces: &[&[S]],
    sample_rate_hz: f64,
    min_bandwidth_hz: f64,
) -> Option<Kurtogram> {
    let mut tree = Vec::new();
    let mut moments: Vec<[f64; 3]> = Vec::new();
    let mut counted_s = 0.0;
    for piece in pieces {
        let bank = Bank::new(piece, sample_rate_hz)?;
        tree = bank.tree(min_bandwidth_hz);
        counted_s += bank.counted_s();
        let of_piece = tree.par_iter().map(|(_, band)| {
            let envelope = bank.envelope(band, 1);
            let add = |[second, fourth, n]: [f64; 3], power: f64| [second + power, fourth + power * power, n + 1.0];
            envelope.counted().iter().map(Complex::norm_sqr).fold([0.0; 3], add)
        });
        let of_piece: Vec<[f64; 3]> = of_piece.collect();
        moments.resize(tree.len(), [0.0; 3]);
        moments.iter_mut().zip(of_piece).for_each(|(sum, part)| *sum = std::array::from_fn(|i| sum[i] + part[i]));
    }
    let cell = |((level, band), [second, fourth, n]): ((f64, Range<f64>), [f64; 3])| {
        let kurtosis = if second > 0.0 { n * fourth / (second * second) - 2.0 } else { 0.0 };
        let bandwidth_hz = band.end - band.start;
        let samples = bandwidth_hz * counted_s;
        Cell { level, centre_hz: 0.5 * (band.start + band.end), bandwidth_hz, kurtosis, samples }
    };
    let cells: Vec<Cell> = tree.into_iter().zip(moments).map(cell).collect();
    (!cells.is_empty()).then_some(Kurtogram { cells, nyquist_hz: 0.5 * sample_rate_hz })
}

/// Fourier transform of a recording, to cut bands from.
pub(super) struct Bank {
    bins: Vec<Complex<f64>>,
    sample_rate_hz: f64,
    samples: usize,
}

/// Complex envelope of a band.
pub(super) struct BandEnvelope {
    /// Values c(t), |c| being the envelope in the unit of the samples; ends included.
    pub(super) values: Vec<Complex<f64>>,
    /// Sample rate of the envelope, Hz.
    pub(super) rate_hz: f64,
}

impl BandEnvelope {
    /// Values without the faded ends.
    pub(super) fn counted(&self) -> &[Complex<f64>] {
        let ends = (SETTINGS.fade_share * self.values.len() as f64).ceil() as usize;
        self.values.get(ends..self.values.len() - ends).unwrap_or(&[])
    }
}

impl Bank {
    /// Transform of a recording; `None` if it is too short for one band.
    pub(super) fn new<S: Sample>(samples: &[S], sample_rate_hz: f64) -> Option<Self> {
        let n = samples.len();
        if (n as f64) * (1.0 - 2.0 * SETTINGS.fade_share) < 2.0 * SETTINGS.min_independent_samples {
            return None;
        }
        let mean = samples.iter().map(|v| (*v).into()).sum::<f64>() / n as f64;
        let ends = (SETTINGS.fade_share * n as f64).max(1.0);
        let fade = |i: usize| {
            let inside = (i.min(n - 1 - i) as f64 / ends).min(1.0);
            0.5 - 0.5 * (std::f64::consts::PI * inside).cos()
        };
        let mut faded: Vec<f64> = samples.iter().enumerate().map(|(i, v)| ((*v).into() - mean) * fade(i)).collect();
        Some(Self { bins: forward(&mut faded), sample_rate_hz, samples: n })
    }

    pub(super) fn nyquist_hz(&self) -> f64 {
        0.5 * self.sample_rate_hz
    }

    /// Duration without the faded ends, s.
    pub(super) fn counted_s(&self) -> f64 {
        (1.0 - 2.0 * SETTINGS.fade_share) * self.samples as f64 / self.sample_rate_hz
    }

    /// Levels and bands of the tree.
    pub(super) fn tree(&self, min_bandwidth_hz: f64) -> Vec<(f64, Range<f64>)> {
        let least = min_bandwidth_hz.max(SETTINGS.min_independent_samples / self.counted_s());
        let mut counts: Vec<u32> = (0..=SETTINGS.max_level).flat_map(|k| [1 << k, 3 << k]).collect();
        counts.sort_unstable();
        let wide_enough = |count: &u32| *count == 1 || self.nyquist_hz() / f64::from(*count) >= least;
        let bands = |count: u32| {
            let width = self.nyquist_hz() / f64::from(count);
            (0..count).map(move |i| (f64::from(count).log2(), width * f64::from(i)..width * f64::from(i + 1)))
        };
        counts.into_iter().filter(|c| *c <= 1 << SETTINGS.max_level).filter(wide_enough).flat_map(bands).collect()
    }

    /// Envelope of a band, sampled at `denser` times a little above its width: 1 for its power, 2 for the spectrum of
    /// its square.
    pub(super) fn envelope(&self, band_hz: &Range<f64>, denser: usize) -> BandEnvelope {
        let step = self.sample_rate_hz / self.samples as f64;
        let last = self.bins.len() - 1;
        let flank = SETTINGS.flank_share * (band_hz.end - band_hz.start);
        // Half the flank lies beyond each edge; 0 Hz and Nyquist's frequency have no neighbour, and no quadrature.
        let low = (((band_hz.start - 0.5 * flank) / step).ceil().max(1.0) as usize).min(last);
        let high = (((band_hz.end + 0.5 * flank) / step).floor() as usize).min(last - 1);
        let rise = |distance: f64| 0.5 + 0.5 * (std::f64::consts::PI * (distance / flank).clamp(-0.5, 0.5)).sin();
        let at_start = band_hz.start < step;
        let at_end = band_hz.end > last as f64 * step - step;
        let gain = |k: usize| {
            let f = k as f64 * step;
            let below = if at_start { 1.0 } else { rise(f - band_hz.start) };
            let above = if at_end { 1.0 } else { rise(band_hz.end - f) };
            // Power-complementary: the powers of two neighbours add up to the whole.
            (below * above).sqrt() * 2.0 / self.samples as f64
        };
        let mut cut: Vec<_> = (low..=high.max(low)).map(|k| self.bins[k] * gain(k)).collect();
        cut.resize(denser * cut.len(), Complex::ZERO);
        let rate_hz = cut.len() as f64 * step;
        BandEnvelope { values: inverse_complex(&cut), rate_hz }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_signals::{gaussian, impacts};
    use super::*;

    const RATE: f64 = 12_000.0;

    #[test]
    fn literature_the_levels_are_those_of_the_one_third_binary_tree() {
        let grid = kurtogram(&gaussian(12_000, 1), RATE, 700.0).unwrap();
        let count = |bands: f64| {
            let level = grid.cells.iter().filter(|c| (c.level - bands.log2()).abs() < 1e-9);
            (level.clone().count() as f64, level.map(|c| c.bandwidth_hz).sum::<f64>())
        };
        for bands in [1.0, 2.0, 3.0, 4.0, 6.0, 8.0] {
            let (cells, width) = count(bands);
            assert!(cells == bands && (width - 6000.0).abs() < 1e-6, "{bands} {cells} {width}");
        }
        assert_eq!(grid.cells.len(), 1 + 2 + 3 + 4 + 6 + 8);
    }

    #[test]
    fn invariant_the_bands_of_a_level_share_the_power_out() {
        let samples = gaussian(6000, 2);
        let bank = Bank::new(&samples, RATE).unwrap();
        let power = |band: &Range<f64>| {
            let envelope = bank.envelope(band, 1);
            envelope.values.iter().map(Complex::norm_sqr).sum::<f64>() / envelope.values.len() as f64
        };
        let whole = power(&(0.0..6000.0));
        let parts: f64 = bank.tree(500.0).iter().filter(|(l, _)| *l == 3.0).map(|(_, b)| power(b)).sum();
        assert!((parts / whole - 1.0).abs() < 1e-9, "{parts} {whole}");
    }

    #[test]
    fn impacts_are_found_in_their_resonance() {
        for (seed, centre) in [(1, 1875.0), (2, 3400.0), (3, 4600.0)] {
            // A hundred rings a second at a twentieth of the noise's power.
            let samples: Vec<f64> = impacts(24_000, RATE, 97.3, centre, 150.0)
                .iter()
                .zip(gaussian(24_000, seed))
                .map(|(a, b)| a + b)
                .collect();
            let grid = kurtogram(&samples, RATE, 200.0).unwrap();
            let best = grid.best().expect("found");
            assert!((best.centre_hz - centre).abs() < 0.5 * best.bandwidth_hz + 100.0, "{best:?} beside {centre}");
            assert!(best.bandwidth_hz < 2100.0, "{best:?}");
        }
    }

    #[test]
    fn a_tone_has_kurtosis_minus_one_and_is_never_the_best() {
        let samples: Vec<f64> = (0..12_000).map(|i| (std::f64::consts::TAU * 1600.0 * i as f64 / RATE).sin()).collect();
        let grid = kurtogram(&samples, RATE, 200.0).unwrap();
        let own = grid.cells.iter().find(|c| c.level == 3.0 && c.band_hz().contains(&1600.0)).unwrap();
        assert!((own.kurtosis + 1.0).abs() < 1e-3, "{own:?}");
    }

    #[test]
    fn null_white_noise_stays_below_the_bound() {
        let greatest = |seed| {
            let count = [6000, 12_000, 24_000, 48_000][seed as usize % 4];
            let grid = kurtogram(&gaussian(count, seed), RATE, 0.0).unwrap();
            assert_eq!(grid.best(), None, "seed {seed}");
            grid.cells.iter().map(Cell::significance).fold(0.0, f64::max)
        };
        let over_all = (0..40).map(greatest).fold(0.0, f64::max);
        // Not so wide that nothing could reach it.
        assert!(over_all > 0.4 * NOISE_BOUND, "{over_all}");
    }
}
