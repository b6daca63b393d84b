//! Settings of the signal analysis, one struct per stage.

/// Settings of the band chosen by its lines, theory (75).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandSettings {
    /// Step of the lines' common factor, in widths of a spectral value at the highest line. Not tuned: chosen by
    /// hand.
    pub scale_step: f64,
    /// Share of a band's width up to which its envelope shows lines. Not tuned: chosen by hand.
    pub usable_share: f64,
}

impl BandSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { scale_step: 0.5, usable_share: 0.9 };
}

/// Settings of the cyclic coherence, theory (76).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoherenceSettings {
    /// Least overlap of the windows: the hop is at most the window over this. Not tuned: chosen by hand.
    pub overlap: usize,
}

impl CoherenceSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { overlap: 4 };
}

/// Settings of the vibration indicators.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IndicatorSettings {
    /// Shortest recording with a vibration velocity, s: five periods of 10 Hz. Chosen on sines from 12 Hz on, whose
    /// velocity it keeps within 2 %.
    pub velocity_least_s: f64,
    /// Segment of the power density that the velocity comes from, s. Not tuned: chosen by hand.
    pub velocity_segment_s: f64,
}

impl IndicatorSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { velocity_least_s: 0.5, velocity_segment_s: 2.0 };
}

/// Settings of the band-limited interpolation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterpolationSettings {
    /// Taps to either side. Chosen on tones: up to 0.8 of Nyquist's frequency they come out within 1e-4 of their
    /// amplitude.
    pub half_width: usize,
    /// Positions between two samples with tabulated weights; linear between them. Not tuned: chosen by hand.
    pub table_rows: usize,
    /// Stopband attenuation of the Kaiser window, dB. Not tuned: chosen by hand.
    pub stopband_db: f64,
}

impl InterpolationSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { half_width: 16, table_rows: 1024, stopband_db: 90.0 };
}

/// Settings of the fast kurtogram, theory (73).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KurtogramSettings {
    /// Least number of independent envelope samples in a band. Not tuned: chosen by hand.
    pub min_independent_samples: f64,
    /// Greatest whole level: 2^level bands. Not tuned: chosen by hand.
    pub max_level: u32,
    /// Share of the recording at either end that is faded out and not counted: the transform joins the two ends, and
    /// the jump between them would be an impact. Not tuned: chosen by hand.
    pub fade_share: f64,
    /// Share of a band's width over which it fades into each neighbour. Not tuned: chosen by hand.
    pub flank_share: f64,
    /// Significance that white noise stays below over the whole tree, but for one recording in 400. Chosen on 2,000
    /// recordings of 6,000 to 48,000 samples: half stayed below 3.5, 99 % below 6.8, the greatest was 9.4. Kurtosis
    /// of few samples is skewed, so that a Gaussian bound, about 4, is too low.
    pub significance_bound: f64,
}

impl KurtogramSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        min_independent_samples: 64.0,
        max_level: 8,
        fade_share: 0.02,
        flank_share: 0.1,
        significance_bound: 8.0,
    };
}

/// Settings of the noise level around a line, theory (74).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineSettings {
    /// Least reach of the neighbourhood to either side, values. Not tuned: chosen by hand.
    pub min_half_width_bins: usize,
    /// Least reach of the neighbourhood to either side, Hz: real lines are wider than one value. Not tuned: chosen by
    /// hand.
    pub min_half_width_hz: f64,
}

impl LineSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { min_half_width_bins: 32, min_half_width_hz: 8.0 };
}

/// Settings of the computed order tracking, theory (77).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrderSettings {
    /// Greatest degree of the polynomial of time over turns. Not tuned: chosen by hand.
    pub max_degree: usize,
    /// Pulses that the polynomial needs for each of its coefficients. Not tuned: chosen by hand.
    pub pulses_per_coefficient: usize,
    /// Greatest distance of the polynomial from a pulse, samples: half a sample of quantisation, and a margin. Not
    /// tuned: chosen by hand.
    pub pulse_tolerance_samples: f64,
    /// Ratio of a turn to the median turn, or its inverse, above which pulses are missing or spurious. Not tuned:
    /// chosen by hand.
    pub max_turn_ratio: f64,
    /// Least samples of a turn. Not tuned: chosen by hand.
    pub min_turn_samples: f64,
    /// Iteration limit of the inversion of time over turns. Not tuned: chosen by hand.
    pub newton_iterations: usize,
    /// Step at which the inversion ends, turns. Not tuned: chosen by hand.
    pub newton_tolerance_turns: f64,
}

impl OrderSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        max_degree: 6,
        pulses_per_coefficient: 3,
        pulse_tolerance_samples: 0.6,
        max_turn_ratio: 1.6,
        min_turn_samples: 8.0,
        newton_iterations: 20,
        newton_tolerance_turns: 1e-10,
    };
}

/// Settings of the spectra.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectrumSettings {
    /// Share of the band up to Nyquist's frequency within a converter's passband. Not tuned: chosen by hand.
    pub passband_share: f64,
}

impl SpectrumSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { passband_share: 0.8 };
}

