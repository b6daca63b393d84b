//! Denoising by shrinkage of wavelet details (D. L. Donoho, I. M. Johnstone, Biometrika 81 (1994) 425–455; J. Am. Stat. Assoc.
//! 90 (1995) 1200–1224), theory (99).

use super::Wavelet;
use super::stationary::{decompose, levels_below};
use crate::signal::settings::WaveletSettings;
use crate::signal::transform::median;

/// Rule for the threshold of a level of N details with noise of standard deviation σ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ThresholdRule {
    /// σ √(2 ln N): no noise passes.
    Universal,
    /// σ (0.3936 + 0.1829 log₂ N), 0 up to 32 details: the least worst mean squared error.
    Minimax,
    /// Least of Stein's unbiased estimate of the mean squared error of soft shrinkage.
    Sure,
}

/// What becomes of the details.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Shrinkage {
    /// Those above the threshold are reduced by it.
    Soft,
    /// Those above the threshold stay.
    Hard,
}

/// Level from which the noise is estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum NoiseEstimate {
    /// The finest, for all levels: white noise.
    Finest,
    /// Each level its own: coloured noise.
    EachLevel,
}

/// Denoising by a stationary wavelet transform.
#[derive(Clone, Debug, PartialEq)]
pub struct Denoising {
    /// Wavelet.
    pub wavelet: Wavelet,
    /// Number of levels.
    pub levels: usize,
    /// Rule for the threshold.
    pub rule: ThresholdRule,
    /// What becomes of the details.
    pub shrinkage: Shrinkage,
    /// Level from which the noise is estimated.
    pub noise: NoiseEstimate,
}

/// Median of the magnitude of a normal variable of standard deviation 1.
const NORMAL_MAD: f64 = 0.674_489_750_196_081_7;

impl Denoising {
    /// Soft shrinkage by the universal threshold of each level, in as many levels as the paper takes at a sample rate.
    pub fn of_paper(wavelet: Wavelet, sample_rate_hz: f64) -> Self {
        Self {
            wavelet,
            levels: levels_below(WaveletSettings::DEFAULT.below_hz, sample_rate_hz),
            rule: ThresholdRule::Universal,
            shrinkage: Shrinkage::Soft,
            noise: NoiseEstimate::EachLevel,
        }
    }

    /// Signal without what the thresholds take.
    pub fn apply(&self, signal: &[f64]) -> Vec<f64> {
        let mut parts = decompose(signal, &self.wavelet, self.levels);
        let finest = parts.details.first().map_or(0.0, |details| noise_std(details));
        for details in &mut parts.details {
            let std = match self.noise {
                NoiseEstimate::Finest => finest,
                NoiseEstimate::EachLevel => noise_std(details),
            };
            let threshold = self.rule.threshold(details, std);
            details.iter_mut().for_each(|d| *d = self.shrinkage.shrunk(*d, threshold));
        }
        parts.reconstruct(&self.wavelet)
    }
}

/// Standard deviation of normal noise by the median magnitude, which few large values do not move.
fn noise_std(details: &[f64]) -> f64 {
    let mut magnitudes: Vec<f64> = details.iter().map(|d| d.abs()).collect();
    median(&mut magnitudes).unwrap_or(0.0) / NORMAL_MAD
}

impl ThresholdRule {
    /// Threshold of details with noise of a standard deviation.
    pub fn threshold(self, details: &[f64], std: f64) -> f64 {
        let count = details.len() as f64;
        match self {
            Self::Universal => std * (2.0 * count.max(1.0).ln()).sqrt(),
            Self::Minimax if details.len() <= 32 => 0.0,
            Self::Minimax => std * (0.3936 + 0.1829 * count.log2()),
            Self::Sure => sure(details, std),
        }
    }
}

/// Threshold t of the least σ² (N − 2 #{|d| ≤ t σ} + Σ min(d²/σ², t²)), at most the universal one.
fn sure(details: &[f64], std: f64) -> f64 {
    if std <= 0.0 {
        return 0.0;
    }
    let count = details.len() as f64;
    let mut squares: Vec<f64> = details.iter().map(|d| (d / std).powi(2)).collect();
    squares.sort_by(f64::total_cmp);
    let mut below = 0.0;
    let risk_at = |(n, square): (usize, &f64)| {
        below += square;
        let above = count - (n + 1) as f64;
        (count - 2.0 * (n + 1) as f64 + below + above * square, *square)
    };
    let risks = squares.iter().enumerate().map(risk_at).chain([(count, 0.0)]);
    let best = risks.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, square)| square);
    std * best.min(2.0 * count.max(1.0).ln()).sqrt()
}

impl Shrinkage {
    /// A detail under a threshold.
    pub fn shrunk(self, detail: f64, threshold: f64) -> f64 {
        match self {
            Self::Soft => detail.signum() * (detail.abs() - threshold).max(0.0),
            Self::Hard if detail.abs() > threshold => detail,
            Self::Hard => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::test_signals::gaussian;

    fn denoising(rule: ThresholdRule, shrinkage: Shrinkage) -> Denoising {
        Denoising { wavelet: "sym8".parse().unwrap(), levels: 6, rule, shrinkage, noise: NoiseEstimate::Finest }
    }

    fn power(signal: &[f64]) -> f64 {
        signal.iter().map(|v| v * v).sum::<f64>() / signal.len() as f64
    }

    #[test]
    fn null_white_noise_passes_in_no_more_than_the_last_approximation() {
        for shrinkage in [Shrinkage::Soft, Shrinkage::Hard] {
            let left = power(&denoising(ThresholdRule::Universal, shrinkage).apply(&gaussian(8192, 1)));
            assert!(left < 2.0 / 64.0, "{shrinkage:?}: {left}");
        }
    }

    #[test]
    fn invariant_every_rule_brings_a_noisy_signal_nearer() {
        let clean: Vec<f64> = (0..4096).map(|n| if (n / 512) % 2 == 0 { 3.0 } else { -3.0 }).collect();
        let noisy: Vec<f64> = gaussian(4096, 2).iter().zip(&clean).map(|(n, c)| n + c).collect();
        for rule in [ThresholdRule::Universal, ThresholdRule::Minimax, ThresholdRule::Sure] {
            for shrinkage in [Shrinkage::Soft, Shrinkage::Hard] {
                let found = denoising(rule, shrinkage).apply(&noisy);
                let error: Vec<f64> = found.iter().zip(&clean).map(|(f, c)| f - c).collect();
                assert!(power(&error) < 0.4, "{rule:?} {shrinkage:?}: {}", power(&error));
            }
        }
    }

    #[test]
    fn literature_thresholds_of_a_thousand_details() {
        let noise = gaussian(1024, 3);
        assert!((ThresholdRule::Universal.threshold(&noise, 2.0) - 2.0 * 3.7233).abs() < 1e-3);
        assert!((ThresholdRule::Minimax.threshold(&noise, 2.0) - 2.0 * 2.2226).abs() < 1e-3);
        // Of noise alone nothing is worth keeping: Stein's estimate takes nearly all of it away.
        assert!(ThresholdRule::Sure.threshold(&noise, 1.0) > 1.0);
        assert_eq!([Shrinkage::Soft.shrunk(-3.0, 1.0), Shrinkage::Hard.shrunk(-3.0, 1.0)], [-2.0, -3.0]);
    }

    #[test]
    fn a_silent_signal_stays_silent() {
        assert_eq!(denoising(ThresholdRule::Sure, Shrinkage::Soft).apply(&[0.0; 64]), [0.0; 64]);
    }
}
