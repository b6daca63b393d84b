//! Likelihood of recordings under a rig, and the rig of greatest likelihood: theory (54) to (58).
//!
//! | module | holds |
//! |---|---|
//! | [`observed`] | a recording in the frequency domain, theory (1) |
//! | [`tachometer`] | the tachometer's reading of the shaft's angle |
//! | [`whittle`] | a rig's prediction: D, fixed by the angles at the start, and S, the variance of the random part |
//! | [`align`] | those angles, theory (58) |
//! | [`coordinate`] | the sought numbers on the scale of a search |
//! | [`problem`] | likelihood, gradient and information at a point, theory (54) to (56) |
//! | [`search`] | the point of greatest likelihood, theory (57) |
//! | [`settings`] | thresholds, steps and counts |

pub mod align;
pub mod coordinate;
pub mod observed;
pub mod problem;
pub mod search;
pub mod settings;
pub mod tachometer;
#[cfg(test)]
mod tests;
pub mod whittle;
