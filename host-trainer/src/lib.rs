//! From a vibration recording to a sparse dynamics model on a microcontroller.
#![forbid(unsafe_code)]

pub mod atomic_write;
pub mod calibrate;
pub mod cases;
pub mod commands;
pub mod demo;
pub mod diagnose;
pub mod evaluate;
pub mod export;
pub mod fit;
pub mod force_balance;
pub mod input;
pub mod model;
pub mod model_file;
pub mod plot;
pub mod recording;
pub mod replay;
pub mod report;
pub mod rig;
pub mod signal;
pub mod significance;
pub mod sindy_nn;
pub mod spectra;
pub mod states;
pub mod stlsq;
pub mod surrogate;
pub mod trace;
pub mod whittle;
