//! Density of a bin's power under noise and lines, theory (95) and (132).
//!
//! The power of noise is exponential (P. Whittle, Arkiv för Matematik 2 (1953) 423–434); that of a line has the relative variance of
//! the machine against the rig. Of a line that a wandering rotation spreads over several bins all of them are off alike, so that
//! each says less: exponential around a mean that is gamma distributed itself. A few bins are none of these.

use std::sync::LazyLock;

use statrs::function::gamma::ln_gamma;

use super::place::Place;
use super::settings::LikelihoodSettings;

const SETTINGS: LikelihoodSettings = LikelihoodSettings::DEFAULT;

/// A bin under a prediction.
#[derive(Clone, Copy, Debug)]
pub struct Bin {
    /// −ln of the density.
    pub neg_log: f64,
    /// Weight times shape: information of the logarithm of the mean.
    pub information: f64,
    /// Slope of −ln of the density by the logarithm of the mean.
    pub slope: f64,
}

/// Density of a bin's power under noise and line.
#[derive(Clone, Copy, Debug)]
pub struct Density {
    mean: f64,
    ln_mean: f64,
    /// Shape k of the gamma density.
    shape: f64,
    /// ln Γ(k) − k ln k.
    shape_term: f64,
    /// Shape of the density of a spread line's own mean; infinite for others.
    tail: f64,
    /// Scale of that mean.
    tail_scale: f64,
}

impl Density {
    /// Density around a mean of noise and line.
    pub fn new(noise: f64, line: f64) -> Self {
        let mean = noise + line;
        let (shape, shape_term) = shape(line / mean);
        Self { mean, ln_mean: mean.ln(), shape, shape_term, tail: f64::INFINITY, tail_scale: 1.0 }
    }

    /// Density around a mean of which a share is lines that are spread over several bins.
    pub fn spread(mean: f64, share: f64) -> Self {
        let share = share.min(1.0).powi(2);
        let (tail, tail_scale) = (1.0 / share, 1.0 - SPREAD_SCALE * share);
        Self { mean, ln_mean: mean.ln(), shape: 1.0, shape_term: 0.0, tail, tail_scale }
    }

    /// Whether the density of outliers adds nothing at a power.
    fn is_ordinary(&self, ratio: f64) -> bool {
        ratio < ORDINARY[1] && (self.shape == 1.0 || ratio > ORDINARY[0])
    }

    /// −ln of the density without outliers.
    fn of_most(&self, ratio: f64, ln_power: f64) -> f64 {
        if self.tail < f64::INFINITY {
            return self.ln_mean + self.tail_scale.ln() + (1.0 + self.tail) * self.over_tail(ratio).ln_1p();
        }
        if self.shape == 1.0 {
            return self.ln_mean + ratio;
        }
        let ln_ratio = (ln_power - self.ln_mean).max(LEAST_LN_RATIO);
        self.shape * ratio + self.shape_term - (self.shape - 1.0) * ln_ratio + self.ln_mean
    }

    fn over_tail(&self, ratio: f64) -> f64 {
        ratio / (self.tail * self.tail_scale)
    }

    /// Slope of −ln of the density without outliers by the logarithm of the mean, and its variance.
    fn slope_and_information(&self, ratio: f64) -> [f64; 2] {
        if self.tail < f64::INFINITY {
            let over = self.over_tail(ratio);
            return [1.0 - (1.0 + self.tail) * over / (1.0 + over), self.tail / (self.tail + 2.0)];
        }
        [self.shape * (1.0 - ratio), self.shape]
    }

    /// −ln of the density of outliers, times their share. A Pareto density, so that one strong line that is not predicted does
    /// not outweigh all others.
    fn outlier(&self, power: f64) -> f64 {
        let wide = SETTINGS.outlier_power * self.mean;
        self.ln_mean + (SETTINGS.outlier_power / SETTINGS.outliers).ln() + 2.0 * (power / wide).ln_1p()
    }

    /// −ln of the density at a power with its logarithm.
    pub fn neg_log(&self, power: f64, ln_power: f64) -> f64 {
        let ratio = power / self.mean;
        let of_most = self.of_most(ratio, ln_power);
        if self.is_ordinary(ratio) { of_most } else { least_of(of_most, self.outlier(power)) }
    }

    /// −ln of the density at a power, with its slope and information.
    pub fn bin(&self, power: f64, ln_power: f64) -> Bin {
        let ratio = power / self.mean;
        let of_most = self.of_most(ratio, ln_power);
        let [slope, information] = self.slope_and_information(ratio);
        if self.is_ordinary(ratio) {
            return Bin { neg_log: of_most, information, slope };
        }
        let outlier = self.outlier(power);
        let weight = 1.0 / (1.0 + (of_most - outlier).exp());
        let wide = SETTINGS.outlier_power * self.mean;
        let of_outlier = (1.0 - weight) * (1.0 - 2.0 * power / (wide + power));
        Bin {
            neg_log: least_of(of_most, outlier),
            information: weight * information,
            slope: weight * slope + of_outlier,
        }
    }
}

