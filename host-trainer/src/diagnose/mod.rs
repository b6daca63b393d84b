//! What did the simulation leave out?
//!
//! | module | holds |
//! |---|---|
//! | [`outcome`] | what a diagnosis says |
//! | [`mod@write`] | a diagnosis as a folder |
//! | [`sdof`] | the rig of one degree of freedom |
//! | [`faults`] | what sensor and cable do, beside recordings that took no part |
//! | [`bearing`] | the 5-DoF rig |
//! | [`sets`] | its recordings by the part that they take |
//! | [`recorded`] | real recordings, where the structure is unknown |
//! | [`acquisition`] | faults between sensor and file |
//! | [`residual`] | what the rig leaves, and whether chance could |
//! | [`pointers`] | where a search in time or frequency starts |
//! | [`hypothesis`] | every explanation, and where a search for it starts |
//! | [`promise`] | what a place to start from promises |
//! | [`screen`] | a first look at all of them |
//! | [`closer`] | a closer look at what that found |
//! | [`compete`] | the best of them, fitted, and what each gains |
//! | [`explain`] | what the rig leaves, and the one or two causes that explain it |
//! | `statement` | what the contest has found, as causes, rejected explanations and a fit |
//! | [`prove`] | what a correction does to recordings that took no part |
//! | [`statistics`] | what is asked of a residual, number by number |
//! | [`evidence`] | whether, and where: tests, each against what chance gives |
//! | [`beside`] | the same of real recordings, beside the healthy machine's |
//! | [`locate`] | where the mismatch is |

pub mod acquisition;
pub mod bearing;
pub mod beside;
pub mod closer;
pub mod compete;
mod error;
pub mod evidence;
pub mod explain;
pub mod faults;
pub mod hypothesis;
pub mod locate;
pub mod outcome;
pub mod pointers;
pub mod promise;
pub mod prove;
pub mod recorded;
pub mod residual;
pub mod screen;
pub mod sdof;
pub mod sets;
mod statement;
pub mod statistics;
#[cfg(test)]
mod tests;
pub mod write;

pub use error::DiagnoseError;

use crate::recording::Recording;
use crate::rig::{Model, Rig};

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
pub fn diagnose(task: &Task, progress: &dyn Fn(&str)) -> Result<outcome::Outcome, DiagnoseError> {
    if task.recordings.is_empty() {
        return Err(DiagnoseError::Empty);
    }
    match task.rig.model {
        Model::Sdof(_) => sdof::diagnose(task, progress),
        Model::Bearing(_) => bearing::diagnose(task, progress),
    }
}
