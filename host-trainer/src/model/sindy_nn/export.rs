//! Trained parameters in core's shapes.

use ballrace_core::network::{Network, weight_index};
use ballrace_core::{Floats, Word};

use super::layout::NetworkLayout;

/// Owned storage of a core network.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnedNetwork {
    /// Widths from input to output.
    pub widths: Vec<u16>,
    /// Parameters in core's order.
    pub words: Vec<Word>,
}

impl OwnedNetwork {
    /// Core's network over these parameters.
    pub fn view(&self) -> Network<'_> {
        Network::new(&self.widths, Floats(&self.words)).expect("shape and count follow from the layout")
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
    OwnedNetwork { widths, words }
}
