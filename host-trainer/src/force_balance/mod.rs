//! The rig of one degree of freedom against recordings: what its parameters are, and which forces it lacks.
//!
//! The equation of motion, filtered term by term, is a linear regression: gain · u less what the known parameters
//! explain, on what the unknown ones and each named effect would add (SINDy's sparse regression on a library of physical
//! terms; Brunton, Proctor, Kutz, PNAS 2016). [`calibrate_sdof`] fits the unknown parameters.
//!
//! | module | step |
//! |---|---|
//! | `filter`, `noise` | kernels that keep the equation exact; band and noise from the data |
//! | `states` | recordings to filtered states |
//! | `equation` | the rig's own columns, and the target |
//! | `regression` | estimates, intervals on correlated rows, what is not determined |
//! | `shooting` | the same parameters by simulation, window by window |
//! | `calibrate` | which of both to believe |

mod calibrate;
mod equation;
mod error;
mod filter;
mod gram;
mod held;
mod noise;
mod regression;
mod shooting;
mod states;
#[cfg(test)]
mod testing;

pub use calibrate::{Calibration, Estimate, Method, calibrate_sdof};
pub use error::BalanceError;
pub use states::{Sensed, States};
