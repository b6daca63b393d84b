//! Uncertain parameters of a rig from recordings of the healthy machine, theory (59) to (61).
//!
//! [`bearing`] maximises the likelihood of the recordings (`likelihood`) over the parameters
//! that the rig's file calls `unknown`, the noise levels, and the angles at each recording's start. Intervals come from the
//! expected information, with the angles free, and from the scatter of the scores over bands ([`estimate::covariance`]);
//! undetermined combinations are reported ([`estimate::Undetermined`]).
//!
//! A real machine has a structure between bearing and sensor that no rig of five degrees of freedom has. If the calibrated
//! rig does not fit the recordings' spectra, that path is identified as an all-pole filter (`transfer_path`); amplitudes
//! then carry no information on the rig's parameters, which stay as they were.

pub mod bearing;
pub(crate) mod distance;
pub mod estimate;
pub(crate) mod settings;
pub(crate) mod split;
#[cfg(test)]
mod tests;
pub(crate) mod transfer_path;

pub use bearing::{Calibration, calibrate};

/// Errors of a calibration.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrateError {
    /// Recording without a needed channel, speed or load.
    #[error(transparent)]
    Recording(#[from] crate::identify::likelihood::observed::NotObserved),
    /// Rig that cannot be simulated.
    #[error(transparent)]
    Rig(#[from] crate::rig::RigError),
    /// Key of a whole number, which cannot be fitted.
    #[error("unknown: found {key}, a whole number, expected parameters that can change by little")]
    Whole {
        /// The key.
        key: String,
    },
    /// No recordings.
    #[error("found no recordings, expected at least one")]
    Empty,
}
