//! Diagnosis of a mismatch between a rig and recordings: causes, parameters, location.
//!
//! | module | holds |
//! |---|---|
//! | [`result`] | result of a diagnosis |
//! | [`mod@write`] | a diagnosis as a folder |
//! | [`sdof`] | the rig of one degree of freedom |
//! | [`faults`] | acquisition faults in held-out recordings of an sdof rig |
//! | [`bearing`] | the 5-DoF rig |
//! | [`data_split`] | fitted, held-out and screening recordings |
//! | [`envelope`] | real recordings, where the structure is unknown |
//! | [`acquisition`] | faults between sensor and file |
//! | [`residual`] | whitened residual and its lack of fit |
//! | [`initial_guesses`] | where a search in time or frequency starts |
//! | [`hypothesis`] | candidate effects with starts of their search |
//! | [`start_score`] | expected gain of a start |
//! | [`screening`] | screening of all candidates |
//! | [`refine_starts`] | refinement of the screened starts |
//! | [`model_selection`] | fits of the best candidates and their gains |
//! | [`explain`] | null model, and the one or two causes that explain its residual |
//! | `findings` | causes, rejected candidates and fit of a diagnosis |
//! | [`validation`] | fit of a correction to held-out recordings |
//! | [`statistics`] | statistics of a residual |
//! | [`evidence`] | significance tests of those statistics |
//! | [`baseline_test`] | tests of real recordings against the healthy machine's |
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

/// Rig and recordings to diagnose.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// Nominal rig.
    pub rig: &'a Rig,
    /// Recordings of the healthy machine.
    pub baseline: Option<&'a [Recording]>,
    /// Recordings to diagnose, at least one.
    pub recordings: &'a [Recording],
    /// Seed of simulations and permutations.
    pub seed: u64,
}

/// Diagnoses a rig of either kind. `progress` gets each step in words.
///
/// # Errors
/// Recordings or a rig that lack something required.
pub fn diagnose(task: &Task, progress: &dyn Fn(&str)) -> Result<result::DiagnosisResult, DiagnoseError> {
    if task.recordings.is_empty() {
        return Err(DiagnoseError::Empty);
    }
    match task.rig.model {
        Machine::Sdof(_) => sdof::diagnose(task, progress),
        Machine::Bearing(_) => bearing::diagnose(task, progress),
    }
}
