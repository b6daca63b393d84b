//! Settings of a fit around its solver, one struct per stage.

use std::f64::consts::{LN_2, LN_10};

/// Least numbers of rows of virtual states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowSettings {
    /// Rows for each dimension over all recordings. Not tuned: chosen by hand.
    pub rows_per_dimension: usize,
    /// Rows for each dimension in each part of the split. Not tuned: chosen by hand.
    pub split_rows_per_dimension: usize,
    /// Least dimension that counts for both. Not tuned: chosen by hand.
    pub min_dimension: usize,
    /// Greatest share of saturated samples: of a machine that runs at the end of its sensor's range, no model can be made. Not
    /// tuned: chosen by hand.
    pub max_saturated: f64,
}

impl RowSettings {
    /// Default settings.
    pub const DEFAULT: Self =
        Self { rows_per_dimension: 10, split_rows_per_dimension: 2, min_dimension: 10, max_saturated: 0.1 };
}

/// Greatest library.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LibrarySettings {
    /// Most functions of a library: more take gigabytes, whatever the time. The paper's widest has 2,528.
    pub max_functions: usize,
}

impl LibrarySettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { max_functions: 3000 };
}

/// Settings of the split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplitSettings {
    /// Greatest number of pieces, whose scatter gives the validation error a standard error. Not tuned: chosen by hand.
    pub max_pieces: usize,
    /// Least rows of a piece, if there are enough. Not tuned: chosen by hand.
    pub min_piece_rows: usize,
    /// Fewest validation recordings: with fewer the ends of the recordings fitted to are used. Two have a scatter.
    pub min_validation: usize,
    /// Least variance of a standardised target in a recording that thresholds are chosen by. Not tuned: chosen by hand.
    pub min_variance: f64,
}

impl SplitSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { max_pieces: 4, min_piece_rows: 64, min_validation: 2, min_variance: 1e-6 };
}

/// Settings of the healthy level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonitorSettings {
    /// Full scale over the greatest magnitude of the healthy recordings, where none is stated. Chosen on Bearing3_3, 3_1 and
    /// 2_7, both channels: failing they reach 4 to 23 times the greatest magnitude of their first 100 recordings, 4 to 24 of the
    /// first 40, 6 to 25 of the first 5; what a failing machine reaches must not read as a broken sensor.
    pub full_scale_factor: f32,
    /// Least run of equal samples that counts as stuck. Not tuned: chosen by hand.
    pub min_stuck_run: u32,
    /// Stuck run over the longest run of equal samples in the healthy recordings. Not tuned: chosen by hand.
    pub stuck_run_factor: u32,
    /// Block length over the longest stuck run, so that a dead sensor cannot fill a block. Not tuned: chosen by hand.
    pub stuck_block_divisor: u32,
    /// Blocks wanted for a healthy mean and spread. Not tuned: chosen by hand.
    pub min_blocks: usize,
    /// Blocks per second, if there are enough rows. Not tuned: chosen by hand.
    pub blocks_per_second: f64,
    /// Least samples in a block. Not tuned: chosen by hand.
    pub min_block: usize,
}

impl MonitorSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        full_scale_factor: 64.0,
        min_stuck_run: 16,
        stuck_run_factor: 4,
        stuck_block_divisor: 4,
        min_blocks: 16,
        blocks_per_second: 10.0,
        min_block: 64,
    };
}

/// Natural logarithm of 2.5.
const LN_2_5: f64 = LN_10 - 2.0 * LN_2;

/// Settings of the monitor's limit, theory (87) to (89).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitSettings {
    /// False alarms a day, unless stated: one in ten days. Chosen with `correlation_factor` on Bearing3_3, Bearing3_1 and
    /// Bearing2_7, 40 to 100 healthy recordings: the least limits without an alarm in the first 30 % of life.
    pub false_alarms_per_day: f64,
    /// Weight of the newest block in the EWMA. Not tuned: chosen by hand.
    pub ewma_weight: f32,
    /// Correlation time of the drift over the length of the healthy record: drift within a tenth of it is all that the record
    /// shows.
    pub correlation_factor: usize,
    /// Greatest standard deviation of a healthy machine's drift, natural logarithm of power: three of them are a zone of
    /// ISO 10816-1, annex B, a factor of 2.5 in amplitude.
    pub max_drift: f64,
    /// Number of the greatest standard deviations that are a zone, beyond which a level is no drift of a healthy machine: an
    /// extrapolated limit goes no further.
    pub max_drift_deviations: f64,
    /// Cells of the posterior in the drift.
    pub drifts: usize,
    /// Cells of the posterior in the noise.
    pub noises: usize,
    /// First and last noise of the posterior over that of successive differences.
    pub noise_range: (f64, f64),
    /// Simulated machines.
    pub machines: usize,
    /// Machines that must cross a limit that is not extrapolated.
    pub min_exceedances: usize,
    /// Least horizon of a simulation, blocks, where the rate is low enough.
    pub min_horizon: usize,
    /// Greatest horizon of a simulation, blocks.
    pub max_horizon: usize,
    /// Least horizon at any rate, blocks.
    pub shortest_horizon: usize,
    /// Residuals below which the noise is Gaussian.
    pub min_residuals: usize,
    /// Mean length of a run of the stationary bootstrap, blocks.
    pub mean_run: usize,
}

impl LimitSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        false_alarms_per_day: 0.1,
        ewma_weight: 0.3,
        correlation_factor: 10,
        max_drift: 2.0 * LN_2_5 / 3.0,
        max_drift_deviations: 3.0,
        drifts: 20,
        noises: 13,
        noise_range: (0.3, 1.8),
        machines: 1000,
        min_exceedances: 10,
        min_horizon: 4000,
        max_horizon: 20_000,
        shortest_horizon: 10,
        min_residuals: 8,
        mean_run: 5,
    };
}

/// Settings of the scores, theory (22).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScoreSettings {
    /// Greatest number of recordings scored, spread evenly over all. Not tuned: chosen by hand.
    pub max_recordings: usize,
}

impl ScoreSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { max_recordings: 24 };
}

/// Settings of the described equations, theory (21).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DescribeSettings {
    /// Greatest number of rows for shares and condition numbers, spread evenly. Not tuned: chosen by hand.
    pub max_rows: usize,
    /// Power of an orthogonalised term over its own power below which it explains nothing. Not tuned: chosen by hand.
    pub min_pivot_share: f64,
}

impl DescribeSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { max_rows: 20_000, min_pivot_share: 1e-12 };
}

/// Parameters of the estimators of virtual states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorSettings {
    /// Degree of a Savitzky–Golay polynomial above the order of its derivative.
    pub excess: u8,
    /// Samples of a Savitzky–Golay window for each coefficient of its polynomial.
    pub stretch: f32,
    /// Cut-off of the Kalman filter, cycles a sample.
    pub cutoff: f32,
}

impl EstimatorSettings {
    /// Chosen on the first 100 recordings of Bearing3_1, both channels, n_MD 2, 4 and 8: greatest mean next-sample R² of
    /// least squares among excess degrees 0 to 2 with stretches 1 to 3, and cut-offs 0.02 to 0.4.
    pub const DEFAULT: Self = Self { excess: 0, stretch: 1.25, cutoff: 0.22 };
}
