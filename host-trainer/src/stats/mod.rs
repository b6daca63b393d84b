//! Statistics, optimisation and numbers as text, open to every other layer.

pub mod format;
pub mod optimise;
pub mod settings;
pub mod significance;
