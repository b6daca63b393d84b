//! Why a diagnosis cannot be made.

use crate::calibrate::CalibrateError;
use crate::force_balance::BalanceError;
use crate::rig::RigError;
use crate::whittle::observed::NotObserved;

/// What stands in the way.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DiagnoseError {
    /// A recording that lacks something.
    #[error(transparent)]
    Recording(#[from] NotObserved),
    /// The rig.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// Unknown parameters that cannot be fitted.
    #[error(transparent)]
    Calibrate(#[from] CalibrateError),
    /// A force balance that cannot be drawn up.
    #[error(transparent)]
    Balance(#[from] BalanceError),
    /// Nothing to diagnose.
    #[error("found no recordings, expected at least one")]
    Empty,
}
