//! Statistics, optimisation, cancellation and numbers as text, open to every other layer.

pub mod cancel;
pub mod format;
pub(crate) mod optimise;
pub(crate) mod settings;
pub(crate) mod significance;
pub mod units;
