//! Learning rate over the steps of a training.

use std::f32::consts::PI;

use super::settings::RunSettings;

/// Learning rate over the steps of a training, theory (15).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Schedule {
    /// Half a cosine down to 0 (Loshchilov and Hutter 2017): what noise the batches bring to the weights dies away.
    #[default]
    Cosine,
    /// The same throughout, as in the paper; the validation loss may end the training early.
    Constant,
}

impl Schedule {
    /// Learning rate at a step of the training with all terms, as a share of the greatest.
    pub(super) fn share(self, step: usize, steps: usize) -> f32 {
        match self {
            Self::Cosine => 0.5 * (1.0 + (PI * step as f32 / steps as f32).cos()),
            Self::Constant => 1.0,
        }
    }

    /// Learning rate at a step of a refinement, as a share of the greatest: a cosine starts lower, as most is learnt.
    pub(super) fn refinement(self, step: usize, steps: usize) -> f32 {
        let start = match self {
            Self::Cosine => RunSettings::DEFAULT.refinement_start,
            Self::Constant => 1.0,
        };
        start * self.share(step, steps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literature_a_cosine_is_half_way_down_in_the_middle_and_nearly_0_at_the_end() {
        // Equation 5 of Loshchilov and Hutter 2017 with a least rate of 0.
        for (step, share) in [(0, 1.0), (25, 0.853_553_4), (50, 0.5), (100, 0.0)] {
            assert!((Schedule::Cosine.share(step, 100) - share).abs() < 1e-6, "{step}");
        }
        assert!(Schedule::Cosine.share(99, 100) > 0.0);
        assert_eq!(Schedule::Constant.share(99, 100), 1.0);
    }

    #[test]
    fn a_refinement_never_exceeds_the_training_s_greatest_rate() {
        for schedule in [Schedule::Cosine, Schedule::Constant] {
            assert!((0..10).all(|step| schedule.refinement(step, 10) <= schedule.share(0, 10)));
        }
    }
}