/// What the scale of a spread line's mean is below 1, so that the slope of an exponential power around the mean is 0 on the average
/// where the line is all of it, and 0.06 where it is half: 1 − c with c e^c E₁(c) = ½.
const SPREAD_SCALE: f64 = 0.39;
/// Power over the mean between which the density of outliers adds nothing.
pub const ORDINARY: [f64; 2] = [0.3, 4.0];
/// Bound on the logarithm of power over mean.
const LEAST_LN_RATIO: f64 = -27.6;
/// Share of a line below which a bin counts as noise.
pub const LEAST_SHARE: f64 = 0.05;

/// −ln(e^−a + e^−b).
fn least_of(a: f64, b: f64) -> f64 {
    let apart = (a - b).abs();
    // Beyond that it adds less than a rounding.
    if apart > 40.0 { a.min(b) } else { a.min(b) - (-apart).exp().ln_1p() }
}

/// Shape k of the gamma density of a bin with a line's share of its mean, and ln Γ(k) − k ln k.
fn shape(share: f64) -> (f64, f64) {
    const STEPS: usize = 1024;
    static TERMS: LazyLock<Vec<f64>> = LazyLock::new(|| {
        let shape = |n: usize| shape_of(n as f64 / STEPS as f64);
        (0..=STEPS).map(shape).map(|k| ln_gamma(k) - k * k.ln()).collect()
    });
    if share < LEAST_SHARE { (1.0, 0.0) } else { (shape_of(share), Place::at(share * STEPS as f64).of(&TERMS)) }
}

/// Shape of the gamma density of a bin with a line's share of its mean.
pub fn shape_of(share: f64) -> f64 {
    1.0 / (1.0 - share * share * (1.0 - SETTINGS.line_variance))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bin(power: f64, noise: f64, line: f64) -> Bin {
        Density::new(noise, line).bin(power, power.ln())
    }

    /// −ln of the density, integrated over all powers.
    fn mass(noise: f64, line: f64) -> f64 {
        let step = 1e-3;
        (0..60_000)
            .map(|n| {
                step * (noise + line) * (-bin((f64::from(n) + 0.5) * step * (noise + line), noise, line).neg_log).exp()
            })
            .sum()
    }

    #[test]
    fn invariant_a_density_has_a_mass_of_one_but_for_the_outliers() {
        for line in [0.0, 1.0, 30.0] {
            let mass = mass(1.0, line);
            assert!((0.99..1.03).contains(&mass), "{line}: {mass}");
        }
    }

    #[test]
    fn literature_noise_alone_has_whittles_density() {
        let found = bin(1.7, 2.0, 0.0);
        assert!((found.neg_log - (2.0f64.ln() + 0.85)).abs() < 1e-12 && (found.slope - 0.15).abs() < 1e-12);
    }

    #[test]
    fn an_unpredicted_line_costs_no_more_than_its_logarithm() {
        let cost = |power: f64| bin(power, 1.0, 0.0).neg_log;
        assert!(cost(1e6) - cost(1e3) < 2.1 * 1e3f64.ln(), "{}", cost(1e6) - cost(1e3));
        assert!(bin(1e6, 1.0, 1e6).neg_log < cost(1e6) - 10.0, "a predicted one is likelier");
    }

    #[test]
    fn the_slope_is_that_of_the_density() {
        for (power, noise, line) in [(0.3, 1.0, 0.0), (9.0, 1.0, 2.0), (300.0, 1.0, 20.0)] {
            let at = |log: f64| bin(power, noise * log.exp(), line * log.exp()).neg_log;
            let quotient = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((quotient - bin(power, noise, line).slope).abs() < 1e-4, "{power}: {quotient}");
        }
        for (power, share) in [(0.3, 0.9), (2.0, 0.5), (300.0, 1.0)] {
            let of = |log: f64| Density::spread(20.0 * log.exp(), share).bin(power, power.ln());
            let quotient = (of(1e-5).neg_log - of(-1e-5).neg_log) / 2e-5;
            assert!((quotient - of(0.0).slope).abs() < 1e-4, "{power}: {quotient}");
        }
    }

    /// Noise hardly draws a spread line's mean, and a bin says a third of what one of noise does.
    #[test]
    fn invariant_a_spread_line_is_fitted_with_little_bias_and_says_less() {
        let step = 1e-3;
        for share in [0.1, 0.5, 1.0] {
            let slope = |ratio: f64| (-ratio).exp() * Density::spread(1.0, share).slope_and_information(ratio)[0];
            let mean: f64 = (0..30_000).map(|n| step * slope((f64::from(n) + 0.5) * step)).sum();
            assert!(mean.abs() < 0.07, "{share}: {mean}");
        }
        let spread = Density::spread(1.0, 1.0);
        assert!((spread.slope_and_information(1.0)[1] - 1.0 / 3.0).abs() < 1e-12);
        let cost = |density: Density, power: f64| density.neg_log(power, power.ln());
        let of_six = |density: Density| cost(density, 6.0) - cost(density, 1.0);
        assert!(of_six(spread) < 0.6 * of_six(Density::new(1.0, 0.0)));
        let narrow = Density::spread(1.0, 1e-3);
        assert!((cost(narrow, 2.0) - cost(Density::new(1.0, 0.0), 2.0)).abs() < 1e-3);
    }
}
