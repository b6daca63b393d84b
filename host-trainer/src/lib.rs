//! From a vibration recording to a sparse dynamics model on a microcontroller.
//!
//! Data flows one way, and each layer knows only the layers above it in this table (a test holds the order):
//!
//! | layer | holds | takes → gives |
//! |---|---|---|
//! | [`stats`] | significance, optimisation, numbers as text | |
//! | [`recording`] | readers, units, resampling, writers | files → [`Recording`] |
//! | [`signal`] | spectra, envelopes, orders, speed, kinematics, surrogates | samples → spectra, lines |
//! | [`rig`] | the 5-DoF and the one-degree-of-freedom rig, effects, simulation | [`Rig`] → [`Recording`] |
//! | [`model`] | virtual states, SINDy-NN, STLSQ, scores, export, replay on the device's code | series → [`OwnedModel`] |
//! | [`identify`] | parameters of a rig: likelihood, force balance, calibration | rig, recordings → rig |
//! | [`diagnose`] | what the rig leaves out: location, cause, corrected rig | rig, recordings → diagnosis |
//! | [`report`] | HTML documents and plots | results → HTML, SVG |
//! | [`evaluate`] | how often a diagnosis is right, on concealed cases | seed → score |
//! | [`cli`] | the commands and the demo | arguments → files, text |
#![forbid(unsafe_code)]

pub mod cli;
pub mod diagnose;
pub mod evaluate;
pub mod identify;
pub mod model;
pub mod recording;
pub mod report;
pub mod rig;
pub mod signal;
pub mod stats;

pub use diagnose::{Task, diagnose};
pub use identify::calibrate::calibrate;
pub use model::OwnedModel;
pub use model::fit::{FitConfig, Fitted, fit};
pub use model::replay::replay;
pub use recording::{Recording, load};
pub use rig::{EffectEntry, Rig, simulate};
