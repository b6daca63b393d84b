//! Encoder φ and decoder ψ, theory (9) and (12): sigmoid on hidden layers, linear output; in `f32` or in 16-bit fixed point.
//!
//! [`float`] and [`fixed`] hold both forms of the parameters and their kernels, [`to_fixed`] converts.

mod convert;
pub mod fixed;
pub mod float;

pub use convert::{FixedError, to_fixed};

use heapless::Vec;

use crate::{Floats, Word};
use fixed::Fixed;

/// Greatest number of layers of a network.
pub const MAX_LAYERS: usize = 6;
/// Greatest width of a layer.
pub const MAX_WIDTH: usize = 1024;

/// Arithmetic of a network.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Arithmetic {
    /// Single precision.
    #[default]
    Float,
    /// 16-bit fixed point, for one hidden layer.
    Fixed,
}

/// A feed-forward network whose parameters lie in flash; no layers is the identity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Network<'a> {
    widths: Vec<u16, { MAX_LAYERS + 1 }>,
    words: &'a [Word],
    /// Parts of the words; `None` in single precision.
    fixed: Option<Fixed<'a>>,
}

impl<'a> Network<'a> {
    /// Network of `widths` from input to output (empty for the identity) with `words` in the order of [`float`] or
    /// [`fixed`]; `None` if a width is 0 or over [`MAX_WIDTH`], the layers are too many, or the words' number differs.
    pub fn new(widths: &[u16], arithmetic: Arithmetic, words: &'a [Word]) -> Option<Self> {
        let in_range = widths.iter().all(|&w| (1..=MAX_WIDTH).contains(&usize::from(w)));
        let (fits, fixed) = match arithmetic {
            Arithmetic::Float => (widths.len() != 1 && float::word_count(widths) == words.len(), None),
            Arithmetic::Fixed => (true, Some(Fixed::new(widths, words)?)),
        };
        let widths = Vec::from_slice(widths).ok()?;
        (in_range && fits).then_some(Self { widths, words, fixed })
    }

    /// Widths from input to output; empty for the identity.
    pub fn widths(&self) -> &[u16] {
        &self.widths
    }

    /// Arithmetic of the parameters.
    pub fn arithmetic(&self) -> Arithmetic {
        if self.fixed.is_some() { Arithmetic::Fixed } else { Arithmetic::Float }
    }

    /// Parameters in their stored order.
    pub fn words(&self) -> &'a [Word] {
        self.words
    }

    /// Index of the first parameter that is a number of `f32` and not finite.
    pub fn first_not_finite(&self) -> Option<usize> {
        let floats = self.fixed.map_or(Floats(self.words), |fixed| fixed.biases());
        let before = self.words.len() - floats.len();
        floats.iter().position(|v| !v.is_finite()).map(|i| before + i)
    }

    /// Widths of the hidden layers.
    fn hidden(&self) -> impl Iterator<Item = usize> + '_ {
        let last = self.widths.len().saturating_sub(1);
        self.widths.get(1..last).unwrap_or(&[]).iter().map(|&w| usize::from(w))
    }

    /// Width of the widest hidden layer.
    pub fn hidden_width(&self) -> usize {
        self.hidden().max().unwrap_or(0)
    }

    /// Floats of scratch of [`Network::forward`].
    pub fn forward_scratch_len(&self) -> usize {
        match self.fixed {
            None => 2 * self.hidden_width(),
            Some(fixed) => fixed.scratch_len(),
        }
    }

    /// Floats of scratch of [`Network::tangent`].
    pub fn tangent_scratch_len(&self) -> usize {
        match self.fixed {
            None => 4 * self.hidden_width(),
            Some(fixed) => fixed.scratch_len(),
        }
    }

    /// Multiplications of one forward pass.
    pub fn multiply_adds(&self) -> usize {
        self.widths.windows(2).map(|w| usize::from(w[0]) * usize::from(w[1])).sum()
    }

    /// Sigmoids of one pass.
    pub fn sigmoids(&self) -> usize {
        self.hidden().sum()
    }

    /// Computes y = network(x), theory (9).
    pub fn forward(&self, x: &[f32], y: &mut [f32], scratch: &mut [f32]) {
        match &self.fixed {
            Some(network) => network.forward(x, y, scratch),
            None => float::forward(self, x, y, scratch),
        }
    }

    /// Computes dy = (∂network/∂x)(x) dx, theory (11) and (12), without the value itself.
    pub fn tangent(&self, x: &[f32], dx: &[f32], dy: &mut [f32], scratch: &mut [f32]) {
        match &self.fixed {
            Some(network) => network.tangent(x, dx, dy, scratch),
            None => float::tangent(self, x, dx, dy, scratch),
        }
    }
}

/// Number of words of a network of these widths; `None` for a shape without a form in this arithmetic.
pub fn word_count(widths: &[u16], arithmetic: Arithmetic) -> Option<usize> {
    match arithmetic {
        Arithmetic::Float => Some(float::word_count(widths)),
        Arithmetic::Fixed => fixed::word_count(widths),
    }
}

#[cfg(test)]
mod tests;
