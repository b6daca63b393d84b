//! What did the simulation leave out?
//!
//! | module | holds |
//! |---|---|
//! | [`outcome`] | what a diagnosis says |
//! | [`sdof`] | the rig of one degree of freedom |
//! | [`faults`] | what sensor and cable do, beside recordings that took no part |
//! | [`bearing`] | the 5-DoF rig |
//! | [`error`] | why a diagnosis cannot be made |
//! | [`mod@write`] | a diagnosis as a folder |
//! | [`hypothesis`] | every explanation, and where a search for it starts |
//! | [`screen`] | a first look at all of them |
//! | [`compete`] | the best of them, fitted, and what each gains |

pub mod bearing;
pub mod compete;
pub mod error;
pub mod faults;
pub mod hypothesis;
pub mod outcome;
pub mod screen;
pub mod sdof;
pub mod write;

use crate::recording::Recording;
use crate::rig::{Model, Rig};

/// Names what is the matter with a rig of either kind. `baseline` are recordings of the healthy machine; `progress` is
/// told what is being done.
///
/// # Errors
/// Recordings or a rig that lack something.
pub fn diagnose(
    rig: &Rig,
    baseline: Option<&[Recording]>,
    recordings: &[Recording],
    seed: u64,
    progress: &dyn Fn(&str),
) -> Result<outcome::Outcome, error::DiagnoseError> {
    match rig.model {
        Model::Sdof(_) => sdof::diagnose(rig, baseline, recordings, seed, progress),
        Model::Bearing(_) => bearing::diagnose(rig, baseline, recordings, seed, progress),
    }
}
