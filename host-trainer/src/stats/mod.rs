//! Statistics, optimisation and numbers as text: what every other layer may use.

pub mod format;
pub mod optimise;
pub mod significance;
