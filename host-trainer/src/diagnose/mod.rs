//! What did the simulation leave out?
//!
//! | module | holds |
//! |---|---|
//! | [`outcome`] | what a diagnosis says |
//! | [`hypothesis`] | every explanation, and where a search for it starts |
//! | [`screen`] | a first look at all of them |
//! | [`compete`] | the best of them, fitted, and what each gains |

pub mod compete;
pub mod hypothesis;
pub mod outcome;
pub mod screen;
