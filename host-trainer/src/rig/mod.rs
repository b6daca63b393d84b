//! The rig: simulation of a machine from what the engineer knows of it, and of what can be the matter with it.

pub mod bearing;
pub mod config;
pub mod effect;
mod error;
pub mod kinematics;
mod noise;
pub mod plan;
pub mod sdof;
pub mod simulate;
#[cfg(test)]
mod simulate_tests;
#[cfg(test)]
mod test_support;

pub use config::{EffectEntry, Model, Rig, Value};
pub use error::RigError;
pub use simulate::{OperatingCondition, Run, Start, simulate, simulate_many};
