//! Settings of the search, the alignment and the tachometer's reading.

/// Fisher scoring with damping, theory (55) to (57).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchSettings {
    /// Standard deviation of the pull of a coordinate towards the search's start; coordinates are logarithms or units, so
    /// that 2 is a factor of e². Undetermined coordinates stay where they were, instead of running away along a flat
    /// likelihood. Not tuned: chosen by hand.
    pub prior_std: f64,
    /// Gain in −ln L, as a share of the lack of fit above chance, below which a search ends. Chosen on rigs with a lack of
    /// fit of 10⁶, which no last step mends.
    pub min_share_of_excess: f64,
    /// Stiffness of an angle, 1/rad², which keeps an angle on which nothing depends. Not tuned: chosen by hand.
    pub angle_stiffness: f64,
    /// Greatest change of an angle in a step, rad. Not tuned: chosen by hand.
    pub max_angle_change_rad: f64,
    /// Damping at the start, relative to the information's diagonal. Not tuned: chosen by hand.
    pub initial_damping: f64,
    /// Least damping. Not tuned: chosen by hand.
    pub min_damping: f64,
    /// Damping at which a search without gain ends. Not tuned: chosen by hand.
    pub max_damping: f64,
    /// First factor of damping after a step without gain. Chosen on the refused steps of a diagnosed load step: 130 of 326.
    pub damping_growth: f64,
    /// Least factor of damping after a step with gain. Chosen together with `damping_growth`.
    pub min_damping_fall: f64,
    /// Step of a difference quotient in a coordinate: the root of the error of rounding and integration.
    pub coordinate_step: f64,
    /// Step of a difference quotient in an angle, rad: D's highest harmonics turn some hundred times as fast as the cage.
    pub angle_step_rad: f64,
    /// Bands of equal width of a channel whose scores enter the robust covariance, theory (59). Not tuned: chosen by hand.
    pub score_bands: usize,
}

impl SearchSettings {
    /// Settings of all searches.
    pub const DEFAULT: Self = Self {
        prior_std: 2.0,
        min_share_of_excess: 1e-5,
        angle_stiffness: 1e-3,
        max_angle_change_rad: 0.3,
        initial_damping: 1e-3,
        min_damping: 1e-9,
        max_damping: 1e9,
        damping_growth: 4.0,
        min_damping_fall: 0.2,
        coordinate_step: 1e-4,
        angle_step_rad: 2e-6,
        score_bands: 8,
    };
}

/// Search for the angles at a recording's start, theory (58).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlignmentSettings {
    /// Length of the run that is searched, turns of the shaft: some hundred positions of the balls, each at another angle
    /// of the shaft.
    pub turns: f64,
    /// Most such turns, in lengths of the recording. Not tuned: chosen by hand.
    pub max_recordings: f64,
    /// Greatest distance of a searched angle from the tachometer's, rad: over some twenty turns the balls still pass every
    /// position, a tenth of a pitch a turn.
    pub near_tachometer_rad: f64,
    /// Positions of the cage that are tried, evenly over a pitch of its balls. Not tuned: chosen by hand.
    pub cage_positions: usize,
    /// Gain in ln L from which angles are moved; less is noise. Not tuned: chosen by hand.
    pub min_move_gain: f64,
    /// Half turns of a ball that are tried to bring spin and shaft together. Not tuned: chosen by hand.
    pub ball_half_turns: u32,
    /// Spins of a ball that are simulated, evenly over half a turn. Not tuned: chosen by hand.
    pub spins: usize,
}

impl AlignmentSettings {
    /// Settings of all alignments.
    pub const DEFAULT: Self = Self {
        turns: 24.0,
        max_recordings: 4.0,
        near_tachometer_rad: 0.15,
        cage_positions: 48,
        min_move_gain: 4.0,
        ball_half_turns: 2000,
        spins: 8,
    };
}

/// Reading of the shaft's angle from a tachometer, theory (54).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TachometerSettings {
    /// Standard deviation of a reading, samples: of a turn that began anywhere within one it is 0.29.
    pub std_samples: f64,
    /// Greatest ratio of mean and stated speed, either way; beyond it a tachometer has not one pulse a turn. Not tuned:
    /// chosen by hand.
    pub max_speed_ratio: f64,
}

impl TachometerSettings {
    /// Settings of all readings.
    pub const DEFAULT: Self = Self { std_samples: 0.5, max_speed_ratio: 1.3 };
}
