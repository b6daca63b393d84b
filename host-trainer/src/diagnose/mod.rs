//! What did the simulation leave out?
pub mod compete;
pub mod hypothesis;
pub mod screen;
