//! Fitted coefficients as features: do they tell aging phases and fault classes apart, do they order remaining life, beyond RMS,
//! kurtosis and the coefficients of the null? By leave-one-bearing-out, theory (120) to (125).
//!
//! | module | holds |
//! |---|---|
//! | this one | the study of all questions |
//! | [`coefficients`] | coefficients of a fit to one recording |
//! | [`mod@measure`] | all features of a recording, those of its surrogates too |
//! | [`set`] | sets of features that are compared |
//! | [`life`] | questions on runs to failure |
//! | [`faults`] | question on the CWRU records |
//! | [`ridge`] | ridge regression, the one method for all sets |
//! | [`leave_one_out`] | predictions of bearings by the others |
//! | [`scores`] | rank correlation, area under the ROC curve, recalls |
//! | [`bootstrap`], [`permutation`] | spread over blocks of recordings; chance over labels of records |
//! | [`mod@answer`] | scores of all sets for one question, and what sets gain on each other |
//! | [`findings`] | the answers in words |
//! | `settings` | numbers of the study |

pub mod answer;
pub mod bootstrap;
pub mod coefficients;
pub mod faults;
pub mod findings;
pub mod leave_one_out;
pub mod life;
pub mod measure;
pub mod permutation;
pub mod ridge;
pub mod scores;
pub mod set;
pub(crate) mod settings;

use serde::Serialize;

use self::answer::{Answer, answer};
use self::life::{Life, Question, Reference, bearings};

/// Fewest bearings of a study.
pub const FEWEST_BEARINGS: usize = settings::FeatureSettings::DEFAULT.fewest_bearings;

/// Answer to a question on runs to failure.
#[derive(Clone, Debug, Serialize)]
pub struct LifeAnswer {
    /// The question.
    pub question: Question,
    /// From where features are counted.
    pub reference: Reference,
    /// The answer.
    #[serde(flatten)]
    pub answer: Answer,
}

/// Answers to all questions.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// Answers on runs to failure.
    pub lives: Vec<LifeAnswer>,
    /// Answer on the damaged part of the CWRU bearings; `None` without the records.
    pub faults: Option<Answer>,
}

/// Answers to all questions by at least [`FEWEST_BEARINGS`] lives, and by the records if there are any. `done` is called after
/// each answer with their number so far and in all.
pub fn study(lives: &[Life], records: &[faults::Measurements], seed: u64, done: &dyn Fn(usize, usize)) -> Study {
    // A decomposition split over threads would round differently with their number.
    faer::set_global_parallelism(faer::Par::Seq);
    let asked: Vec<_> =
        Reference::ALL.iter().flat_map(|reference| Question::ALL.map(|question| (question, *reference))).collect();
    let all = asked.len() + usize::from(!records.is_empty());
    let one = |(n, (question, reference)): (usize, (Question, Reference))| {
        let answer = answer(question.aim(), &|set| bearings(lives, question, reference, set), seed);
        done(n + 1, all);
        LifeAnswer { question, reference, answer }
    };
    let answers = asked.into_iter().enumerate().map(one).collect();
    let faults = (!records.is_empty()).then(|| answer(faults::AIM, &|set| faults::bearings(records, set), seed));
    done(all, all);
    Study { lives: answers, faults }
}

#[cfg(test)]
mod tests;
