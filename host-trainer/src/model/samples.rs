//! Training samples of both solvers.

use super::sindy_nn::real::Real;

/// Rows of states x and targets ẋ; standardised by theory (6) before a fit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples<T> {
    /// Values in a row of x, and of ẋ.
    pub inputs: usize,
    /// Rows of x, row-major.
    pub x: Vec<T>,
    /// Rows of ẋ, row-major.
    pub dx: Vec<T>,
}

impl<T: Real> Samples<T> {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.x.len().checked_div(self.inputs).unwrap_or(0)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// States x and targets ẋ of one sample.
    pub fn row(&self, s: usize) -> (&[T], &[T]) {
        let range = s * self.inputs..(s + 1) * self.inputs;
        (&self.x[range.clone()], &self.dx[range])
    }
}
