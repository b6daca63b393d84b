//! How likely recordings are under a rig, and the rig under which they are most likely.
//!
//! | module | holds |
//! |---|---|
//! | [`observed`] | a recording in the frequency domain |
//! | [`tachometer`] | what its tachometer says of the shaft's angle |
//! | [`likelihood`] | what a rig says of it: D, fixed by the angles at its start, and S, the variance of its random part |
//! | [`align`] | those angles |
//! | [`coordinate`] | what is sought, as a search sees it |
//! | [`problem`] | likelihood, gradient and information at a point |
//! | [`search`] | the most likely point |

pub mod align;
pub mod coordinate;
pub mod likelihood;
pub mod observed;
pub mod problem;
pub mod search;
pub mod tachometer;
#[cfg(test)]
mod tests;
