//! Trained parameters in core's shapes.

use ballrace_core::Word;
use ballrace_core::network::float::weight_index;
use ballrace_core::network::{Arithmetic, FixedError, Network, fixed, to_fixed};

use super::layout::NetworkLayout;

/// Owned storage of a core network.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnedNetwork {
    /// Widths from input to output.
    pub widths: Vec<u16>,
    /// Arithmetic of the parameters.
    pub arithmetic: Arithmetic,
    /// Parameters in core's order.
    pub words: Vec<Word>,
}

impl OwnedNetwork {
    /// Core's network over these parameters.
    pub fn view(&self) -> Network<'_> {
        Network::new(&self.widths, self.arithmetic, &self.words).expect("shape and count follow from the layout")
    }

    /// Copy of a network in an arithmetic; the identity has no parameters to convert.
    ///
    /// # Errors
    /// [`FixedError`] of a network without a form in fixed point.
    pub fn converted(network: &Network<'_>, arithmetic: Arithmetic) -> Result<Self, FixedError> {
        let widths = network.widths().to_vec();
        if widths.is_empty() || network.arithmetic() == arithmetic {
            return Ok(Self { widths, arithmetic: network.arithmetic(), words: network.words().to_vec() });
        }
        if arithmetic == Arithmetic::Float {
            return Err(FixedError::Shape);
        }
        let mut words = vec![Word::default(); fixed::word_count(&widths).ok_or(FixedError::Shape)?];
        to_fixed(network, &mut words)?;
        Ok(Self { widths, arithmetic, words })
    }
}

/// Network in core's layout from a flat parameter vector.
pub fn network(layout: &NetworkLayout, parameters: &[f32]) -> OwnedNetwork {
    let mut words = Vec::new();
    for layer in layout.layers() {
        let start = words.len();
        words.resize(start + layer.inputs * layer.outputs, [0; 4]);
        let weights = &parameters[layer.weights.clone()];
        for (o, row) in weights.chunks_exact(layer.inputs).enumerate() {
            for (i, w) in row.iter().enumerate() {
                words[start + weight_index(layer.inputs, layer.outputs, o, i)] = w.to_le_bytes();
            }
        }
        words.extend(parameters[layer.biases.clone()].iter().map(|b| b.to_le_bytes()));
    }
    let widths = layout.widths().iter().map(|w| u16::try_from(*w).expect("widths within core's limits")).collect();
    OwnedNetwork { widths, arithmetic: Arithmetic::Float, words }
}
