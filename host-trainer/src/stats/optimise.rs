//! Where a function is greatest.

/// Maximum of a function with one hump between two points.
pub fn golden_section(f: &impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_895;
    for _ in 0..24 {
        let (left, right) = (b - RATIO * (b - a), a + RATIO * (b - a));
        if f(left) > f(right) { b = right } else { a = left }
    }
    0.5 * (a + b)
}
