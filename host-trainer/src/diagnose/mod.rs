//! What did the simulation leave out?
//!
//! | module | holds |
//! |---|---|
//! | [`result`] | what a diagnosis says |
//! | [`mod@write`] | a diagnosis as a folder |
//! | [`sdof`] | the rig of one degree of freedom |
//! | [`faults`] | what sensor and cable do, beside recordings that took no part |
//! | [`bearing`] | the 5-DoF rig |
//! | [`data_split`] | its recordings by the part that they take |
//! | [`envelope`] | real recordings, where the structure is unknown |
//! | [`acquisition`] | faults between sensor and file |
//! | [`residual`] | what the rig leaves, and whether chance could |
//! | [`initial_guesses`] | where a search in time or frequency starts |
//! | [`hypothesis`] | every explanation, and where a search for it starts |
//! | [`start_score`] | what a place to start from scores |
//! | [`screening`] | a first look at all of them |
//! | [`refine_starts`] | a closer look at what that found |
//! | [`model_selection`] | the best of them, fitted, and what each gains |
//! | [`explain`] | what the rig leaves, and the one or two causes that explain it |
//! | `findings` | what the selection has found, as causes, rejected explanations and a fit |
//! | [`validation`] | what a correction does to recordings that took no part |
//! | [`statistics`] | what is asked of a residual, number by number |
//! | [`evidence`] | whether, and where: tests, each against what chance gives |
//! | [`baseline_test`] | the same of real recordings, beside the healthy machine's |
//! | [`locate`] | where the mismatch is |

pub mod acquisition;
pub mod baseline_test;
pub mod bearing;
pub mod causes;
pub mod data_split;
pub mod envelope;
mod error;
pub mod evidence;
pub mod explain;
pub mod faults;
mod findings;
pub mod hypothesis;
pub mod initial_guesses;
pub mod locate;
pub mod model_selection;
pub mod refine_starts;
pub mod residual;
pub mod result;
pub mod screening;
pub mod sdof;
pub mod start_score;
pub mod statistics;
#[cfg(test)]
mod tests;
pub mod validation;
pub mod write;

pub use error::DiagnoseError;

use crate::recording::Recording;
use crate::rig::{Machine, Rig};

/// What is to be diagnosed.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// The rig as the engineer knows it.
    pub rig: &'a Rig,
    /// Recordings of the healthy machine.
    pub baseline: Option<&'a [Recording]>,
    /// Recordings that the rig may leave something of.
    pub recordings: &'a [Recording],
    /// Seed of simulations and permutations.
    pub seed: u64,
}

/// Names what is the matter with a rig of either kind. `progress` is told what is being done.
///
/// # Errors
/// Recordings or a rig that lack something.
pub fn diagnose(task: &Task, progress: &dyn Fn(&str)) -> Result<result::DiagnosisResult, DiagnoseError> {
    if task.recordings.is_empty() {
        return Err(DiagnoseError::Empty);
    }
    match task.rig.model {
        Machine::Sdof(_) => sdof::diagnose(task, progress),
        Machine::Bearing(_) => bearing::diagnose(task, progress),
    }
}
