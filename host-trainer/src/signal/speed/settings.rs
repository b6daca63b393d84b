//! Settings of the speed estimate, one struct per step.

/// Settings of the evidence over frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EvidenceSettings {
    /// Longest stretch of one transform, s: ball passes wander, and longer stretches do not sharpen them. Not tuned:
    /// chosen by hand.
    pub max_stretch_s: f64,
    /// Greatest number of adjacent bands. Not tuned: chosen by hand.
    pub max_bands: usize,
    /// Least width of a band over the highest frequency. Not tuned: chosen by hand.
    pub band_margin: f64,
    /// Quantile of power over noise that counts as noise. Not tuned: chosen by hand.
    pub noise_quantile: f64,
}

impl EvidenceSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { max_stretch_s: 4.0, max_bands: 8, band_margin: 1.1, noise_quantile: 0.9 };
}

/// Settings of the comb search, theory (79).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CombSettings {
    /// Harmonics of the shaft. Not tuned: chosen by hand.
    pub shaft_harmonics: u32,
    /// Harmonics of the bearing's families. Not tuned: chosen by hand.
    pub bearing_harmonics: u32,
    /// Sidebands to either side of the bearing's harmonics. Not tuned: chosen by hand.
    pub sidebands: i32,
    /// Distance below which teeth count once, steps of the evidence, which is three steps wide.
    pub merge_steps: f64,
    /// Trials as good as the comb after which the sequential test ends. Not tuned: chosen by hand.
    pub max_exceedances: usize,
    /// Trials between two checks of the sequential test. Not tuned: chosen by hand.
    pub trials_at_once: usize,
    /// Range of the slip to either side, standard deviations. Not tuned: chosen by hand.
    pub slip_range: f64,
}

impl CombSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        shaft_harmonics: 10,
        bearing_harmonics: 5,
        sidebands: 2,
        merge_steps: 3.0,
        max_exceedances: 5,
        trials_at_once: 8,
        slip_range: 2.5,
    };
}

/// Settings of the refinement, theory (80).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefineSettings {
    /// Power over noise of a line, over the root of the stretches averaged: one exponential value of 160,000 reaches
    /// 12, and averages scatter less.
    pub line_ratio: f64,
    /// Rounds of line assignment and least squares. Not tuned: chosen by hand.
    pub rounds: usize,
    /// Distance from a tooth within which its line is sought in the first round, steps of the spectrum. Not tuned:
    /// chosen by hand.
    pub first_reach_steps: f64,
    /// Distance from a tooth in later rounds, steps of the spectrum. Not tuned: chosen by hand.
    pub reach_steps: f64,
    /// Least standard deviation of a line's frequency, steps of the spectrum: real lines are not pure. Not tuned:
    /// chosen by hand.
    pub frequency_floor_steps: f64,
    /// Distance below which two lines are one, steps of the spectrum. Not tuned: chosen by hand.
    pub merge_steps: f64,
    /// Starting speeds to either side of the comb's. Not tuned: chosen by hand.
    pub starts_per_side: i32,
    /// Spacing of the starting speeds, steps of the spectrum. Not tuned: chosen by hand.
    pub start_spacing_steps: f64,
    /// Deviations at which a line has a quarter of its weight, so that a foreign line does not pull. Not tuned:
    /// chosen by hand.
    pub trust_deviations: f64,
    /// Greatest standard error, share of the searched range. Not tuned: chosen by hand.
    pub max_error_share: f64,
}

impl RefineSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        line_ratio: 12.0,
        rounds: 6,
        first_reach_steps: 1.6,
        reach_steps: 1.2,
        frequency_floor_steps: 0.05,
        merge_steps: 1.5,
        starts_per_side: 4,
        start_spacing_steps: 0.05,
        trust_deviations: 3.0,
        max_error_share: 0.25,
    };
}
