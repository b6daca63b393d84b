//! Pictures as SVG, one module each; [`style`] has what they share, [`settings`] their layout.

pub mod comparison;
pub mod cycle;
pub mod density;
pub mod derivative;
pub mod envelope;
#[cfg(feature = "fleet")]
pub mod fleet_trend;
pub mod frontier;
pub mod indicators;
pub mod kurtogram;
pub mod life;
pub mod lines;
pub mod marks;
pub mod ratings;
pub mod residual;
pub mod settings;
pub mod style;
pub mod time_axis;
pub mod trend;

/// Error of the drawing library, or nothing to draw.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw: {0}")]
pub struct DrawError(String);

impl DrawError {
    fn new(error: impl std::fmt::Display) -> Self {
        Self(error.to_string())
    }

    fn empty() -> Self {
        Self("there is nothing to show".into())
    }
}
