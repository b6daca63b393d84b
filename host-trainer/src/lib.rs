//! From a vibration recording to a sparse dynamics model on a microcontroller.
#![forbid(unsafe_code)]

pub mod recording;
pub mod rig;
pub mod sindy_nn;
pub mod states;
pub mod stlsq;
pub mod surrogate;
