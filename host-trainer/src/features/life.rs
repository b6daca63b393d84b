//! Questions on runs to failure: aging phase by the kurtosis rule, age by time, remaining life.

use serde::Serialize;

use super::leave_one_out::{Aim, Bearing, Score};
use super::measure::Measured;
use super::scores::mean;
use super::set::FeatureSet;
use super::settings::FeatureSettings;

const SETTINGS: FeatureSettings = FeatureSettings::DEFAULT;

/// Run to failure.
#[derive(Clone, Debug)]
pub struct Life {
    /// Name of its folder.
    pub name: String,
    /// Features of its recordings in order of time.
    pub measured: Vec<Measured>,
    /// First aging recording by the kurtosis rule, theory (100).
    pub aging: usize,
    /// First failed recording, theory (101).
    pub failure: Option<usize>,
}

/// Question on runs to failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Question {
    /// Healthy or aging by the kurtosis rule; failure counts as aging.
    Phase,
    /// First or last third of the life.
    Third,
    /// Remaining share of the life.
    RemainingLife,
}

impl Question {
    /// All questions.
    pub const ALL: [Self; 3] = [Self::Phase, Self::Third, Self::RemainingLife];

    /// What is predicted.
    pub const fn aim(self) -> Aim {
        match self {
            Self::Phase | Self::Third => Aim { score: Score::AreaUnderRoc, classes: 2 },
            Self::RemainingLife => Aim { score: Score::Spearman, classes: 0 },
        }
    }

    /// Target of recording `n` of a life; `None` if the question is not about it.
    fn target(self, life: &Life, n: usize) -> Option<f64> {
        let count = life.measured.len();
        match self {
            Self::Phase => Some(f64::from(u8::from(n >= life.aging))),
            Self::Third if n < count / 3 => Some(0.0),
            Self::Third => (n >= count - count / 3).then_some(1.0),
            Self::RemainingLife => Some(1.0 - n as f64 / (count - 1) as f64),
        }
    }
}

/// From where features are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reference {
    /// As they are: a bearing that has just been found running.
    Absolute,
    /// From the mean of the bearing's own first recordings, which are then left out: one that was watched from new.
    Beginning,
}

impl Reference {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Absolute, Self::Beginning];
}

/// Rows of lives for a question, and the numbers of their recordings.
pub fn bearings(lives: &[Life], question: Question, reference: Reference, set: FeatureSet) -> Vec<Bearing> {
    let one = |life: &Life| {
        let values: Vec<Vec<f64>> = life.measured.iter().map(|measured| set.values(measured)).collect();
        let first = first(life, reference);
        let origin = |column: usize| match reference {
            Reference::Absolute => 0.0,
            Reference::Beginning => mean(values[..first].iter().map(|row| row[column])),
        };
        let origins: Vec<f64> = (0..values[0].len()).map(origin).collect();
        let (rows, targets) = asked(life, question, reference)
            .map(|(n, target)| (values[n].iter().zip(&origins).map(|(value, origin)| value - origin).collect(), target))
            .unzip();
        Bearing { name: life.name.clone(), rows, targets }
    };
    lives.iter().map(one).collect()
}

/// Recordings that a question is about, with their targets.
pub fn asked(life: &Life, question: Question, reference: Reference) -> impl Iterator<Item = (usize, f64)> {
    (first(life, reference)..life.measured.len()).filter_map(move |n| Some((n, question.target(life, n)?)))
}

fn first(life: &Life, reference: Reference) -> usize {
    match reference {
        Reference::Absolute => 0,
        // Of a short life at most a quarter.
        Reference::Beginning => SETTINGS.beginning.min(life.measured.len() / 4),
    }
}
