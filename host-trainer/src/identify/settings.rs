//! Settings of the checks of recordings.

/// Settings of the checks before recordings are compared with a rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputCheckSettings {
    /// Ratio of loads or speeds from which a baseline is of another condition. Not tuned: chosen by hand.
    pub condition_ratio: f64,
    /// Standard deviations of the stated speed from which its difference from the tachometer's is said. Not tuned: chosen by
    /// hand.
    pub speed_deviations: f64,
    /// Least standard deviation of a stated speed, as a share of it. Not tuned: chosen by hand.
    pub least_speed_std: f64,
    /// Relative tolerance of a ratio of 60. Not tuned: chosen by hand.
    pub minute_tolerance: f64,
    /// Speed from which turns a minute are the likelier meaning, Hz: few machines turn 18,000 times a minute.
    pub very_fast_hz: f64,
}

impl InputCheckSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        condition_ratio: 2.0,
        speed_deviations: 5.0,
        least_speed_std: 0.001,
        minute_tolerance: 0.05,
        very_fast_hz: 300.0,
    };
}
