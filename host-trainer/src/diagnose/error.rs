//! Errors of a diagnosis.

use crate::identify::calibrate::CalibrateError;
use crate::identify::force_balance::BalanceError;
use crate::identify::likelihood::observed::NotObserved;
use crate::rig::RigError;

/// Error of a diagnosis.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DiagnoseError {
    /// Recording that lacks a channel or a condition.
    #[error(transparent)]
    Recording(#[from] NotObserved),
    /// Error of the rig or its simulation.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// Error of the calibration to the baseline.
    #[error("baseline: {0}")]
    Calibrate(#[from] CalibrateError),
    /// Error of the force balance of a rig of one degree of freedom.
    #[error(transparent)]
    Balance(#[from] BalanceError),
    /// Rig that is no bearing rig.
    #[error("kind: found {found:?}, expected \"bearing-5dof\"")]
    NotBearing {
        /// Kind of the rig.
        found: &'static str,
    },
    /// No recordings.
    #[error("found no recordings, expected at least one")]
    Empty,
}
