//! Parameters of a rig of one degree of freedom by force balance and simulation, theory (62) to (69).
//!
//! The equation of motion, filtered term by term, is a linear regression: gain · u minus the terms of the known
//! parameters, on the terms of the unknown ones and of each named effect (SINDy's sparse regression on a library of
//! physical terms; Brunton, Proctor, Kutz, PNAS 2016). [`calibrate_sdof`] fits the unknown parameters; `diagnose` lets the
//! effects compete.
//!
//! | module | step |
//! |---|---|
//! | `filter`, `noise` | kernels that keep the equation exact, theory (63) to (65); band and noise from the data |
//! | `states`, `held` | recordings to filtered states; the input between its samples |
//! | `equation` | the rig's own columns, and the target, theory (62) |
//! | `regression` | estimates, intervals on correlated rows, undetermined combinations, theory (66) |
//! | `shooting` | the same parameters by simulation, window by window, theory (67) |
//! | `calibrate` | the choice between both, theory (68) |
//! | `smoother` | states of any sampled position, theory (65) |
//! | `predictor` | columns of a regression whose rows are white, theory (69) |
//! | `gram` | inner products of such columns, and held-out errors |
//! | `traces` | held-out recordings, simulated |
//! | `settings` | thresholds, lengths and counts |

pub(crate) mod calibrate;
pub(crate) mod equation;
mod error;
mod filter;
pub(crate) mod gram;
mod held;
pub(crate) mod noise;
pub(crate) mod predictor;
pub(crate) mod regression;
pub(crate) mod settings;
pub(crate) mod shooting;
pub(crate) mod smoother;
pub(crate) mod states;
#[cfg(test)]
pub(crate) mod testing;
pub(crate) mod traces;

pub use calibrate::{Estimate, HeldOutError, Method, SdofCalibration, calibrate_sdof};
pub use error::BalanceError;

pub use traces::HeldOutTrace;
