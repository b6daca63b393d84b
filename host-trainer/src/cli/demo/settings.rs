//! Settings of the demo's recordings.

use std::ops::Range;

/// Operating conditions of the simulated machine and ranges of its hidden mode.
#[derive(Clone, Debug, PartialEq)]
pub struct DemoSettings {
    /// Nominal shaft speeds, Hz. Not tuned: chosen by hand.
    pub shaft_hz: [f64; 3],
    /// Nominal loads, N. Not tuned: chosen by hand.
    pub load_n: [f64; 3],
    /// Largest relative deviation of speed and load from nominal. Not tuned: chosen by hand.
    pub scatter: f64,
    /// Natural frequency of the mode, Hz: above the modes of shaft and housing, below the resonator's.
    pub frequency_hz: Range<f64>,
    /// Damping ratio of the mode. Not tuned: chosen by hand.
    pub damping_ratio: Range<f64>,
    /// Share of the recordings before the mode appears. Not tuned: chosen by hand.
    pub start: Range<f64>,
}

impl DemoSettings {
    /// Settings of the demo.
    pub const DEFAULT: Self = Self {
        shaft_hz: [20.0, 25.0, 30.0],
        load_n: [300.0, 500.0, 800.0],
        scatter: 0.01,
        frequency_hz: 1550.0..1750.0,
        damping_ratio: 0.016..0.024,
        start: 0.4..0.55,
    };
}
