//! Settings of the calibration of a bearing rig.

/// Fit, intervals, transmission path and held-out comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalibrationSettings {
    /// Share of the recordings, or of a single one, that is held out. Not tuned: chosen by hand.
    pub held_out_share: f64,
    /// Least process force, N²/Hz, and sensor noise, m/s², at the start of the fit, whose logarithms are sought. Not tuned:
    /// chosen by hand.
    pub min_noise: [f64; 2],
    /// Greatest change of a coordinate in a step of the first fit, of the noise alone. Not tuned: chosen by hand.
    pub max_noise_change: f64,
    /// Standard deviation of a coordinate from which a parameter is undetermined: the ends of the interval of a logarithm
    /// are a factor of four apart, theory (59).
    pub undetermined_std: f64,
    /// Share of an undetermined direction from which a parameter belongs to it. Not tuned: chosen by hand.
    pub min_direction_share: f64,
    /// Bands of a channel in which the residual is compared with its variance. Not tuned: chosen by hand.
    pub residual_bands: usize,
    /// Residual against its variance, RMS over bands, dB, above which a transmission path is identified: about 0.1 where
    /// the rig explains the recordings. Not tuned: chosen by hand.
    pub max_residual_db: f64,
    /// Simulations that a spectrum of the rig is averaged over. Not tuned: chosen by hand.
    pub replicates: usize,
    /// Samples in a Welch segment, of the transmission path and of the log-spectral distance. Not tuned: chosen by hand.
    pub segment: usize,
    /// Numbers of poles that are tried, theory (53). Not tuned: chosen by hand.
    pub path_poles: [usize; 10],
    /// Density, as a share of the greatest, at and below which a bin is rounding and does not count in theory (61).
    pub density_floor: f64,
    /// Share of half the sample rate up to which spectra are compared: above, a recorder's filter against aliases falls. Not tuned: the
    /// bandwidth of analysers, 1/2.56 of the sample rate.
    pub pass_band: f64,
}

impl CalibrationSettings {
    /// Settings of all calibrations.
    pub const DEFAULT: Self = Self {
        held_out_share: 0.25,
        min_noise: [1e-9, 1e-4],
        max_noise_change: 2.0,
        undetermined_std: 0.354,
        min_direction_share: 0.3,
        residual_bands: 24,
        max_residual_db: 1.0,
        replicates: 8,
        segment: 2048,
        path_poles: [2, 4, 8, 12, 16, 24, 32, 48, 64, 96],
        density_floor: 1e-9,
        pass_band: 2.0 / 2.56,
    };
}
