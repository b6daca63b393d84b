//! Settings of the cases: counts, and ranges of the draws.
//!
//! Ranges are those of machines, not of the diagnosis, which does not know them. None is tuned: chosen by hand.

/// Counts of cases and recordings, and ranges of machines and operating conditions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CaseSettings {
    /// Controls in a round.
    pub controls: usize,
    /// Cases of each effect outside the vocabulary in a round.
    pub outside_each: usize,
    /// Cases per loud case.
    pub loud_one_in: f64,
    /// Cases per case with a tachometer.
    pub tachometer_one_in: f64,
    /// Cases per case with a guessed rig and a baseline.
    pub guessed_one_in: f64,
    /// Recordings of a case.
    pub recordings: usize,
    /// Recordings of the healthy machine in a case with a guessed rig.
    pub baseline: usize,
    /// Most draws of an effect until one can be simulated.
    pub attempts: usize,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Greatest factor, either way, of masses, springs and dampers against the two reference machines.
    pub machine_factor: f64,
    /// Range of the factor of the unbalance, uniform in the logarithm.
    pub unbalance_factor: [f64; 2],
    /// Factor of the sensor noise of a loud case.
    pub loud_sensor_factor: f64,
    /// Factor of the process force's density of a loud case.
    pub loud_force_factor: f64,
    /// Range of the shaft speed, Hz.
    pub shaft_hz: [f64; 2],
    /// Range of the load, N, uniform in the logarithm.
    pub load_n: [f64; 2],
    /// Factors of speed and load from recording to recording.
    pub condition_factors: [(f64, f64); 4],
    /// Range of a further factor of each speed and load.
    pub condition_scatter: [f64; 2],
    /// Greatest factor, either way, of a guessed parameter against the truth.
    pub guess_factor: f64,
}

impl CaseSettings {
    /// Settings of all evaluations.
    pub const DEFAULT: Self = Self {
        controls: 20,
        outside_each: 2,
        loud_one_in: 3.0,
        tachometer_one_in: 2.0,
        guessed_one_in: 5.0,
        recordings: 4,
        baseline: 3,
        attempts: 20,
        sample_rate_hz: 25_600.0,
        machine_factor: 1.25,
        unbalance_factor: [0.5, 2.0],
        loud_sensor_factor: 4.0,
        loud_force_factor: 10.0,
        shaft_hz: [18.0, 42.0],
        load_n: [350.0, 1800.0],
        condition_factors: [(1.0, 1.0), (0.9, 0.7), (1.1, 1.3), (1.0, 1.15)],
        condition_scatter: [0.97, 1.03],
        guess_factor: 1.2,
    };
}

/// Ranges of the effects outside the vocabulary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutsideSettings {
    /// Amplitude of a swinging stiffness, as a share of the outer race's.
    pub swing_depth: [f64; 2],
    /// Order of a swinging stiffness, between the orders of a bearing.
    pub swing_order: [f64; 2],
    /// Cross-coupling over damping times natural frequency of the inner race; below 1 the whirl stays bounded.
    pub cross_coupling: [f64; 2],
    /// Negative damping of a self-excitation over the outer race's damping.
    pub negative_damping: [f64; 2],
    /// Amplitude at which the negative damping has fallen to a half, m.
    pub self_excited_m: [f64; 2],
    /// Mean rate of random impacts, Hz.
    pub impact_rate_hz: [f64; 2],
    /// Mean impulse of random impacts, N s, uniform in the logarithm.
    pub impact_n_s: [f64; 2],
    /// Factor of each impact's impulse.
    pub impact_scatter: [f64; 2],
    /// Duration of an impact, s.
    pub impact_s: f64,
    /// Frequency of a foreign tone, Hz, uniform in the logarithm.
    pub tone_hz: [f64; 2],
    /// Amplitude of a foreign tone over the recordings' RMS, uniform in the logarithm.
    pub tone_amplitude: [f64; 2],
    /// Quadratic part of a sensor's curve at the recordings' RMS.
    pub curvature: [f64; 2],
    /// Delay of an echo, s, uniform in the logarithm.
    pub echo_s: [f64; 2],
    /// Gain of an echo.
    pub echo_gain: [f64; 2],
    /// Frequency at which noise swells, Hz, uniform in the logarithm.
    pub swell_hz: [f64; 2],
    /// Swelling noise over the sensor's noise, uniform in the logarithm.
    pub swell_noise: [f64; 2],
}

impl OutsideSettings {
    /// Settings of all evaluations.
    pub const DEFAULT: Self = Self {
        swing_depth: [0.1, 0.3],
        swing_order: [0.55, 0.85],
        cross_coupling: [0.3, 0.6],
        negative_damping: [1.2, 2.0],
        self_excited_m: [0.5e-7, 2e-7],
        impact_rate_hz: [15.0, 60.0],
        impact_n_s: [0.5e-3, 4e-3],
        impact_scatter: [0.3, 1.7],
        impact_s: 2e-4,
        tone_hz: [150.0, 5000.0],
        tone_amplitude: [0.2, 1.0],
        curvature: [0.05, 0.2],
        echo_s: [3e-4, 5e-3],
        echo_gain: [0.3, 0.7],
        swell_hz: [1.5, 8.0],
        swell_noise: [1.5, 5.0],
    };
}
