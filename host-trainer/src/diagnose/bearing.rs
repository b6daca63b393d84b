//! Diagnosis of the 5-DoF rig.

use super::error::DiagnoseError;
use super::outcome::Outcome;
use crate::recording::Recording;
use crate::rig::{Rig, RigError};

/// Names what is the matter with a bearing rig.
///
/// # Errors
/// Always, for now: the parts are there, what calls them one after the other is not.
pub fn diagnose(
    rig: &Rig,
    _baseline: Option<&[Recording]>,
    _recordings: &[Recording],
    _seed: u64,
    _progress: &dyn Fn(&str),
) -> Result<Outcome, DiagnoseError> {
    let found = format!("{:?}, which cannot be diagnosed yet", rig.model.kind());
    Err(RigError::BadCondition { field: "kind", found, expected: "\"sdof\"" }.into())
}
