//! Settings of reading and resampling recordings.

use std::ops::RangeInclusive;

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

/// Sizes beyond which input is taken for a mistake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizeSettings {
    /// Greatest file of settings, bytes: a hundred times the largest model.
    pub settings_bytes: u64,
    /// Greatest file of samples, also unpacked, bytes. With `samples` chosen so that both fit into 2 GB.
    pub recording_bytes: u64,
    /// Most samples of all channels of a file.
    pub samples: usize,
    /// Greatest size of a sample. Squares, and the device's single precision, hold it.
    pub largest_sample: f64,
    /// Most samples of a channel after resampling.
    pub resampled: f64,
}

impl SizeSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        settings_bytes: 64 << 20,
        recording_bytes: 768 << 20,
        samples: 100_000_000,
        largest_sample: 1e30,
        resampled: 1e8,
    };
}

/// Stated conditions beyond which a number is a mistake; none is of a machine or a recorder of today.
#[derive(Clone, Debug, PartialEq)]
pub struct StatedSettings {
    /// Sample rates, Hz: from a sample in a hundred seconds to a hundred million a second.
    pub sample_rate_hz: RangeInclusive<f64>,
    /// Greatest shaft speed, Hz: the fastest spindles turn a million times a minute.
    pub shaft_hz: f64,
    /// Greatest load either way, N.
    pub load_n: f64,
    /// Ratio of two sample rates between which is resampled, either way.
    pub resample_ratio: f64,
}

impl StatedSettings {
    /// The sample rates, for messages.
    pub const RATES: &'static str = "0.01 to 1e8 Hz";
    /// The shaft speeds, for messages.
    pub const SPEEDS: &'static str = "0 to 17000 Hz, turns a second";
    /// The loads, for messages.
    pub const LOADS: &'static str = "-1e9 to 1e9 N";
    /// Default settings.
    pub const DEFAULT: Self = Self { sample_rate_hz: 0.01..=1e8, shaft_hz: 1.7e4, load_n: 1e9, resample_ratio: 1000.0 };
}
