//! From a vibration recording to a sparse dynamics model on a microcontroller.
#![forbid(unsafe_code)]

pub mod calibrate;
pub mod commands;
pub mod concealed;
pub mod demo;
pub mod diagnose;
pub mod export;
pub mod files;
pub mod fit;
pub mod force_balance;
pub mod input;
pub mod model;
pub mod model_file;
pub mod plot;
pub mod proof;
pub mod recording;
pub mod report;
pub mod rig;
pub mod signal;
pub mod significance;
pub mod sindy_nn;
pub mod spectra;
pub mod states;
pub mod stlsq;
pub mod surrogate;
pub mod watch;
pub mod whittle;
pub mod window;
