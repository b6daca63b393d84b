//! Settings of what a power spectrum shows little of.

use serde::Serialize;

/// Settings of the tests for spikes, a level that swings and a tone that sweeps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct UnsteadySettings {
    /// Kurtosis of the errors of interpolation beyond that of noise from which a recording has more than noise and lines. On `evaluate`,
    /// choosing seeds 62, 63, 66 and 67, every second case, no recording without pits, shocks, spikes and swinging levels has more than
    /// 0.10, machines of another hand 0.3; of what is none a gain that swings has 0.6, rattling and rubbing 2, spikes 5 and more.
    pub kurtosis: f64,
    /// The same in standard errors of the kurtosis of noise: for short recordings. By hand.
    pub standard_errors: f64,
    /// The same over that of a run of the rig, which may rattle. By hand.
    pub of_run: f64,
    /// Parts of a recording, for the spectra of short time. By hand.
    pub parts: usize,
    /// Mean square of the short-time power over the square of its mean at each frequency from which a band is not filled by noise,
    /// which has 2, nor by lines, which have 1. By hand.
    pub fleeting: f64,
    /// Half width of the band of a mode, in its half-power widths. By hand.
    pub widths: f64,
}

impl UnsteadySettings {
    /// Default settings.
    pub const DEFAULT: Self =
        Self { kurtosis: 0.4, standard_errors: 6.0, of_run: 3.0, parts: 8, fleeting: 2.4, widths: 3.0 };
}
