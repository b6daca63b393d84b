//! Settings of an evaluation: seeds, and what the score of the stated probabilities is.

/// Seeds of an evaluation, and numbers of its score.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EvaluationSettings {
    /// First and last seed on which settings of the diagnosis may be chosen.
    pub choosing_seeds: [u64; 2],
    /// First and last seed that a diagnosis is scored on, and on which nothing may be chosen.
    pub scoring_seeds: [u64; 2],
    /// Bins of the stated probabilities, even from 0 to 1, in the reliability table. Ten is what the literature draws.
    pub bins: usize,
    /// Probability above which a wrong name counts as one that was sure.
    pub sure: f64,
}

impl EvaluationSettings {
    /// Settings of all evaluations.
    pub const DEFAULT: Self = Self { choosing_seeds: [1, 99], scoring_seeds: [100, 199], bins: 10, sure: 0.9 };

    /// Purpose of a seed, in words.
    pub fn purpose(&self, seed: u64) -> &'static str {
        let within = |[first, last]: [u64; 2]| (first..=last).contains(&seed);
        match (within(self.choosing_seeds), within(self.scoring_seeds)) {
            (true, _) => "choosing: settings may have been set on it",
            (_, true) => "scoring: nothing may be set on it",
            _ => "neither for choosing nor for scoring",
        }
    }
}
