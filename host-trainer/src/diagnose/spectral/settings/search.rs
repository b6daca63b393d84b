//! Settings of the search for an effect.

use serde::Serialize;

/// Settings of the search for an effect.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SearchSettings {
    /// Lengths of the brief recordings of the first and the second screening, s.
    pub brief_s: [f64; 2],
    /// Steps of a fit to brief recordings.
    pub brief_steps: usize,
    /// Starts that are simulated together. By hand: a multiple of a vector's runs, few enough for the memory.
    pub side_by_side: usize,
    /// Sizes over that of the start at which a score is taken too, where one run gives them. By hand: half a decade apart.
    pub scales: [f64; 7],
    /// Starts after the first screening.
    pub starts: usize,
    /// Starts of a hypothesis after it.
    pub starts_each: usize,
    /// Hypotheses after the second screening.
    pub hypotheses: usize,
    /// Most hypotheses of a kind, at different components or numbers of lobes.
    pub places: usize,
    /// Share of the greatest gain in the screening from which a hypothesis is fitted to all recordings.
    pub rival_share: f64,
    /// Most hypotheses that are fitted to all recordings.
    pub full_fits: usize,
    /// Steps of these fits, then of those that are close to the best.
    pub steps: [usize; 2],
    /// Difference in gain, nats, that is chance: below it an effect in one direction and in both are the same. By hand.
    pub twin_nats: f64,
    /// Factor by which a gain can grow in a longer search; what is farther from the gain that is asked for is not followed up.
    pub growth: f64,
    /// Loss by a start on all recordings beyond what there is to gain, nats, from which it is not searched.
    pub hopeless_nats: f64,
    /// Damping and gain from which a mode's search is repeated, over those found. By hand: a source that shakes less at the mode's
    /// frequency needs a gain up to a hundred times as great.
    pub other_modes: ([f64; 2], [f64; 9]),
    /// Sizes of a law of the other symmetry from which its search is repeated, over the one found.
    pub other_sizes: [f64; 4],
    /// Gain of a mode at the other sensor over that at its own from which its fit starts. By hand.
    pub extension: [f64; 2],
    /// Damping of a stop over its stiffness from which its fit starts, s. By hand: about the time of an impact.
    pub stop_delays_s: [f64; 2],
    /// Least and greatest size of waviness from which its fit with neighbours starts, over that found alone. By hand.
    pub wave_sizes: [f64; 2],
    /// Number of these sizes. By hand: close enough that one of them is in the right valley.
    pub wave_steps: u32,
    /// Searches from the best of them. By hand: for the computing time.
    pub wave_searches: usize,
    /// Gain of waviness of few lobes at rest from which others are tried, nats. By hand: in the test of a rig that strikes, one of
    /// all numbers of lobes gains 129, where the first gains 58.
    pub other_lobes_nats: f64,
    /// Other numbers of lobes from which searches begin.
    pub other_lobes: usize,
    /// Sizes of a friction from which its full fit starts, over that of the screening.
    pub weaker: [f64; 4],
    /// Widths of a defect from which its search is repeated, over the one found. By hand: close enough that one of them is in
    /// the right valley between the zeros of the lines' envelope.
    pub other_widths: [f64; 10],
    /// Flanks with which the search of a defect is repeated where a half sine leaves much: a trough, one of softer flanks and a
    /// raised cosine. By hand.
    pub flanks: [f64; 3],
    /// Least and greatest width with each of them, over the one found, and their number. By hand: close enough for the valleys
    /// of [`Self::other_widths`], wide enough for a trough of which a half sine meets one flank.
    pub flank_widths: ([f64; 2], u32),
    /// Depths from which it is repeated, over the one found.
    pub other_depths: [f64; 6],
    /// Searches of another form on brief recordings, from the best of its starts, then those of them that go on with all recordings.
    pub restarts: [usize; 2],
    /// Angles from the load over that found, on either side, at which a defect is tried too. By hand, as those below: as close as
    /// the valleys are wide.
    pub turns: [f64; 8],
    /// Angles from the best of these at which it is tried in the end, rad.
    pub near_turns_rad: [f64; 10],
    /// Gain of an effect over that of the best from which it is tried in pairs. By hand.
    pub pair_share: f64,
    /// Most effects that are tried in pairs.
    pub paired: usize,
    /// Pairs whose fit is continued.
    pub pairs_followed: usize,
    /// Gain below the best, nats, within which a fit is continued.
    pub close_nats: f64,
    /// The same as a share of the best gain.
    pub close_share: f64,
}

impl SearchSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        brief_s: [0.3, 0.5],
        brief_steps: 3,
        side_by_side: 64,
        scales: [0.02, 0.06, 0.2, 0.6, 2.0, 6.0, 20.0],
        starts: 40,
        starts_each: 4,
        hypotheses: 9,
        places: 3,
        rival_share: 0.4,
        full_fits: 6,
        steps: [4, 8],
        twin_nats: 2.0,
        growth: 3.0,
        hopeless_nats: 300.0,
        other_sizes: [0.5, 0.8, 1.2, 2.0],
        extension: [0.4, -0.4],
        stop_delays_s: [2e-5, 2e-4],
        wave_sizes: [0.5, 3.5],
        wave_steps: 12,
        wave_searches: 2,
        other_lobes_nats: 100.0,
        other_lobes: 4,
        weaker: [1.0, 0.6, 0.35, 0.2],
        other_widths: [0.35, 0.45, 0.55, 0.65, 0.78, 0.9, 1.0, 1.15, 1.4, 1.8],
        flanks: [0.15, 0.3, 0.5],
        flank_widths: ([0.6, 3.9], 28),
        other_depths: [0.3, 0.45, 0.65, 0.8, 1.3, 2.0],
        restarts: [4, 2],
        turns: [0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1],
        near_turns_rad: [-0.06, -0.04, -0.03, -0.02, -0.01, 0.01, 0.02, 0.03, 0.04, 0.06],
        other_modes: ([1.0, 3.0], [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0]),
        pair_share: 0.2,
        paired: 4,
        pairs_followed: 2,
        close_nats: 40.0,
        close_share: 0.05,
    };
}
