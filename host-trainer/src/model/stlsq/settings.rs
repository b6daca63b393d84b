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
    /// Blocks whose Gram matrices one thread adds up.
    pub blocks_per_thread: usize,
    /// Rows for each column from which the Gram matrix is tried. Not tuned: chosen by hand.
    pub min_rows_per_column: usize,
    /// Pivot of the Cholesky decomposition over its column's power below which R is taken from a QR decomposition. A pivot has
    /// the rounding errors of that power, so the worst determined direction is then good to 1e-5, others to more.
    pub min_pivot_share: f64,
}

impl RFactorSettings {
    /// Default settings.
    pub const DEFAULT: Self =
        Self { block_rows: 1024, blocks_per_thread: 16, min_rows_per_column: 4, min_pivot_share: 1e-9 };
}

/// Settings of the ridge regression, theory (18).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveSettings {
    /// Ridge penalty from which the normal equations are solved: with columns of unit RMS it bounds their condition number by
    /// p/μ, so that the coefficients are good to 1e-16 p/μ. Below it the rows are decomposed.
    pub min_normal_ridge: f64,
    /// Active terms for each dropped one from which the inverse is changed instead of made anew. By the count of operations.
    pub downdate_divisor: usize,
}

impl SolveSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { min_normal_ridge: 1e-8, downdate_divisor: 4 };
}
