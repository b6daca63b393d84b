//! Options of a training.

use super::gradient::Lambdas;
use super::layout::Layout;
use super::schedule::Schedule;
use super::settings::RunSettings;

const SETTINGS: RunSettings = RunSettings::DEFAULT;

/// Units of the paper's one hidden layer, Table 2.
pub const PAPER_UNITS: usize = 256;

/// Options of a training.
///
/// [`TrainConfig::default`] anneals the learning rate, trains narrow networks for more steps and keeps few terms;
/// [`TrainConfig::PAPER`] does none of that.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainConfig {
    /// Weights of the losses.
    pub lambdas: Lambdas,
    /// Adam's learning rate, where the schedule begins.
    pub learning_rate: f32,
    /// Learning rate over the steps.
    pub schedule: Schedule,
    /// Samples in a batch.
    pub batch: usize,
    /// Epoch limit, refinement not counted; `None`: 500 with 256 hidden units, more with fewer.
    pub epochs: Option<usize>,
    /// Limit of the gradient steps, refinement not counted; `None`: 2000 with 256 hidden units, more with fewer.
    pub max_steps: Option<usize>,
    /// Share of the power of ẋ that a term must be worth, theory (16); 0 keeps all, `None`: chosen on validation recordings.
    pub threshold: Option<f64>,
    /// Share of the power of ẋ that fewer terms may cost, however well that is known: after an annealed training the models
    /// of a path differ by some 10⁻⁴, each beyond its standard error.
    pub immaterial: f64,
    /// Steps of the refinement after each threshold, with the zeros frozen and without L_reg, as a share of the planned steps.
    pub refine: f64,
    /// Checks of the validation loss without improvement that end the training with all terms, if the learning rate is
    /// constant; 0: never, and the last parameters are taken, not the best.
    pub patience: usize,
    /// Seed of initial weights and shuffles.
    pub seed: u64,
}

impl TrainConfig {
    /// The paper's Table 2 with two differences: a limit on the gradient steps, and thresholds as in Champion et al. 2019, but
    /// of what a term's removal costs instead of a coefficient's absolute size.
    pub const PAPER: Self = Self {
        lambdas: Lambdas::PAPER,
        learning_rate: 1e-3,
        schedule: Schedule::Constant,
        batch: 1024,
        epochs: Some(500),
        max_steps: Some(6000),
        threshold: None,
        immaterial: 0.0,
        refine: 0.05,
        patience: 8,
        seed: 0,
    };

    /// Steps of an epoch, the last of which may be a smaller batch.
    pub(super) fn steps_per_epoch(&self, samples: usize) -> usize {
        samples.div_ceil(self.batch.max(1))
    }

    /// Steps of the training with all terms: within both limits.
    pub(super) fn planned_steps(&self, layout: &Layout, samples: usize) -> usize {
        let longer = SETTINGS.lengthening(layout);
        let epochs = self.epochs.unwrap_or(SETTINGS.epochs * longer);
        epochs.saturating_mul(self.steps_per_epoch(samples)).min(self.max_steps.unwrap_or(SETTINGS.steps * longer))
    }
}

impl Default for TrainConfig {
    /// Annealed training. Chosen on FEMTO Bearing3_3, 3_1 and 2_7: the learning rate, of 0.003 to 0.03; the refinement, of 0.05,
    /// 0.15 and 0.3 of the planned steps, of which the first left models of few terms behind those of all. What is immaterial
    /// is a tenth of the 0.002 within which scores count as the same.
    fn default() -> Self {
        Self {
            learning_rate: 1e-2,
            schedule: Schedule::Cosine,
            epochs: None,
            max_steps: None,
            immaterial: 2e-4,
            refine: 0.15,
            ..Self::PAPER
        }
    }
}

#[cfg(test)]
mod tests {
    use ballrace_core::library::Library;

    use super::*;

    #[test]
    fn narrow_networks_are_trained_for_longer_unless_a_limit_is_stated() {
        let layout =
            |units: usize| Layout::new(&[8, units, 8], &[8, units, 8], Library::new(8, 2, 2).unwrap()).unwrap();
        let samples = 100 * 1024;
        let steps = |config: &TrainConfig, units| config.planned_steps(&layout(units), samples);
        let default = TrainConfig::default();
        assert_eq!([256, 512, 24, 2].map(|units| steps(&default, units)), [2000, 2000, 20_000, 24_000]);
        // Of few samples 500 epochs are fewer steps.
        assert_eq!(default.planned_steps(&layout(256), 1024), 500);
        let stated = TrainConfig { max_steps: Some(70), ..TrainConfig::default() };
        assert_eq!(steps(&stated, 24), 70);
        // However many steps are allowed, few samples are not seen without end.
        assert_eq!(TrainConfig { max_steps: Some(usize::MAX), ..stated }.planned_steps(&layout(256), 1024), 500);
        let epochs = TrainConfig { epochs: Some(3), ..TrainConfig::default() };
        assert_eq!(steps(&epochs, 24), 300);
        // The paper's table 2 has 500 epochs.
        assert_eq!(TrainConfig::PAPER.planned_steps(&layout(24), 1024), 500);
    }
}
