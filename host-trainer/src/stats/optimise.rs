//! One-dimensional maximisation.

use super::settings::GoldenSectionSettings;

const SETTINGS: GoldenSectionSettings = GoldenSectionSettings::DEFAULT;

/// Argument of the maximum of a unimodal function between `a` and `b`, by golden-section search.
pub fn golden_section(f: &impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_895;
    for _ in 0..SETTINGS.iterations {
        let (left, right) = (b - RATIO * (b - a), a + RATIO * (b - a));
        if f(left) > f(right) { b = right } else { a = left }
    }
    0.5 * (a + b)
}
