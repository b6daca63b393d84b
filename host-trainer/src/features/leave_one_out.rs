//! Leave-one-bearing-out: every bearing is predicted by a ridge regression that has seen the others only, theory (121).

use serde::Serialize;

use super::ridge::{Moments, Ridge};
use super::scores::{area_under_roc, mean, recalls, spearman};
use super::settings::FeatureSettings;

const SETTINGS: FeatureSettings = FeatureSettings::DEFAULT;

/// Score of a bearing's predictions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Score {
    /// Area under the ROC curve of class 1 against class 0.
    AreaUnderRoc,
    /// Rank correlation of a value.
    Spearman,
    /// Mean of the shares of the bearing's classes that are named right.
    Recall,
}

/// What is predicted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Aim {
    /// Score of a bearing.
    pub score: Score,
    /// Number of classes; 0 for a value.
    pub classes: usize,
}

/// Rows of a bearing.
#[derive(Clone, Debug, PartialEq)]
pub struct Bearing {
    /// Name.
    pub name: String,
    /// Features of each row.
    pub rows: Vec<Vec<f64>>,
    /// Class number, or value, of each.
    pub targets: Vec<f64>,
}

/// Prediction of a bearing by the others.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// Penalty chosen inside the others.
    pub penalty: f64,
    /// For each row the value, or one number for each class.
    pub outputs: Vec<Vec<f64>>,
}

/// Bearings with the moments of their rows.
pub struct Problem<'b> {
    aim: Aim,
    bearings: &'b [Bearing],
    /// Moments of each bearing's rows of each of its classes.
    parts: Vec<Vec<(usize, Moments)>>,
}

impl<'b> Problem<'b> {
    /// Problem of bearings whose rows have equally many features.
    pub fn new(aim: Aim, bearings: &'b [Bearing]) -> Self {
        let of_bearing = |bearing: &Bearing| match aim.classes {
            0 => {
                let rows = bearing.rows.iter().zip(&bearing.targets);
                let rows: Vec<Vec<f64>> = rows.map(|(row, target)| [&row[..], &[*target]].concat()).collect();
                let columns = rows.first().map_or(0, Vec::len);
                vec![(0, Moments::of_rows(rows.iter().map(Vec::as_slice), columns))]
            }
            classes => {
                let of_class = |class: usize| {
                    let own =
                        bearing.rows.iter().zip(&bearing.targets).filter(|(_, target)| **target as usize == class);
                    let own: Vec<&[f64]> = own.map(|(row, _)| row.as_slice()).collect();
                    let columns = own.first()?.len();
                    Some((class, Moments::of_rows(own.into_iter(), columns).with_targets(&one_of(class, classes))))
                };
                (0..classes).filter_map(of_class).collect()
            }
        };
        Self { aim, bearings, parts: bearings.iter().map(of_bearing).collect() }
    }

    /// Moments of all bearings but some. Classes weigh equally, and so do the bearings of a class.
    fn moments(&self, without: &[usize]) -> Moments {
        let all = || {
            let kept = self.parts.iter().enumerate().filter(move |(n, _)| !without.contains(n));
            kept.flat_map(|(_, parts)| parts)
        };
        let count = |class: usize| all().filter(|part| part.0 == class).count() as f64;
        let mut moments = Moments::zero(all().next().map_or(0, |part| part.1.columns()));
        all().for_each(|(class, part)| moments.add(part, 1.0 / count(*class)));
        moments
    }

    /// Predictions of bearing `held` for each penalty by all others but `held` and `other`.
    fn predictions(&self, held: usize, other: usize, penalties: &[f64]) -> Vec<Vec<Vec<f64>>> {
        let models = Ridge::fit(&self.moments(&[held, other]), self.aim.classes.max(1), penalties);
        let rows = &self.bearings[held].rows;
        models.iter().map(|model| rows.iter().map(|row| model.predict(row)).collect()).collect()
    }

    /// Regression on all bearings.
    pub fn whole(&self, penalty: f64) -> Ridge {
        Ridge::fit(&self.moments(&[]), self.aim.classes.max(1), &[penalty]).remove(0)
    }

    /// Prediction of each bearing by the others.
    pub fn leave_one_out(&self) -> Vec<HeldOut> {
        (0..self.bearings.len()).map(|held| self.held_out(held)).collect()
    }

    fn held_out(&self, held: usize) -> HeldOut {
        let others: Vec<usize> = (0..self.bearings.len()).filter(|n| *n != held).collect();
        let inner: Vec<_> = others.iter().map(|other| self.predictions(*other, held, &SETTINGS.penalties)).collect();
        let score = |place: usize| -> f64 {
            let scores = others.iter().zip(&inner).map(|(n, by_penalty)| self.score(*n, &by_penalty[place]));
            self.together(&others, &scores.collect::<Vec<_>>())
        };
        let scores: Vec<f64> = (0..SETTINGS.penalties.len()).map(score).collect();
        // Of equal scores that of the greatest penalty.
        let best = largest(&scores);
        let penalty = SETTINGS.penalties[best];
        let outputs = self.predictions(held, held, &[penalty]).remove(0);
        HeldOut { penalty, outputs }
    }

    /// Score of outputs for a bearing; 0.5 or 0, what chance gives, where it has none.
    pub fn score(&self, bearing: usize, outputs: &[Vec<f64>]) -> f64 {
        score(self.aim, outputs, &self.bearings[bearing].targets)
    }

    /// Mean score of some bearings; of the recall of bearings that have one class each, the mean of the classes' means.
    pub fn together(&self, bearings: &[usize], scores: &[f64]) -> f64 {
        let class = |n: usize| match (self.aim.score, &self.parts[n][..]) {
            (Score::Recall, [(class, _)]) => *class,
            _ => 0,
        };
        let of_class = |wanted: usize| {
            let own = bearings.iter().zip(scores).filter(|(n, _)| class(**n) == wanted).map(|(_, score)| *score);
            Some(mean(own)).filter(|mean| mean.is_finite())
        };
        mean((0..self.aim.classes.max(1)).filter_map(of_class))
    }
}

/// One number for each class, 1 for the own.
fn one_of(class: usize, classes: usize) -> Vec<f64> {
    (0..classes).map(|other| f64::from(u8::from(other == class))).collect()
}

/// Score of outputs; what chance gives where there is none.
pub fn score(aim: Aim, outputs: &[Vec<f64>], targets: &[f64]) -> f64 {
    match aim.score {
        Score::AreaUnderRoc => {
            let values: Vec<f64> = outputs.iter().map(|output| output[1] - output[0]).collect();
            let positive: Vec<bool> = targets.iter().map(|target| *target > 0.5).collect();
            area_under_roc(&values, &positive).unwrap_or(0.5)
        }
        Score::Spearman => {
            let values: Vec<f64> = outputs.iter().map(|output| output[0]).collect();
            spearman(&values, targets).unwrap_or(0.0)
        }
        Score::Recall => {
            let named: Vec<usize> = outputs.iter().map(|output| largest(output)).collect();
            let truth: Vec<usize> = targets.iter().map(|target| *target as usize).collect();
            mean(recalls(&named, &truth, aim.classes).into_iter().flatten())
        }
    }
}

/// Place of the largest number, the last of equal ones.
fn largest(output: &[f64]) -> usize {
    (0..output.len()).max_by(|a, b| output[*a].total_cmp(&output[*b])).unwrap_or(0)
}
