//! Pictures, as SVG: a file a figure, [`style`] for what they share.

pub mod comparison;
pub mod cycle;
pub mod density;
pub mod derivative;
pub mod envelope;
pub mod kurtogram;
pub mod lines;
pub mod residual;
pub mod style;
pub mod trend;

/// A picture could not be drawn.
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
