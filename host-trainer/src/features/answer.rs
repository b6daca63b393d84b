//! Answer to one question: every set of features by leave-one-bearing-out, and what sets gain on each other.

use rayon::prelude::*;
use serde::Serialize;

use super::bootstrap::{draws, interval95};
use super::leave_one_out::{Aim, Bearing, Problem, Score, score};
use super::measure::NULLS;
use super::permutation::p_value;
use super::scores::mean;
use super::set::FeatureSet;
use super::settings::FeatureSettings;

const SETTINGS: FeatureSettings = FeatureSettings::DEFAULT;

/// Score of one set.
#[derive(Clone, Debug, Serialize)]
pub struct SetScore {
    /// The set.
    pub set: FeatureSet,
    /// Number of features.
    pub features: usize,
    /// Score of each bearing, predicted by the others.
    pub scores: Vec<f64>,
    /// Mean of the bearings, for classes of bearings that of the classes' means.
    pub mean: f64,
    /// Interval of 95 % of the mean over draws of blocks of recordings.
    pub interval95: [f64; 2],
    /// Balanced accuracy of each bearing; `None` for a value.
    pub balanced_accuracies: Option<Vec<f64>>,
    /// Penalty of each bearing's prediction.
    pub penalties: Vec<f64>,
    /// Share named right of the second half of each record where the first halves of all train: the score without leaving
    /// bearings out. `None` where bearings have more than one class.
    pub same_bearings: Option<f64>,
    /// Exact permutation p-value over the labels of bearings of one class each; `None` for others.
    pub p_value: Option<f64>,
    /// Outputs for each row of each bearing.
    #[serde(skip)]
    pub outputs: Vec<Vec<Vec<f64>>>,
}

/// Whether features add to others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The interval is above 0, and no bearing loses.
    Adds,
    /// The interval is below 0, and no bearing gains.
    Lessens,
    /// Neither.
    NotShown,
}

/// Gain of one set on another.
#[derive(Clone, Debug, Serialize)]
pub struct Gain {
    /// The set judged.
    pub with: FeatureSet,
    /// The set that it is compared with.
    pub without: FeatureSet,
    /// Difference of the means.
    pub gain: f64,
    /// Interval of 95 % over the same draws for both.
    pub interval95: [f64; 2],
    /// Difference of each bearing.
    pub bearings: Vec<f64>,
    /// Whether it adds.
    pub verdict: Verdict,
}

/// Answer to a question.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// Score of a bearing.
    pub score: Score,
    /// Names of the bearings.
    pub bearings: Vec<String>,
    /// Number of rows of each.
    pub rows: Vec<usize>,
    /// Scores of all sets.
    pub sets: Vec<SetScore>,
    /// Comparisons.
    pub gains: Vec<Gain>,
    /// Number of labellings of a permutation test; `None` without one.
    pub labellings: Option<usize>,
}

/// Answer by bearings whose rows depend on the set of features.
pub fn answer(aim: Aim, bearings: &(dyn Fn(FeatureSet) -> Vec<Bearing> + Sync), seed: u64) -> Answer {
    let shown = bearings(FeatureSet::CLASSICAL);
    let drawn = draws(&shown.iter().map(|bearing| stretches(aim, bearing)).collect::<Vec<_>>(), seed);
    let sets: Vec<(SetScore, Vec<f64>)> =
        FeatureSet::all().into_par_iter().map(|set| of_set(aim, set, &bearings(set), &drawn)).collect();
    let gains = comparisons().into_iter().map(|(with, without)| {
        let find = |set| sets.iter().find(|(own, _)| own.set == set).expect("all sets are scored");
        gain(find(with), find(without))
    });
    let gains = gains.collect();
    Answer {
        score: aim.score,
        rows: shown.iter().map(|bearing| bearing.rows.len()).collect(),
        labellings: (aim.score == Score::Recall).then(|| super::permutation::count(aim, &shown)),
        bearings: shown.into_iter().map(|bearing| bearing.name).collect(),
        sets: sets.into_iter().map(|(score, _)| score).collect(),
        gains,
    }
}

/// Lengths of the stretches of one class, or of the whole life.
fn stretches(aim: Aim, bearing: &Bearing) -> Vec<usize> {
    match aim.classes {
        0 => vec![bearing.targets.len()],
        _ => bearing.targets.chunk_by(|a, b| a == b).map(<[f64]>::len).collect(),
    }
}

