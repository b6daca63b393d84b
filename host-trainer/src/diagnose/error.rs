//! Why there is no diagnosis.

use crate::identify::calibrate::CalibrateError;
use crate::identify::force_balance::BalanceError;
use crate::identify::likelihood::observed::NotObserved;
use crate::rig::RigError;

/// Why there is no diagnosis.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DiagnoseError {
    /// A recording that lacks something.
    #[error(transparent)]
    Recording(#[from] NotObserved),
    /// The rig.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// The baseline.
    #[error("baseline: {0}")]
    Calibrate(#[from] CalibrateError),
    /// A rig of one degree of freedom.
    #[error(transparent)]
    Balance(#[from] BalanceError),
    /// A rig of another kind where only a bearing's will do.
    #[error("kind: found {found:?}, expected \"bearing-5dof\"")]
    NotBearing {
        /// The kind.
        found: &'static str,
    },
    /// Nothing to diagnose.
    #[error("found no recordings, expected at least one")]
    Empty,
}
