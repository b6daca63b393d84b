//! Settings of the force balance and of multiple shooting.

/// Filter, regression, whitening and shooting, theory (62) to (69).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BalanceSettings {
    /// Least standard deviation of a kernel, samples: its sampled derivatives are exact to 1e-7, theory (64).
    pub min_kernel_std: f64,
    /// Length of a kernel to either side, standard deviations, theory (64). Not tuned: chosen by hand.
    pub kernel_reach_std: f64,
    /// Shortest recording, samples. Not tuned: chosen by hand.
    pub min_samples: usize,
    /// Least length of a recording, standard deviations of the kernel: some dozens of rows.
    pub min_recording_std: f64,
    /// Distance of rows, standard deviations of the kernel. Not tuned: chosen by hand.
    pub stride_std: f64,
    /// Standard deviation of the smoothing of states, as a share of the kernel's: flat to 7e-4 where the signal meets its
    /// noise, theory (65).
    pub smoothing_share: f64,
    /// Least smoothing, as a share of `min_kernel_std`. Not tuned: chosen by hand.
    pub min_smoothing_share: f64,
    /// Corner of the high-pass, as a share of the band's lowest frequency. Not tuned: chosen by hand.
    pub corner_share: f64,
    /// Least periods of the corner in the shortest recording. Not tuned: chosen by hand.
    pub min_corner_periods: f64,
    /// Power over the sensor's noise at which a frequency belongs to the signal's band, theory (64). Not tuned: chosen by
    /// hand.
    pub band_power_ratio: f64,
    /// Share of the frequencies up to Nyquist's, from the top, whose median is the noise floor. Not tuned: chosen by hand.
    pub noise_share: f64,
    /// Longest segment of the spectrum, samples. Not tuned: chosen by hand.
    pub segment: usize,
    /// Shortest segment of the spectrum, samples. Not tuned: chosen by hand.
    pub min_segment: usize,
    /// Relative pivot below which columns count as dependent: rounding.
    pub min_pivot: f64,
    /// Ratio of singular values of unit columns below which a combination of parameters is not determined, theory (66).
    /// Not tuned: chosen by hand.
    pub min_singular_ratio: f64,
    /// Share of an undetermined direction above which a column belongs to it. Not tuned: chosen by hand.
    pub min_direction_share: f64,
    /// Least lags of the residual's correlation, rows, theory (66). Not tuned: chosen by hand.
    pub min_lags: usize,
    /// Least length of the shortest recording, in correlation lengths. Not tuned: chosen by hand.
    pub recording_lags: usize,
    /// Share of another's error that an input's hold must reach to be preferred to it. Not tuned: chosen by hand.
    pub hold_error_ratio: f64,
    /// Most steps of the shooting's Gauss–Newton iteration, theory (67). Not tuned: chosen by hand.
    pub shooting_steps: usize,
    /// Most steps where only the windows' starts are fitted. Not tuned: chosen by hand.
    pub start_steps: usize,
    /// Samples of each window to which its start is fitted first, where the motion is not linear in it. Not tuned: chosen by hand.
    pub start_reach: usize,
    /// Factor from one such length to the next. Not tuned: chosen by hand.
    pub start_growth: usize,
    /// Relative fall of the error below which such a fit has converged. Not tuned: chosen by hand.
    pub start_min_fall: f64,
    /// Damping at which such a fit ends without gain. Not tuned: chosen by hand.
    pub start_max_damping: f64,
    /// Relative fall of the error below which the shooting has converged. Not tuned: chosen by hand.
    pub shooting_min_fall: f64,
    /// Damping at the start of the shooting, relative to the normal matrix's diagonal. Not tuned: chosen by hand.
    pub shooting_initial_damping: f64,
    /// Damping at which the shooting ends without gain. Not tuned: chosen by hand.
    pub shooting_max_damping: f64,
    /// Factor of the shooting's damping after a step without gain. Not tuned: chosen by hand.
    pub shooting_damping_growth: f64,
    /// Relative step of the shooting's difference quotients. Not tuned: chosen by hand.
    pub shooting_difference: f64,
    /// Least damping that is multiplied after a step without gain. Not tuned: chosen by hand.
    pub damping_floor: f64,
    /// Factor of the damping after a step with gain. Not tuned: chosen by hand.
    pub damping_fall: f64,
    /// Error of a simulation over the sensor's noise up to which it is accepted, theory (68). Not tuned: chosen by hand.
    pub max_noise_ratio: f64,
    /// Error of a simulation over the signal up to which it is accepted, theory (68): numerical error of a sensor without
    /// noise.
    pub max_signal_ratio: f64,
    /// Half-width of an interval, as a share of the value, beyond which a parameter is not determined. Not tuned: chosen by
    /// hand.
    pub max_half_width: f64,
    /// Absolute correlation of two estimates above which only a combination of them is determined. Not tuned: chosen by
    /// hand.
    pub max_correlation: f64,
    /// Periods of the fastest motion in a window over which a simulation holds in spite of disturbing forces. Not tuned:
    /// chosen by hand.
    pub window_periods: f64,
    /// Shortest such window, samples. Not tuned: chosen by hand.
    pub min_window: usize,
}

impl BalanceSettings {
    /// Settings of all force balances.
    pub const DEFAULT: Self = Self {
        min_kernel_std: 1.2,
        kernel_reach_std: 6.5,
        min_samples: 200,
        min_recording_std: 60.0,
        stride_std: 1.5,
        smoothing_share: 0.5,
        min_smoothing_share: 0.75,
        corner_share: 0.7,
        min_corner_periods: 4.0,
        band_power_ratio: 10.0,
        noise_share: 0.2,
        segment: 2048,
        min_segment: 64,
        min_pivot: 1e-9,
        min_singular_ratio: 1e-6,
        min_direction_share: 0.1,
        min_lags: 4,
        recording_lags: 10,
        hold_error_ratio: 0.995,
        shooting_steps: 25,
        start_steps: 4,
        start_reach: 64,
        start_growth: 3,
        start_min_fall: 1e-3,
        start_max_damping: 1e-2,
        shooting_min_fall: 1e-7,
        shooting_initial_damping: 1e-6,
        shooting_max_damping: 1e6,
        shooting_damping_growth: 8.0,
        shooting_difference: 1e-5,
        damping_floor: 1e-7,
        damping_fall: 0.1,
        max_noise_ratio: 1.6,
        max_signal_ratio: 1e-4,
        max_half_width: 1.0,
        max_correlation: 0.95,
        window_periods: 8.0,
        min_window: 100,
    };
}

/// The smoothing spline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmootherSettings {
    /// Decimal logarithms of the least and the greatest ratio of variances at one step.
    pub log_ratios: (f64, f64),
    /// Cells of the first grid between them. Not tuned: chosen by hand.
    pub ratios: usize,
    /// Samples of all recordings that the variances are estimated from. Not tuned: chosen by hand.
    pub most_samples: usize,
    /// Least samples of each. Not tuned: chosen by hand.
    pub least_samples: usize,
    /// Variance of the start, in units of the noise's. Diffuse; rounding leaves the first steps 1e-6 of it.
    pub start_variance: f64,
}

impl SmootherSettings {
    /// Settings of all smoothers.
    pub const DEFAULT: Self =
        Self { log_ratios: (-10.0, 10.0), ratios: 20, most_samples: 12_000, least_samples: 200, start_variance: 1e10 };
}
