//! The rig of one degree of freedom against recordings: what its parameters are, and which forces it lacks.
//!
//! The equation of motion, filtered term by term, is a linear regression: gain · u less what the known parameters
//! explain, on what the unknown ones and each named effect would add (SINDy's sparse regression on a library of physical
//! terms; Brunton, Proctor, Kutz, PNAS 2016). [`calibrate_sdof`] fits the unknown parameters,
//! [`diagnose_sdof`] lets the effects compete.
//!
//! | module | step |
//! |---|---|
//! | `filter`, `noise` | kernels that keep the equation exact; band and noise from the data |
//! | `states` | recordings to filtered states |
//! | `equation` | the rig's own columns, and the target |
//! | `regression` | estimates, intervals on correlated rows, what is not determined |
//! | `shooting` | the same parameters by simulation, window by window |
//! | `calibrate` | which of both to believe |
//! | `acquisition`, `events` | faults that show in the samples themselves, or once |
//! | `terms`, `flexible` | what each effect would add, and columns without a name |
//! | `gram`, `table` | every hypothesis on rows that it was not fitted to |
//! | `decide` | which causes the data ask for, and whether by chance |
//! | `causes`, `refine` | coefficients to effects with parameters and intervals |
//! | `diagnose` | all of it, with words, places and traces |

pub(crate) mod calibrate;
pub(crate) mod equation;
mod error;
mod filter;
pub(crate) mod gram;
mod held;
pub(crate) mod noise;
pub(crate) mod refine;
pub(crate) mod regression;
pub(crate) mod shooting;
pub(crate) mod states;
#[cfg(test)]
pub(crate) mod testing;
pub(crate) mod traces;

pub use calibrate::{Estimate, HeldOutError, Method, SdofCalibration, calibrate_sdof};
pub use error::BalanceError;
pub use states::{Sensed, States};
pub use traces::HeldOutTrace;
