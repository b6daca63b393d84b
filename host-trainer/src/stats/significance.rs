//! Significance of a gain on held-out blocks, and of one test among many, theory (81) to (84).

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use statrs::distribution::{ContinuousCDF, StudentsT};
use statrs::function::erf::erfc;

use super::settings::SignificanceSettings;

/// 97.5 % quantile of the normal distribution.
pub const Z975: f64 = 1.959_963_985;

const SETTINGS: SignificanceSettings = SignificanceSettings::DEFAULT;

/// p-value of the total of the blocks' gains, theory (81), by flipping the sign of each block's gain: under the null
/// hypothesis of equally good models the signs are random (P. Good, "Permutation, Parametric, and Bootstrap Tests of
/// Hypotheses", 2005). Blocks are many correlation lengths long, so rows may correlate. 1 for a total of 0 or less.
pub fn sign_flip_of(gains: &[f64], seed: u64) -> f64 {
    let total: f64 = gains.iter().sum();
    if total.is_nan() || total <= 0.0 {
        return 1.0;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let reached = (0..SETTINGS.sign_flips).filter(|_| {
        let flipped: f64 = gains.iter().map(|g| if rng.random_bool(0.5) { *g } else { -*g }).sum();
        flipped >= total
    });
    (reached.count() + 1) as f64 / (SETTINGS.sign_flips + 1) as f64
}

/// Total gain over blocks in standard deviations of its sign-flip distribution.
pub fn paired_z(before: &[f64], after: &[f64]) -> f64 {
    let gains = before.iter().zip(after).map(|(b, a)| b - a);
    let (total, square) = gains.fold((0.0, 0.0), |(t, s), g| (t + g, s + g * g));
    if square > 0.0 { total / square.sqrt() } else { 0.0 }
}

/// Two-sided p-value of a normal deviate, theory (83); `deviations` in standard deviations.
pub fn two_sided(deviations: f64) -> f64 {
    erfc(deviations.abs() / std::f64::consts::SQRT_2)
}

/// Two-sided p-value by Student's t where the standard deviation is that of `count` samples, theory (83); 1 for fewer
/// than two.
pub fn two_sided_of_few(deviations: f64, count: usize) -> f64 {
    match StudentsT::new(0.0, 1.0, count.saturating_sub(1) as f64) {
        Ok(t) => 2.0 * t.sf(deviations.abs()),
        Err(_) => 1.0,
    }
}

/// One-sided p-value by Student's t that the mean of independent values is above 0; 1 for fewer than two.
pub fn one_sided_mean(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count.max(1.0);
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
    if values.len() < 2 || mean <= 0.0 || mean.is_nan() {
        return 1.0;
    }
    if variance == 0.0 {
        return 0.0;
    }
    0.5 * two_sided_of_few(mean / (variance / count).sqrt(), values.len())
}

/// One-sided p-value by ranks that independent values tend to be above 0 (F. Wilcoxon, Biometrics Bull. 1 (1945) 80–83): exact
/// up to 30 values, normal beyond. Unlike Student's t it does not mind that a few are much larger than the others.
pub fn one_sided_ranks(values: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| *v != 0.0).collect();
    sorted.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let n = sorted.len();
    let sum: usize = sorted.iter().enumerate().filter(|(_, v)| **v > 0.0).map(|(rank, _)| rank + 1).sum();
    if n == 0 {
        return 1.0;
    }
    if n > 30 {
        let n = n as f64;
        let z = (sum as f64 - 0.5 - n * (n + 1.0) / 4.0) / (n * (n + 1.0) * (2.0 * n + 1.0) / 24.0).sqrt();
        return 0.5 * erfc(z / std::f64::consts::SQRT_2);
    }
    // Share of the sign patterns with each sum of positive ranks.
    let most = n * (n + 1) / 2;
    let mut share = vec![0.0; most + 1];
    share[0] = 1.0;
    for rank in 1..=n {
        for total in (0..=most).rev() {
            let with = if total >= rank { share[total - rank] } else { 0.0 };
            share[total] = 0.5 * (share[total] + with);
        }
    }
    share[sum..].iter().sum()
}

