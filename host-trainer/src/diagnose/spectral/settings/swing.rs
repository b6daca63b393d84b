//! Settings of a level that swings.

use serde::Serialize;

/// Settings of the test for a level that swings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SwingSettings {
    /// Parts of a recording whose levels are compared. By hand.
    pub parts: usize,
    /// Standard deviation of the logarithm of their levels from which a recording is not that of a steady machine. Between what is
    /// measured on `evaluate`, seeds 53 and 54, every second case: 0.11 at most, but for spikes of 0.23, and 0.72 of a gain that swings.
    pub swing: f64,
    /// Mean square of the short-time power over the square of its mean at each frequency from which a band is not filled by noise,
    /// which has 2, nor by lines, which have 1. By hand.
    pub fleeting: f64,
    /// Half width of the band of a mode, in its half-power widths. By hand.
    pub widths: f64,
}

impl SwingSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { parts: 8, swing: 0.25, fleeting: 2.4, widths: 3.0 };
}
