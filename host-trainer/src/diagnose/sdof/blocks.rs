//! Errors of blocks that a model was not fitted to, against those of another model.

use super::settings::SdofSettings;
use crate::stats::significance::one_sided_gain;

const SETTINGS: SdofSettings = SdofSettings::DEFAULT;

/// p-value that the second of two errors of blocks tends to be less. Of one block that has nearly all of the error a test over the
/// blocks tells nothing; a model from other blocks that takes most of its error is no chance.
pub fn gain_p(before: &[f64], after: &[f64]) -> f64 {
    let gains: Vec<f64> = before.iter().zip(after).map(|(b, a)| b - a).collect();
    let by_blocks = one_sided_gain(&gains);
    let total: f64 = before.iter().sum();
    let remains = after.iter().sum::<f64>() / total;
    if total <= 0.0 || remains > 1.0 - SETTINGS.most_of_error {
        return by_blocks;
    }
    let blocks = total.powi(2) / before.iter().map(|error| error * error).sum::<f64>();
    by_blocks.min(remains.powf(0.5 * SETTINGS.pieces * blocks))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clamp that one block in twenty reaches has all of the error; so has a blow, which a model of the other blocks does not take away.
    #[test]
    fn most_of_the_error_of_one_block_is_no_chance() {
        let error = |of_one: f64| {
            (0..20).map(|n| if n == 7 { of_one } else { 1.0 + 0.01 * f64::from(n % 3) }).collect::<Vec<_>>()
        };
        assert!(gain_p(&error(1e4), &error(6e2)) < 1e-3);
        assert!(gain_p(&error(1e4), &error(4e3)) > 0.1);
        assert!(gain_p(&error(1e4), &error(1.1e4)) > 0.5);
    }
}
