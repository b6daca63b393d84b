//! Settings of the commands.

use std::ops::RangeInclusive;
use std::time::Duration;

/// Limits and defaults of the commands that are no options.
#[derive(Clone, Debug, PartialEq)]
pub struct CliSettings {
    /// Recordings on one page of `spectra`. Not tuned: chosen by hand.
    pub recordings_per_page: usize,
    /// Divisor of the count of recordings of a run to failure that gives its healthy ones. Not tuned: chosen by hand.
    pub healthy_divisor: usize,
    /// Maximum of the healthy recordings of a run to failure by default. Not tuned: chosen by hand.
    pub healthy_maximum: usize,
    /// Terms of each equation that `fit` prints without --all-terms. Not tuned: chosen by hand.
    pub terms: usize,
    /// Wavelet of the denoised signal of `phases`, and of the aging phases of `sweep --preset`. Not tuned: the usual one for
    /// bearings.
    pub wavelet: &'static str,
    /// Time between two lines of progress where stderr is no terminal. Not tuned: chosen by hand.
    pub line_every: Duration,
    /// Most trainings, and most surrogate fits, of `fit`. Not tuned: chosen by hand.
    pub fits: usize,
    /// Lengths of the recordings of a case of `evaluate`, s. Not tuned: chosen by hand.
    pub case_seconds: RangeInclusive<f64>,
    /// Most rounds and steps of `evaluate`. Not tuned: chosen by hand.
    pub case_rounds: usize,
    /// Most cases in parallel. Not tuned: chosen by hand.
    pub jobs: usize,
}

impl CliSettings {
    /// Settings of all commands.
    pub const DEFAULT: Self = Self {
        recordings_per_page: 16,
        healthy_divisor: 4,
        healthy_maximum: 100,
        terms: 6,
        wavelet: "db4",
        line_every: Duration::from_secs(5),
        fits: 1000,
        case_seconds: 0.1..=60.0,
        case_rounds: 10_000,
        jobs: 256,
    };
}
