//! Scores R² by core's evaluator, sample by sample, theory (22) and (23).

use ballrace_core::evaluator::{Evaluator, scratch_len};
use ballrace_core::model::Model;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::settings::ScoreSettings;
use crate::recording::input::Series;
use crate::signal::surrogate::SurrogateKind;

const SETTINGS: ScoreSettings = ScoreSettings::DEFAULT;

/// Score of a model over recordings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// R² of each predicted derivative.
    pub derivatives: Vec<f64>,
    /// R² of the predicted next sample of the acceleration; `None` unless the model is causal.
    pub next_sample: Option<f64>,
    /// Rows that were scored.
    pub rows: usize,
}

impl Score {
    /// Mean R² over the derivatives, theory (22): the paper's score.
    pub fn mean(&self) -> f64 {
        self.derivatives.iter().sum::<f64>() / self.derivatives.len().max(1) as f64
    }
}

/// The four scores.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    /// Score on the recordings fitted to: the paper's.
    pub in_sample: Score,
    /// Score on held-out recordings.
    pub held_out: Score,
    /// Score of the same fit in the causal alignment, on held-out recordings.
    pub causal: Score,
    /// Scores of the same fits on surrogates.
    pub null: Vec<NullScores>,
    /// Kind of the surrogates; of model files from before there were several, the only one.
    #[serde(default = "only_kind")]
    pub null_kind: SurrogateKind,
    /// Held-out scores of each training; the model is one of them.
    #[serde(default)]
    pub trainings: Vec<TrainingScores>,
}

const fn only_kind() -> SurrogateKind {
    SurrogateKind::Phase
}

/// Held-out scores of one training.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrainingScores {
    /// Mean R² of the derivatives.
    pub held_out: f64,
    /// R² of the next sample.
    pub causal: Option<f64>,
}

/// Scores of one surrogate fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NullScores {
    /// Mean R² in sample.
    pub in_sample: f64,
    /// Mean R² on held-out surrogates.
    pub held_out: f64,
    /// R² of the next sample on held-out surrogates.
    pub causal: Option<f64>,
}

/// Sums over rows of a target y and its residual e.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    count: f64,
    y: f64,
    y2: f64,
    e: f64,
    e2: f64,
}

impl Sums {
    /// Adds a row.
    pub fn push(&mut self, y: f64, e: f64) {
        self.count += 1.0;
        self.y += y;
        self.y2 += y * y;
        self.e += e;
        self.e2 += e * e;
    }

    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.y += other.y;
        self.y2 += other.y2;
        self.e += other.e;
        self.e2 += other.e2;
    }

    /// Score R², theory (22).
    pub fn r_squared(&self) -> f64 {
        1.0 - self.e2 / (self.y2 - self.y * self.y / self.count)
    }

    fn error_spread(&self) -> f64 {
        (self.e2 / self.count - (self.e / self.count).powi(2)).max(0.0).sqrt()
    }
}

/// Score of a model over all rows of up to 24 recordings together, theory (22) and (23).
pub fn score_model(model: &Model<'_>, recordings: &[Series]) -> Score {
    let count = recordings.len().min(SETTINGS.max_recordings);
    let chosen: Vec<&Series> = (0..count).map(|i| &recordings[i * recordings.len() / count]).collect();
    let (derivatives, next) = sums(model, &chosen);
    Score {
        rows: derivatives.first().map_or(0, |s| s.count as usize),
        derivatives: derivatives.iter().map(Sums::r_squared).collect(),
        next_sample: (next.count > 0.0).then(|| next.r_squared()),
    }
}

/// Unexplained share of each recording's variance in the prediction of the next sample, 1 − R²; NaN unless the model
/// is causal. Unlike the monitor's level it is comparable between models.
pub fn unexplained(model: &Model<'_>, recordings: &[Series]) -> Vec<f64> {
    let share = |series: &Series| 1.0 - recording_sums(model, &series.samples).1.r_squared();
    recordings.par_iter().map(share).collect()
}

/// Standard deviation of each derivative's residual, in scaled units.
pub fn residual_spread(model: &Model<'_>, recordings: &[Series]) -> Vec<f32> {
    let (derivatives, _) = sums(model, &recordings.iter().collect::<Vec<_>>());
    // A spread of zero would make any later residual infinite.
    derivatives.iter().map(|s| (s.error_spread() as f32).max(f32::EPSILON)).collect()
}

fn sums(model: &Model<'_>, recordings: &[&Series]) -> (Vec<Sums>, Sums) {
    let outputs = model.input.len();
    let parts: Vec<_> = recordings.par_iter().map(|series| recording_sums(model, &series.samples)).collect();
    // In the order of the recordings, so that every run rounds alike.
    let mut total = (vec![Sums::default(); outputs], Sums::default());
    for (derivatives, next) in parts {
        total.0.iter_mut().zip(&derivatives).for_each(|(a, b)| a.add(b));
        total.1.add(&next);
    }
    total
}

fn recording_sums(model: &Model<'_>, samples: &[f32]) -> (Vec<Sums>, Sums) {
    let mut scratch = vec![0.0; scratch_len(model)];
    let mut evaluator = Evaluator::new(model, &mut scratch).expect("as much scratch as it asks for");
    let (mut derivatives, mut next) = (vec![Sums::default(); model.input.len()], Sums::default());
    let mut predicted: Option<f32> = None;
    for sample in samples {
        let Some(step) = evaluator.step(*sample) else { continue };
        if let Some(predicted) = predicted {
            next.push((*sample).into(), f64::from(sample - predicted));
        }
        predicted = step.next_sample;
        for ((sums, measured), residual) in derivatives.iter_mut().zip(step.measured).zip(step.residuals()) {
            sums.push((*measured).into(), residual.into());
        }
    }
    (derivatives, next)
}
