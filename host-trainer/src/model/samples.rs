//! Training samples, as both solvers take them.

use super::sindy_nn::real::Real;

/// Training samples, standardised: rows of x and of ẋ.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples<T> {
    /// Values in a row.
    pub inputs: usize,
    /// Rows of x, one sample after the other.
    pub x: Vec<T>,
    /// Rows of ẋ.
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

    /// x and ẋ of one sample.
    pub fn row(&self, s: usize) -> (&[T], &[T]) {
        let range = s * self.inputs..(s + 1) * self.inputs;
        (&self.x[range.clone()], &self.dx[range])
    }
}
