//! Settings of guesses from which searches start.

use serde::Serialize;

/// Settings of the guesses from which searches start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GuessSettings {
    /// Middle and half width of the range of a slipping cage's slip.
    pub slip: [f64; 2],
    /// Gain of such a slip over a healthy one.
    pub slip_gain: f64,
    /// Difference of slips that are one.
    pub same_slip: f64,
    /// Rates of the speed without a tachometer, 1/s.
    pub drifts_per_s: [f64; 5],
    /// Least rate by a tachometer, 1/s.
    pub least_drift_per_s: f64,
    /// Bands of an octave in which a mode is searched for.
    pub bands_per_octave: f64,
    /// Least frequency of a mode, Hz.
    pub least_mode_hz: f64,
    /// Bound on a bin's power over the prediction, so that lines are no modes.
    pub most_power: f64,
    /// Mean of noise below this bound.
    pub mean_power: f64,
    /// Least standard errors of a mode's band.
    pub peak_z: f64,
    /// Modes of a channel.
    pub peaks: usize,
    /// Bands between two modes.
    pub apart: i64,
}

impl GuessSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        slip: [0.05, 0.04],
        slip_gain: 8.0,
        same_slip: 1e-3,
        drifts_per_s: [0.008, 0.014, 0.025, 0.045, 0.08],
        least_drift_per_s: 3e-3,
        bands_per_octave: 16.0,
        least_mode_hz: 150.0,
        most_power: 6.0,
        mean_power: 0.985,
        peak_z: 4.0,
        peaks: 3,
        apart: 4,
    };
}
