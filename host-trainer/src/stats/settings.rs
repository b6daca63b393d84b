//! Settings of the statistics.

/// Settings of the resampling tests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignificanceSettings {
    /// Sign flips of a permutation test; the least p-value is 1/(`sign_flips` + 1). Not tuned: chosen by hand.
    pub sign_flips: usize,
    /// Bootstrap draws of blocks for [`shares`](super::significance::shares). Not tuned: chosen by hand.
    pub bootstrap_draws: usize,
}

impl SignificanceSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { sign_flips: 4999, bootstrap_draws: 1000 };
}

/// Settings of the golden-section search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GoldenSectionSettings {
    /// Iterations, each of which shortens the interval to 0.618 of its length. Not tuned: chosen by hand.
    pub iterations: usize,
}

impl GoldenSectionSettings {
    /// Default settings: the interval shrinks to 1e-5 of its length.
    pub const DEFAULT: Self = Self { iterations: 24 };
}
