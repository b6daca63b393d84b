//! Settings of the study of features.

/// Numbers of the study, all fixed before its first run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeatureSettings {
    /// Model dimension n_MD of both libraries: states a^(0), a^(2), a^(4), a^(6). Not tuned: the paper's smallest linear library.
    pub dimension: usize,
    /// Degrees n_D of the libraries: 1 knows the spectrum alone, 2 products of states too. Not tuned: chosen by hand.
    pub degrees: [usize; 2],
    /// Samples of a recording for each coefficient of an equation. Not tuned: chosen by hand.
    pub rows_per_term: usize,
    /// Ridge penalties λ tried, on features of unit variance. Not tuned: decades by hand.
    pub penalties: [f64; 5],
    /// Recordings at the beginning of a life from whose mean the features are counted, where they are. Not tuned: chosen by hand.
    pub beginning: usize,
    /// Consecutive recordings of a block of the bootstrap; 200 s of FEMTO. Not tuned: chosen by hand.
    pub block: usize,
    /// Least number of blocks in a stretch of one class; a short one has shorter blocks. Not tuned: chosen by hand.
    pub blocks: usize,
    /// Draws of the bootstrap. Not tuned: enough for two digits of a 95 % interval.
    pub draws: usize,
    /// Samples of a segment of a CWRU record. Not tuned: as a FEMTO recording has.
    pub segment: usize,
    /// Fewest bearings: one is left out, and of the others one more to choose the penalty.
    pub fewest_bearings: usize,
}

impl FeatureSettings {
    /// Default settings.
    pub const DEFAULT: Self = Self {
        dimension: 4,
        degrees: [1, 2],
        rows_per_term: 10,
        penalties: [1e-3, 1e-2, 1e-1, 1.0, 10.0],
        beginning: 20,
        block: 20,
        blocks: 4,
        draws: 1000,
        segment: 2560,
        fewest_bearings: 3,
    };

    /// Penalty in the middle of those tried, where none is chosen.
    pub const fn middle_penalty(&self) -> f64 {
        self.penalties[self.penalties.len() / 2]
    }
}
