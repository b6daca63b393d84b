//! What did the simulation leave out?
//!
//! | module | holds |
//! |---|---|
//! | [`outcome`] | what a diagnosis says |
//! | [`acquisition`] | faults between sensor and file |
//! | [`bearing`] | diagnosis of the 5-DoF rig |
//! | [`residual`] | what the rig leaves, and whether chance could |
//! | [`pointers`] | where a search in time or frequency starts |
//! | [`hypothesis`] | every explanation, and where a search for it starts |
//! | [`screen`] | a first look at all of them |
//! | [`compete`] | the best of them, fitted, and what each gains |
//! | [`prove`] | what a correction does to recordings that took no part |
//! | [`locate`] | where the mismatch is |

pub mod acquisition;
pub mod bearing;
pub mod compete;
mod error;
pub mod hypothesis;
pub mod locate;
pub mod outcome;
pub mod pointers;
pub mod prove;
pub mod residual;
pub mod screen;
#[cfg(test)]
mod tests;

pub use error::DiagnoseError;
