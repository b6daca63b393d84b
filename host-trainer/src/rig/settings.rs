//! Settings of the rig's integration and of its linearisation.

/// Operating conditions that no bearing runs under.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConditionLimits {
    /// Greatest pitch diameter times speed, mm/min: main shafts of aircraft engines reach 3 million (Harris and Kotzalas,
    /// *Essential Concepts of Bearing Technology*, 2007, chapter 1).
    pub speed_factor_mm_per_min: f64,
    /// Most samples of all recordings of one `simulate`, which are held in memory with 24 bytes each.
    pub samples: f64,
    /// Most samples of a recording: while it is made each takes some 90 bytes.
    pub samples_of_one: f64,
    /// Samples of the recordings that are made at once.
    pub samples_at_once: usize,
}

impl ConditionLimits {
    /// Default limits.
    pub const DEFAULT: Self =
        Self { speed_factor_mm_per_min: 3e6, samples: 5e7, samples_of_one: 1.5e7, samples_at_once: 4_000_000 };
}

/// Steps, settling times and vector use of a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegrationSettings {
    /// Contact frequency times step, theory (41): chosen on the error table of the module [`rig`](crate::rig).
    pub contact_rate_per_step: f64,
    /// Rate of an effect times step, theory (41); the stability limit of an explicit method of order four is 2.7. Not
    /// tuned: chosen by hand.
    pub effect_rate_per_step: f64,
    /// Most steps a sample. Not tuned: chosen by hand.
    pub max_steps: f64,
    /// Factor of the steps of a run that diverged and is repeated. Not tuned: chosen by hand.
    pub finer: usize,
    /// Steps a sample from which a run that diverges is not repeated with more. Not tuned: chosen by hand.
    pub most_finer_steps: usize,
    /// Rate of an effect times step in runs for the likelihood, inside the stability limit of 2.7. Not tuned: chosen by
    /// hand.
    pub coarse_effect_rate_per_step: f64,
    /// Contact frequency times step in those runs. Not tuned: chosen by hand, above what one step a sample gives for Hertz's
    /// contact under usual loads (0.1 to 0.45 at 25.6 kHz) and far inside the stability limit.
    pub coarse_contact_rate_per_step: f64,
    /// Most steps a sample in runs for the likelihood: faster motion does not show at the sample rate, and a search that
    /// makes an impact ever shorter must not take ever longer. Not tuned: chosen by hand.
    pub coarse_max_steps: f64,
    /// Most steps a sample in runs for the likelihood for what turns with the shaft. Chosen on local defects, whose
    /// moments are right at any step: with three steps the error is a thousandth where the contact is lost.
    pub coarse_max_turning_steps: f64,
    /// Fastest rate of an sdof rig times step, theory (43): RK4 then errs by 0.3⁵/120, 2e-5 of the fastest motion, in a
    /// step.
    pub sdof_rate_per_step: f64,
    /// Most explicit steps a sample of an sdof rig; beyond, the implicit method is faster at the same error. Not tuned:
    /// chosen by hand.
    pub sdof_max_steps: f64,
    /// Least implicit steps a sample of an sdof rig. Chosen on a damper whose mass is next to nothing.
    pub sdof_implicit_steps: f64,
    /// Samples between two exact evaluations of the angles. Not tuned: chosen by hand.
    pub exact_angles_every: usize,
    /// Runs from which a vector of them beats one after the other. Chosen on `benches/rig.rs`.
    pub vector_from_runs: usize,
    /// Longest settling time, s: the slowest mode of the reference rigs has decayed by e⁻³⁵.
    pub settle_s: f64,
    /// Shortest settling time in runs for the likelihood, s. Not tuned: chosen by hand.
    pub min_settle_s: f64,
    /// Settling time in runs for the likelihood, time constants of the mass that is damped least. Chosen on rig A under loads of
    /// 200 to 1500 N: what remains of the start is 1e-5 m/s² at most.
    pub settle_time_constants: f64,
    /// Share of its greatest value to which the impulse response of a transmission path decays before the recording. Not
    /// tuned: chosen by hand.
    pub path_decay: f64,
    /// Longest such lead, s. Not tuned: chosen by hand.
    pub max_path_preroll_s: f64,
}

