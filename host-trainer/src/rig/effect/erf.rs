//! The error function, of which force laws in noise are made.

/// erf x to 1.5e-7 (M. Abramowitz, I. A. Stegun, "Handbook of Mathematical Functions", 1964, equation 7.1.26): one exponential,
/// as it is in the innermost loop of a simulation, and a force law is not known to more digits.
pub fn erf(x: f64) -> f64 {
    // Within 4e-8 of 1.
    if x.abs() > 3.9 {
        return 1.0f64.copysign(x);
    }
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs());
    let terms = [1.061_405_429, -1.453_152_027, 1.421_413_741, -0.284_496_736, 0.254_829_592];
    let polynomial = terms.iter().fold(0.0, |sum, a| (sum + a) * t);
    (1.0 - polynomial * (-x * x).exp()).copysign(x)
}

#[cfg(test)]
mod tests {
    /// Table 7.1 of the same book.
    #[test]
    fn literature_values() {
        for (x, value) in [
            (0.0, 0.0),
            (0.1, 0.112_462_916),
            (0.5, 0.520_499_878),
            (1.0, 0.842_700_793),
            (2.0, 0.995_322_265),
            (3.9, 1.0 - 3.5e-8),
            (4.0, 1.0 - 1.5e-8),
        ] {
            assert!((super::erf(x) - value).abs() < 1.6e-7 && (super::erf(-x) + value).abs() < 1.6e-7, "{x}");
        }
    }
}
