//! Settings of the independent simulator: integration, imperfections, strengths and forms of the effects.
//!
//! None is tuned, and none is known to the diagnosis: chosen by hand for machines, before any diagnosis saw a case.

/// Numbers of the integration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegrationSettings {
    /// Turn of the fastest mode or law in a step, rad; at 0.15 the method's error of a mode is 4e-6 of its frequency.
    pub rad_per_step: f64,
    /// Fewest and most steps a sample; the fewest follow a pit that a ball passes in one sample.
    pub steps: [f64; 2],
    /// Time constants of the slowest mode before the first sample.
    pub settle_time_constants: f64,
    /// Shortest and longest settling, s.
    pub settle_s: [f64; 2],
    /// Displacement, m, or velocity, m/s, beyond which a run has diverged.
    pub diverged: f64,
    /// Taps of a noise's colour.
    pub colour_taps: usize,
}

impl IntegrationSettings {
    /// Settings of all evaluations.
    pub const DEFAULT: Self = Self {
        rad_per_step: 0.15,
        steps: [8.0, 64.0],
        settle_time_constants: 16.0,
        settle_s: [0.1, 0.8],
        diverged: 1e3,
        colour_taps: 40,
    };
}

/// Sizes of the imperfections of real machines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImperfectionSettings {
    /// Standard deviation of the speed against what is stated, as a share.
    pub speed_std: f64,
    /// Range of the root mean square of the shaft's wander, as a share of its speed, uniform in the logarithm.
    pub shaft_wander: [f64; 2],
    /// Range of the root mean square of the cage's wander, as a share of its speed, uniform in the logarithm.
    pub cage_wander: [f64; 2],
    /// Range of the frequencies of a wander, Hz.
    pub wander_hz: [f64; 2],
    /// Tones of a wander.
    pub wander_tones: usize,
    /// Greatest slip of a healthy cage, as a share.
    pub most_slip: f64,
    /// Standard deviation of a ball's place in the cage, rad.
    pub ball_spacing_rad: f64,
    /// Range of the standard deviation of the load against what is stated, as a share.
    pub load_std: [f64; 2],
    /// Standard deviation of a sensor noise's level, Np.
    pub noise_level: f64,
    /// Standard deviation of the first term of a noise's colour, Np; term k has a k-th of it.
    pub colour_np: f64,
    /// Terms of a noise's colour.
    pub colour_terms: usize,
    /// Standard deviation of a sensor's offset over that of its noise.
    pub offset_of_noise: f64,
    /// Greatest deviation of any of these, in standard deviations.
    pub most_sigmas: f64,
}

impl ImperfectionSettings {
    /// Settings of all evaluations.
    pub const DEFAULT: Self = Self {
        speed_std: 0.001,
        shaft_wander: [1e-4, 1e-3],
        cage_wander: [1e-4, 1e-3],
        wander_hz: [0.4, 15.0],
        wander_tones: 8,
        most_slip: 0.005,
        ball_spacing_rad: 0.003,
        load_std: [0.005, 0.01],
        noise_level: 0.1,
        colour_np: 0.2,
        colour_terms: 4,
        offset_of_noise: 0.5,
        most_sigmas: 3.0,
    };
}

/// Strengths of the effects and how they are reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrengthSettings {
    /// RMS that a lasting effect changes in both channels over the RMS without it: weakest and strongest, uniform in the
    /// logarithm.
    pub lasting: [f64; 2],
    /// The same in the time after an event.
    pub event: [f64; 2],
    /// Least change of a lasting effect and of an event, where the strength is at its limit; another form is drawn below it.
    pub least: [f64; 2],
    /// Time after an event in which it is measured, s.
    pub event_s: f64,
    /// Ratio within which a strength is reached.
    pub tolerance: f64,
    /// Most simulations to reach a strength.
    pub attempts: usize,
    /// Greatest factor from one to the next.
    pub factor: f64,
    /// Length of these simulations for a lasting effect, s.
    pub seconds: f64,
    /// Share of the cases in which masses, springs and dampers are drawn wider.
    pub wide_machines: f64,
    /// Greatest further factor, either way, of those.
    pub wide_factor: f64,
}

impl StrengthSettings {
    /// Settings of all evaluations.
    pub const DEFAULT: Self = Self {
        lasting: [0.08, 1.6],
        event: [0.3, 6.0],
        least: [0.03, 0.1],
        event_s: 0.02,
        tolerance: 1.15,
        attempts: 8,
        factor: 30.0,
        seconds: 0.3,
        wide_machines: 0.5,
        wide_factor: 1.6,
    };
}

