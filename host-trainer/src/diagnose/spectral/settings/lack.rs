//! Settings of the lack of fit.

use serde::Serialize;

/// Settings of the lack of fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LackSettings {
    /// Bands of an octave.
    pub bands_per_octave: f64,
    /// Bound on a bin's power over the prediction, so that no line decides about a band, and the mean that noise has below it.
    pub most_power: f64,
    /// Mean of noise under this bound, 1 − e^−6 for 6.
    pub mean_power: f64,
    /// Excess of −ln L that chance gives a band at most.
    pub band_nats: f64,
    /// Excess of −ln L that chance gives a bin at most.
    pub line_nats: f64,
    /// −ln of the prior of a recording's level that chance and the noise's own changes give at most. By hand.
    pub level_nats: f64,
    /// Share of a bin's mean above which it counts as a line's. By hand.
    pub line_share: f64,
    /// Gain that chance gives a factor of a band's noise or lines at most.
    pub factor_nats: f64,
    /// Lines that are stated.
    pub most_lines: usize,
}

impl LackSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        bands_per_octave: 6.0,
        most_power: 6.0,
        mean_power: 0.9975,
        band_nats: 6.0,
        line_nats: 7.0,
        level_nats: 25.0,
        line_share: 0.3,
        factor_nats: 4.0,
        most_lines: 6,
    };
}