impl IntegrationSettings {
    /// Settings of all simulations.
    pub const DEFAULT: Self = Self {
        contact_rate_per_step: 0.12,
        effect_rate_per_step: 0.5,
        max_steps: 256.0,
        finer: 4,
        most_finer_steps: 128,
        coarse_effect_rate_per_step: 1.2,
        coarse_contact_rate_per_step: 0.5,
        coarse_max_steps: 8.0,
        coarse_max_turning_steps: 3.0,
        sdof_rate_per_step: 0.3,
        sdof_max_steps: 12.0,
        sdof_implicit_steps: 3.0,
        exact_angles_every: 64,
        vector_from_runs: 3,
        settle_s: 0.4,
        min_settle_s: 0.02,
        settle_time_constants: 9.0,
        path_decay: 1e-3,
        max_path_preroll_s: 0.2,
    };
}

/// Run, differences and iterations of the statistical linearisation, theory (49) to (52).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearisationSettings {
    /// Length of the run that the rig is linearised along, s. Not tuned: chosen by hand.
    pub run_s: f64,
    /// Longest settling time before that run, s. Not tuned: chosen by hand.
    pub settle_s: f64,
    /// States of the run that slopes are averaged over. Not tuned: chosen by hand.
    pub states: usize,
    /// Seed of the run's noise: any.
    pub seed: u64,
    /// Half the span of a slope's difference quotient, in standard deviations of its coordinate. Not tuned: chosen by hand.
    pub difference_std: f64,
    /// Half that span in a run without noise, whose force laws are smooth. Not tuned: chosen by hand.
    pub noise_free_difference_std: f64,
    /// Positions of the cage over a pitch that the contact is averaged over. Not tuned: chosen by hand.
    pub cage_positions: usize,
    /// Greatest change of the contact's slope as balls pass, over the slope, below which it is constant. By hand: such a change carries
    /// 1e-6 of the noise.
    pub least_passing: f64,
    /// Angles of the cage over a ball pass at which responses begin. Not tuned: chosen by hand.
    pub passing_angles: usize,
    /// Most steps of Newton's method for the rest position; on this convex, smooth force it converges quadratically.
    pub newton_steps: usize,
    /// Halvings of a step of Newton's method that leaves more than before. Not tuned: chosen by hand.
    pub newton_halvings: i32,
    /// Rate of a changing damping times step. Chosen on friction that all but holds the housing.
    pub damping_rate_per_step: f64,
    /// Most steps a sample for a changing damping. Chosen on friction that all but holds the housing.
    pub max_damping_steps: f64,
    /// Samples between two checks whether a response has decayed. Not tuned: chosen by hand.
    pub decay_check_samples: usize,
    /// Share of its greatest value at which a single response ends: rounding.
    pub decay: f64,
    /// Share of its greatest value at which one of many responses ends. Not tuned: chosen by hand.
    pub decay_of_many: f64,
    /// Rounds from velocity covariance to mean slopes and back. Chosen on heavy friction, where each halves the logarithm
    /// of the covariance's error.
    pub mean_rounds: usize,
    /// Instants of a run at which responses begin, in the first and the second round of a changing damping. Chosen on dry
    /// friction against many noisy runs.
    pub instants: [usize; 2],
}

impl LinearisationSettings {
    /// Settings of all linearisations.
    pub const DEFAULT: Self = Self {
        run_s: 0.15,
        settle_s: 0.2,
        states: 300,
        seed: 1,
        difference_std: 0.3,
        noise_free_difference_std: 1e-3,
        cage_positions: 48,
        least_passing: 1e-3,
        passing_angles: 8,
        newton_steps: 60,
        newton_halvings: 12,
        damping_rate_per_step: 0.5,
        max_damping_steps: 8.0,
        decay_check_samples: 256,
        decay: 1e-9,
        decay_of_many: 1e-4,
        mean_rounds: 4,
        instants: [8, 16],
    };
}

/// Constants of the elastohydrodynamic film, theory (110) and (111).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmSettings {
    /// Effective modulus E' = E/(1 − ν²) of steel on steel, Pa.
    pub modulus_pa: f64,
    /// Radius of the races' grooves over the ball's diameter. Not tuned: the usual one of deep groove bearings.
    pub conformity: f64,
    /// Load of the most loaded ball over the mean load of a ball: Stribeck's, for bearings with some clearance.
    pub most_loaded: f64,
    /// Least load of a ball, N, for which the film is computed. Not tuned: the film of a hundredth of it is a third thicker.
    pub least_load_n: f64,
}

impl FilmSettings {
    /// Settings of all films.
    pub const DEFAULT: Self =
        Self { modulus_pa: 200e9 / (1.0 - 0.3 * 0.3), conformity: 0.52, most_loaded: 5.0, least_load_n: 1.0 };
}
