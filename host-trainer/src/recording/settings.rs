//! Settings of reading and resampling recordings.

/// Settings of the resampling filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResampleSettings {
    /// End of the pass band over the lower Nyquist frequency. Not tuned: chosen by hand.
    pub pass_band: f64,
    /// Attenuation from the lower Nyquist frequency on, dB. Not tuned: chosen by hand.
    pub stop_band_db: f64,
    /// Attenuation in excess of `stop_band_db`, dB, for the rounding of Kaiser's formulas.
    pub margin_db: f64,
    /// Greatest L and M: the ratio of any two rates is met to better than 1e-8.
    pub max_factor: u64,
}

impl ResampleSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { pass_band: 0.9, stop_band_db: 100.0, margin_db: 3.0, max_factor: 20_000 };
}

/// Settings of a time column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeAxisSettings {
    /// Step over the median step above which samples are missing. Not tuned: chosen by hand.
    pub gap_ratio: f64,
}

impl TimeAxisSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { gap_ratio: 1.5 };
}

/// Settings of recordings taken together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputSettings {
    /// Relative difference of sample rates that counts as none. Not tuned: chosen by hand.
    pub rate_tolerance: f64,
    /// Least number of recordings with a start time that make a run to failure. Not tuned: chosen by hand.
    pub min_run_to_failure: usize,
}

impl InputSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { rate_tolerance: 1e-6, min_run_to_failure: 20 };
}

/// Settings of stated operating conditions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConditionSettings {
    /// Standard deviation of a stated shaft speed, as a share of it, where the manifest states none. From the contract:
    /// a stated speed is good to 0.2 %.
    pub stated_speed_std: f64,
}

impl ConditionSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { stated_speed_std: 0.002 };
}
