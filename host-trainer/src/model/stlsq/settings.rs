//! Settings of STLSQ in addition to [`StlsqConfig`](super::StlsqConfig).

/// Settings of the thresholds that are tried, theory (20).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridSettings {
    /// Logarithm to base 10 of the least threshold above 0. Not tuned: chosen by hand.
    pub min_exponent: f64,
    /// Thresholds per decade. Not tuned: chosen by hand.
    pub per_decade: f64,
    /// Intervals between the least threshold above 0 and the greatest. Not tuned: chosen by hand.
    pub intervals: i32,
}

impl GridSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { min_exponent: -6.0, per_decade: 3.0, intervals: 15 };
}

/// Settings of the conditioning report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConditioningSettings {
    /// Magnitude of the uncentred correlation above which two terms are inseparable. Not tuned: chosen by hand.
    pub inseparable_correlation: f64,
}

impl ConditioningSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { inseparable_correlation: 0.99 };
}

/// Settings of the R factor, theory (17).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RFactorSettings {
    /// Rows decomposed at once: Θ of a block stays in the cache.
    pub block_rows: usize,
}

impl RFactorSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { block_rows: 1024 };
}
