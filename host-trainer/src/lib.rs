//! ballrace.

pub mod recording;