/// Forms of the effects of the vocabulary, and strengths of those that are no force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FormSettings {
    /// Width of a pit, rad, uniform in the logarithm.
    pub pit_width_rad: [f64; 2],
    /// Greatest angle of an outer-race pit from the load, rad.
    pub pit_from_load_rad: f64,
    /// Range of a trapezoid's flank as a share of its width.
    pub flank: [f64; 2],
    /// Range of the place of an asymmetric pit's deepest point, as a share of its width.
    pub deepest: [f64; 2],
    /// Range of the size of the neighbours of a race's main wave.
    pub side_waves: [f64; 2],
    /// Share of misalignments with parts at once and three times the speed.
    pub misalignment_orders: f64,
    /// Range of these parts over the main one.
    pub misalignment_parts: [f64; 2],
    /// Range of the speed at which friction is rounded, m/s, uniform in the logarithm.
    pub rounding_m_per_s: [f64; 2],
    /// Range of the static over the sliding friction.
    pub stribeck_ratio: [f64; 2],
    /// Range of Stribeck's speed over the rounding.
    pub stribeck_speed: [f64; 2],
    /// Range of a stop's damping, s: force over stiffness and speed.
    pub stop_damping_s: [f64; 2],
    /// Range of a stop's gap over the static deflection.
    pub stop_gap: [f64; 2],
    /// Rounding of a dead zone's edges over its half width.
    pub backlash_rounding: f64,
    /// Range of the frequency of a mode, Hz, uniform in the logarithm.
    pub mode_hz: [f64; 2],
    /// Range of the damping ratio of a mode, uniform in the logarithm.
    pub mode_damping: [f64; 2],
    /// Range of the rise time of a load step, s, uniform in the logarithm.
    pub rise_s: [f64; 2],
    /// Range of the duration of a shock, s, uniform in the logarithm.
    pub shock_s: [f64; 2],
    /// Range of the time of an event, as a share of the recording.
    pub event_at: [f64; 2],
    /// Range of the speed's drift, 1/s, uniform in the logarithm.
    pub drift_per_s: [f64; 2],
    /// Range of the slip of a cage that slips, uniform in the logarithm.
    pub cage_slip: [f64; 2],
    /// Range of the mains over the recordings' RMS, uniform in the logarithm.
    pub mains: [f64; 2],
    /// Greatest harmonic of the mains over its fundamental, by the harmonic's number.
    pub mains_harmonics: f64,
    /// Range of a bias over the recordings' RMS, uniform in the logarithm.
    pub bias: [f64; 2],
    /// Range of the logarithm of a gain, uniform in the logarithm.
    pub gain: [f64; 2],
    /// Range of the share of samples beyond a ceiling, uniform in the logarithm.
    pub clipped: [f64; 2],
    /// Range of the count of missing samples, uniform in the logarithm.
    pub dropped: [f64; 2],
    /// Share of faults of the acquisition that are in only some recordings.
    pub fault_comes_and_goes: f64,
}

impl FormSettings {
    /// Settings of all evaluations.
    pub const DEFAULT: Self = Self {
        pit_width_rad: [0.025, 0.14],
        pit_from_load_rad: 0.5,
        flank: [0.1, 0.4],
        deepest: [0.2, 0.4],
        side_waves: [0.05, 0.3],
        misalignment_orders: 0.4,
        misalignment_parts: [0.1, 0.4],
        rounding_m_per_s: [3e-6, 3e-5],
        stribeck_ratio: [1.2, 1.8],
        stribeck_speed: [3.0, 20.0],
        stop_damping_s: [1e-5, 2e-4],
        stop_gap: [0.6, 0.98],
        backlash_rounding: 0.1,
        mode_hz: [400.0, 9000.0],
        mode_damping: [0.008, 0.06],
        rise_s: [1e-4, 3e-2],
        shock_s: [1e-4, 2e-3],
        event_at: [0.12, 0.88],
        drift_per_s: [0.008, 0.1],
        cage_slip: [0.01, 0.06],
        mains: [0.08, 1.6],
        mains_harmonics: 0.5,
        bias: [0.08, 1.6],
        gain: [0.08, 0.8],
        clipped: [2e-4, 5e-2],
        dropped: [2.0, 300.0],
        fault_comes_and_goes: 0.25,
    };
}

/// Ranges of the effects outside the vocabulary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutsideSettings {
    /// Range of a belt's order of the shaft.
    pub belt_order: [f64; 2],
    /// Fewest and most teeth of a gear.
    pub teeth: [u32; 2],
    /// Range of the depth of a mesh's modulation.
    pub mesh_depth: [f64; 2],
    /// Rate of a flow's random force, Hz.
    pub flow_rate_hz: f64,
    /// Length of a flow's random force before it comes again, s.
    pub flow_noise_s: f64,
    /// Range of the frequency of a swinging gain, Hz, uniform in the logarithm.
    pub gain_hz: [f64; 2],
    /// Range of the mean rate of spikes, Hz, uniform in the logarithm.
    pub spikes_hz: [f64; 2],
}

impl OutsideSettings {
    /// Settings of all evaluations.
    pub const DEFAULT: Self = Self {
        belt_order: [0.22, 0.36],
        teeth: [17, 62],
        mesh_depth: [0.2, 0.7],
        flow_rate_hz: 20_000.0,
        flow_noise_s: 20.0,
        gain_hz: [1.5, 9.0],
        spikes_hz: [10.0, 200.0],
    };
}
