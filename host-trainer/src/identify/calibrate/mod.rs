//! A rig's uncertain parameters from recordings of the healthy machine.
//!
//! [`bearing`] maximises the likelihood of the recordings ([`whittle`](crate::identify::likelihood)) over the parameters that the rig's
//! file calls `unknown`, the noise levels, and the angles at which each recording began. Intervals come from the expected
//! information, with the angles free, and from how much bands of the recordings disagree ([`estimate::covariance`]); what the
//! recordings do not determine is said ([`estimate::Undetermined`]).
//!
//! A real machine has a structure between bearing and sensor that no rig of five degrees of freedom has. Where the
//! calibrated rig does not come near the recordings' spectra, that path is identified as well, as an all-pole filter
//! ([`path`]); then amplitudes say nothing of the rig's parameters any more, which stay as they were.

pub mod bearing;
pub mod distance;
pub mod estimate;
pub mod split;
#[cfg(test)]
mod tests;
pub mod transfer_path;

pub use bearing::{Calibration, calibrate};

/// Why a rig cannot be calibrated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrateError {
    /// A recording that lacks something.
    #[error(transparent)]
    Recording(#[from] crate::identify::likelihood::observed::NotObserved),
    /// The rig.
    #[error(transparent)]
    Rig(#[from] crate::rig::RigError),
    /// A key that cannot be fitted.
    #[error("unknown: found {key}, a whole number, expected parameters that can change by little")]
    Whole {
        /// The key.
        key: String,
    },
    /// Nothing to fit to.
    #[error("found no recordings, expected at least one")]
    Empty,
}
