//! From a vibration recording to a sparse dynamics model on a microcontroller.
#![forbid(unsafe_code)]

pub mod files;
pub mod fit;
pub mod model;
pub mod recording;
pub mod sindy_nn;
pub mod states;
pub mod stlsq;
pub mod surrogate;
