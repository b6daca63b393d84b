//! Models of a recording's dynamics: virtual states, SINDy-NN, STLSQ, scores, export, replay.

pub mod baseline;
pub mod budget;
pub mod export;
pub mod file;
pub mod fit;
mod owned;
pub mod path;
pub mod replay;
pub mod samples;
pub mod sindy_nn;
pub mod states;
pub mod stlsq;
pub mod trace;

pub use owned::{OwnedModel, Parts};
