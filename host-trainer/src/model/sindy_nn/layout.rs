//! Sizes of a SINDy-NN and the layout of its parameters in one flat vector.
//!
//! Encoder, decoder, Ξ; of a network layer by layer, weights (outputs × inputs, row-major), then
//! biases; Ξ as terms × equations, row-major.

use std::ops::Range;

use ballrace_core::library::Library;

use super::terms::Terms;

/// Widths of a network, from input to output, and its place in the parameters; no widths: identity.
#[derive(Clone, Debug, PartialEq)]
pub struct NetworkLayout {
    widths: Vec<usize>,
    start: usize,
}

/// Place of one dense layer in the parameters.
#[derive(Clone, Debug)]
pub struct LayerLayout {
    /// Number of inputs.
    pub inputs: usize,
    /// Number of outputs.
    pub outputs: usize,
    /// Range of the weights, outputs × inputs, row-major.
    pub weights: Range<usize>,
    /// Range of the biases.
    pub biases: Range<usize>,
}

impl NetworkLayout {
    fn new(widths: &[usize], start: usize) -> Self {
        Self { widths: widths.to_vec(), start }
    }

    /// Widths from input to output; empty for the identity.
    pub fn widths(&self) -> &[usize] {
        &self.widths
    }

    /// Layers in order.
    pub fn layers(&self) -> Vec<LayerLayout> {
        let mut at = self.start;
        let layer = |w: &[usize]| {
            let weights = at..at + w[0] * w[1];
            let biases = weights.end..weights.end + w[1];
            at = biases.end;
            LayerLayout { inputs: w[0], outputs: w[1], weights, biases }
        };
        self.widths.windows(2).map(layer).collect()
    }

    fn end(&self) -> usize {
        self.layers().last().map_or(self.start, |l| l.biases.end)
    }
}

/// Sizes of a SINDy-NN.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Number of inputs x and of derivatives ẋ.
    pub inputs: usize,
    /// Number of latent variables z.
    pub latent: usize,
    /// Encoder φ.
    pub encoder: NetworkLayout,
    /// Decoder ψ.
    pub decoder: NetworkLayout,
    /// Library in the latent variables.
    pub library: Library,
    /// Row operations of the library.
    pub terms: Terms,
}

impl Layout {
    /// Layout of widths from the inputs to the library's variables (`encoder`) and back (`decoder`); both empty for a
    /// model without networks. `None` for widths that do not match or an invalid library.
    pub fn new(encoder: &[usize], decoder: &[usize], library: Library) -> Option<Self> {
        let latent = usize::from(library.variables);
        let inputs = encoder.first().copied().unwrap_or(latent);
        let leads = |n: &[usize], from: usize, to: usize| match n {
            [] => from == to,
            [first, .., last] => *first == from && *last == to && n.iter().all(|w| *w > 0),
            [_] => false,
        };
        if !leads(encoder, inputs, latent) || !leads(decoder, latent, inputs) || !library.is_valid() {
            return None;
        }
        let encoder = NetworkLayout::new(encoder, 0);
        let decoder = NetworkLayout::new(decoder, encoder.end());
        Some(Self { inputs, latent, encoder, decoder, library, terms: Terms::new(library) })
    }

    /// Range of Ξ, terms × equations, row-major.
    pub fn xi(&self) -> Range<usize> {
        let start = self.decoder.end();
        start..start + self.terms.count() * self.latent
    }

    /// Number of parameters.
    pub fn parameter_count(&self) -> usize {
        self.xi().end
    }

    /// Multiply-adds of one sample's loss and gradient: every product of the forward pass once, and
    /// twice more going back, less the gradient with respect to the measured inputs.
    pub fn multiply_adds(&self) -> usize {
        let network = |n: &NetworkLayout| n.widths.windows(2).map(|w| 2 * w[0] * w[1]).sum::<usize>();
        let first = self.encoder.widths.get(..2).map_or(0, |w| 2 * w[0] * w[1]);
        let xi = self.xi().len();
        3 * (network(&self.encoder) + network(&self.decoder) + xi) - first
    }

    /// Sigmoids of one sample's loss.
    pub fn sigmoids(&self) -> usize {
        let hidden = |n: &NetworkLayout| n.widths.iter().skip(1).rev().skip(1).sum::<usize>();
        hidden(&self.encoder) + hidden(&self.decoder)
    }
}