fn of_set(aim: Aim, set: FeatureSet, bearings: &[Bearing], drawn: &[Vec<Vec<usize>>]) -> (SetScore, Vec<f64>) {
    let problem = Problem::new(aim, bearings);
    let every: Vec<usize> = (0..bearings.len()).collect();
    let held_out = problem.leave_one_out();
    let scores: Vec<f64> = held_out.iter().enumerate().map(|(n, held)| problem.score(n, &held.outputs)).collect();
    let in_draw = |rows: &Vec<Vec<usize>>| {
        let scores = rows.iter().enumerate().map(|(n, rows)| {
            let outputs: Vec<Vec<f64>> = rows.iter().map(|row| held_out[n].outputs[*row].clone()).collect();
            let targets: Vec<f64> = rows.iter().map(|row| bearings[n].targets[*row]).collect();
            score(aim, &outputs, &targets)
        });
        problem.together(&every, &scores.collect::<Vec<_>>())
    };
    let in_draws: Vec<f64> = drawn.par_iter().map(in_draw).collect();
    let mean = problem.together(&every, &scores);
    let named = Aim { score: Score::Recall, ..aim };
    let accuracies = || bearings.iter().zip(&held_out).map(|(own, held)| score(named, &held.outputs, &own.targets));
    let lowest = if aim.score == Score::Spearman { -1.0 } else { 0.0 };
    let score = SetScore {
        set,
        features: bearings[0].rows[0].len(),
        scores,
        mean,
        interval95: interval95(in_draws.clone(), mean).map(|end| end.clamp(lowest, 1.0)),
        balanced_accuracies: (aim.classes > 0).then(|| accuracies().collect()),
        penalties: held_out.iter().map(|held| held.penalty).collect(),
        same_bearings: (aim.score == Score::Recall).then(|| same_bearings(aim, bearings)),
        p_value: (aim.score == Score::Recall).then(|| p_value(aim, bearings, mean)),
        outputs: held_out.into_iter().map(|held| held.outputs).collect(),
    };
    (score, in_draws)
}

/// Score of the second halves of bearings by the first halves of all.
fn same_bearings(aim: Aim, bearings: &[Bearing]) -> f64 {
    let half = |bearing: &Bearing, second: bool| {
        let middle = bearing.rows.len() / 2;
        let range = if second { middle..bearing.rows.len() } else { 0..middle };
        let (rows, targets) = (bearing.rows[range.clone()].to_vec(), bearing.targets[range].to_vec());
        Bearing { name: bearing.name.clone(), rows, targets }
    };
    let first: Vec<Bearing> = bearings.iter().map(|bearing| half(bearing, false)).collect();
    let problem = Problem::new(aim, &first);
    let model = problem.whole(SETTINGS.middle_penalty());
    let scores = bearings.iter().map(|bearing| {
        let second = half(bearing, true);
        let outputs: Vec<Vec<f64>> = second.rows.iter().map(|row| model.predict(row)).collect();
        score(aim, &outputs, &second.targets)
    });
    problem.together(&(0..bearings.len()).collect::<Vec<_>>(), &scores.collect::<Vec<_>>())
}

/// Sets that are compared: coefficients with the classical features against these alone, those of a null likewise, and both
/// with each other.
fn comparisons() -> Vec<(FeatureSet, FeatureSet)> {
    let of_library = |library: usize| {
        let beyond_classical = (FeatureSet::of_recording(library, true), FeatureSet::CLASSICAL);
        let beyond_null = (0..NULLS.len()).flat_map(move |null| {
            [false, true].map(|classical| {
                (FeatureSet::of_recording(library, classical), FeatureSet::of_null(library, null, classical))
            })
        });
        let null_beyond_classical =
            (0..NULLS.len()).map(move |null| (FeatureSet::of_null(library, null, true), FeatureSet::CLASSICAL));
        std::iter::once(beyond_classical).chain(null_beyond_classical).chain(beyond_null)
    };
    (0..SETTINGS.degrees.len()).flat_map(of_library).collect()
}

fn gain((with, with_draws): &(SetScore, Vec<f64>), (without, draws): &(SetScore, Vec<f64>)) -> Gain {
    let bearings: Vec<f64> = with.scores.iter().zip(&without.scores).map(|(a, b)| a - b).collect();
    let gain = with.mean - without.mean;
    let interval95 = interval95(with_draws.iter().zip(draws).map(|(a, b)| a - b).collect(), gain);
    let verdict = match interval95 {
        [low, _] if low > 0.0 && bearings.iter().all(|gain| *gain >= 0.0) => Verdict::Adds,
        [_, high] if high < 0.0 && bearings.iter().all(|gain| *gain <= 0.0) => Verdict::Lessens,
        _ => Verdict::NotShown,
    };
    Gain { with: with.set, without: without.set, gain, interval95, bearings, verdict }
}

impl Answer {
    /// Score of a set.
    pub fn of(&self, set: FeatureSet) -> Option<&SetScore> {
        self.sets.iter().find(|own| own.set == set)
    }

    /// Mean balanced accuracy of a set over the bearings.
    pub fn balanced_accuracy(own: &SetScore) -> Option<f64> {
        own.balanced_accuracies.as_ref().map(|each| mean(each.iter().copied()))
    }
}