/// One-sided p-value that independent gains tend to be above 0, by their mean or by their ranks, whichever shows it better.
pub fn one_sided_gain(gains: &[f64]) -> f64 {
    if gains.iter().sum::<f64>() <= 0.0 {
        return 1.0;
    }
    (2.0 * one_sided_mean(gains).min(one_sided_ranks(gains))).min(1.0)
}

/// 97.5 % quantile of Student's t for a number of degrees of freedom.
pub fn t975(degrees: usize) -> f64 {
    StudentsT::new(0.0, 1.0, degrees.max(1) as f64).map_or(Z975, |t| t.inverse_cdf(0.975))
}

/// q-value of each p-value, theory (82): the least false discovery rate at which it is significant (Y. Benjamini, Y.
/// Hochberg, J. R. Stat. Soc. B 57 (1995) 289–300).
pub fn false_discovery_rates(p_values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|a, b| p_values[*b].total_cmp(&p_values[*a]));
    let (mut rates, mut least) = (vec![1.0; p_values.len()], 1.0f64);
    for (rank, index) in (1..=p_values.len()).rev().zip(order) {
        least = least.min(p_values[index] * p_values.len() as f64 / rank as f64);
        rates[index] = least;
    }
    rates
}

/// Share of bootstrap draws of blocks in which each model has the least total error, theory (84).
///
/// `models` holds each model's error on each block.
pub fn shares(models: &[&[f64]], seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let blocks = models.first().map_or(0, |m| m.len());
    let mut wins = vec![0usize; models.len()];
    for _ in 0..SETTINGS.bootstrap_draws {
        let drawn: Vec<usize> = (0..blocks).map(|_| rng.random_range(0..blocks)).collect();
        let total = |m: &[f64]| drawn.iter().map(|b| m[*b]).sum::<f64>();
        let best = (0..models.len()).min_by(|a, b| total(models[*a]).total_cmp(&total(models[*b])));
        if let Some(best) = best {
            wins[best] += 1;
        }
    }
    wins.into_iter().map(|w| w as f64 / SETTINGS.bootstrap_draws as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::force_balance::testing::white;

    #[test]
    fn null_equal_models_are_seldom_told_apart() {
        let told = (0..200).map(|seed| white(seed, 1.0, 24)).filter(|gains| sign_flip_of(gains, 1) < 0.05);
        let told = told.count();
        assert!((1..=22).contains(&told), "{told}");
        let few = (0..2000).filter(|seed| one_sided_mean(&white(*seed, 1.0, 4)) < 0.05).count();
        assert!((70..=130).contains(&few), "{few}");
        assert!((t975(3) - 3.182).abs() < 1e-3);
        // Wilcoxon's table: a sum of 44 of 45 from nine values has 2 of 512 patterns at least as large.
        assert!((one_sided_ranks(&[-1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9e9]) - 2.0 / 512.0).abs() < 1e-12);
        let told = (0..2000).filter(|seed| one_sided_ranks(&white(*seed, 1.0, 40)) < 0.05).count();
        assert!((70..=130).contains(&told), "{told}");
    }

    #[test]
    fn literature_tails() {
        for (z, p) in [(1.96, 0.05), (3.0, 0.0027), (5.5, 3.8e-8)] {
            assert!((two_sided(z) / p - 1.0).abs() < 0.02, "{z}: {}", two_sided(z));
        }
        // Student's table: 7 degrees of freedom, 2.365.
        assert!((two_sided_of_few(-2.365, 8) - 0.05).abs() < 1e-4);
        assert_eq!(two_sided_of_few(9.0, 1), 1.0);
    }

    /// The example of Benjamini and Hochberg, section 3.2: 4 of 15 are found at 0.05.
    #[test]
    fn literature_discoveries() {
        let p = [
            0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344, 0.0459, 0.3240, 0.4262, 0.5719, 0.6528,
            0.7590, 1.0,
        ];
        assert_eq!(false_discovery_rates(&p).iter().filter(|q| **q <= 0.05).count(), 4);
        // The fourth q-value is 15/4 of its p, in any order.
        let turned: Vec<f64> = p.iter().rev().copied().collect();
        assert!((false_discovery_rates(&turned)[11] - 0.0095 * 15.0 / 4.0).abs() < 1e-12);
        assert_eq!(false_discovery_rates(&[]), Vec::<f64>::new());
    }
}