/// Settings of the overview of one recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectraSettings {
    /// Least number of samples without a gap. Not tuned: chosen by hand.
    pub min_samples: usize,
    /// Greatest segment of the power density, samples. Not tuned: chosen by hand.
    pub max_segment: usize,
    /// Greatest piece that is transformed at once, samples: a longer recording is cut into equal ones, of which powers are
    /// averaged. At 51.2 kHz a line of 0.03 Hz, less than speeds wander by; 100 MB of transforms.
    pub max_piece: usize,
    /// Multiple of which the pieces of a long recording are, samples, so that their transforms are fast.
    pub piece_multiple: usize,
    /// Greatest piece of the coherence, samples, and most pieces that it is averaged over, evenly spread. Chosen by their
    /// time, which is that of all the rest.
    pub coherence_piece: usize,
    /// See `coherence_piece`.
    pub coherence_pieces: usize,
    /// Harmonics of each family that are listed and that choose the band. Not tuned: chosen by hand.
    pub harmonics: u32,
    /// Sidebands to either side of each harmonic. Not tuned: chosen by hand.
    pub sidebands: i32,
    /// Narrowest band of the kurtogram if no bearing is known, Hz: shows repetitions up to half of it. Not tuned:
    /// chosen by hand.
    pub min_bandwidth_hz: f64,
    /// Greatest ln p at which a band is chosen for its lines: p = 0.001. Not tuned: chosen by hand.
    pub max_log_p_value: f64,
    /// Relative tolerance of a bearing line for unknown slip, a fraction. Not tuned: chosen by hand.
    pub slip_tolerance: f64,
    /// Factor on `slip_tolerance` if the slip is estimated. Not tuned: chosen by hand.
    pub known_slip_factor: f64,
    /// Window of the coherence, samples. Not tuned: chosen by hand.
    pub coherence_window: usize,
    /// Share of the band's width up to which the envelope's spectrum is used. Not tuned: chosen by hand.
    pub envelope_share: f64,
    /// Range of the modulation frequencies over the highest listed harmonic. Not tuned: chosen by hand.
    pub range_factor: f64,
    /// Range of the modulation frequencies if no bearing or speed is known, Hz. Not tuned: chosen by hand.
    pub default_range_hz: f64,
    /// Greatest p-value of the strongest line. Not tuned: chosen by hand.
    pub line_p_value: f64,
}

impl SpectraSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        min_samples: 256,
        max_segment: 4096,
        max_piece: 1 << 21,
        piece_multiple: 1024,
        coherence_piece: 1 << 18,
        coherence_pieces: 4,
        harmonics: 3,
        sidebands: 1,
        min_bandwidth_hz: 400.0,
        max_log_p_value: -6.9,
        slip_tolerance: 0.01,
        known_slip_factor: 0.1,
        coherence_window: 256,
        envelope_share: 0.9,
        range_factor: 1.12,
        default_range_hz: 1000.0,
        line_p_value: 1e-4,
    };
}

/// Settings of the surrogates, theory (24).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurrogateSettings {
    /// Greatest order of the whitening autoregression. Not tuned: chosen by hand.
    pub max_order: usize,
    /// Samples of the recording for each order of the autoregression. Not tuned: chosen by hand.
    pub samples_per_order: usize,
    /// Greatest number of spectral lines that are taken out. Not tuned: chosen by hand.
    pub max_lines: usize,
    /// Power of a line over the median of its neighbourhood. The largest of a thousand bins of noise reaches about
    /// 10.
    pub line_ratio: f64,
    /// Reach of a line's neighbourhood to either side, bins. Not tuned: chosen by hand.
    pub neighbourhood_bins: usize,
    /// Bins to either side of a line that its neighbourhood leaves out. Not tuned: chosen by hand.
    pub guard_bins: usize,
    /// Iterations between the innovations' spectrum and their distribution. Not tuned: chosen by hand.
    pub iterations: usize,
    /// Least periodic power of the innovations over its mean. Not tuned: chosen by hand.
    pub min_level: f64,
    /// Most steps by which unknown samples are restored. Not tuned.
    pub restoring_steps: usize,
    /// Share of the gradient's first sum of squares at which they end. Not tuned.
    pub restored_share: f64,
}

impl SurrogateSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        max_order: 64,
        samples_per_order: 20,
        max_lines: 32,
        line_ratio: 40.0,
        neighbourhood_bins: 24,
        guard_bins: 3,
        iterations: 20,
        min_level: 0.05,
        restoring_steps: 60,
        restored_share: 1e-6,
    };
}

/// Settings of the aging phases, theory (100).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseSettings {
    /// Step in time over the usual one from which recordings are missing between two. By hand.
    pub gap: f64,
    /// Fewest healthy recordings: a standard deviation of fewer says little. By hand.
    pub fewest_healthy: usize,
    /// Most healthy recordings where they are not stated: of 100 to 300 the start of Bearing3_3 is the paper's.
    pub most_healthy: usize,
}

impl PhaseSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { gap: 1.5, fewest_healthy: 10, most_healthy: 100 };
}

/// Settings of the denoising by wavelets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveletSettings {
    /// Frequency below which the last approximation lies, Hz: the paper's.
    pub below_hz: f64,
}

impl WaveletSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self { below_hz: 50.0 };
}
