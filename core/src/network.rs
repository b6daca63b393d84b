//! Dense layers of encoder φ and decoder ψ, theory (9) and (12): sigmoid on hidden layers, linear output.
//!
//! Parameters lie layer by layer: weights, then biases. A layer's weights lie in panels of
//! [`PANEL`] outputs, each panel input by input, so that a step over one input reads its panel's
//! weights in sequence ([`weight_index`] is the definition). An output is its bias plus its
//! products in the order of the inputs, whatever the panel, so the layout never changes a bit.

use heapless::Vec;

use crate::math;
use crate::{Floats, Word};

/// Greatest number of layers of a network.
pub const MAX_LAYERS: usize = 6;
/// Greatest width of a layer.
pub const MAX_WIDTH: usize = 1024;
/// Outputs of a panel, computed at once.
pub const PANEL: usize = 8;

/// Position of the weight from input `i` to output `o` within a layer of `inputs` × `outputs`.
pub const fn weight_index(inputs: usize, outputs: usize, o: usize, i: usize) -> usize {
    let first = o - o % PANEL;
    let width = if outputs - first < PANEL { outputs - first } else { PANEL };
    first * inputs + i * width + (o - first)
}

/// A feed-forward network whose parameters lie in flash; no layers is the identity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Network<'a> {
    widths: Vec<u16, { MAX_LAYERS + 1 }>,
    parameters: Floats<'a>,
}

/// One dense layer.
#[derive(Clone, Copy)]
struct Layer<'a> {
    inputs: usize,
    outputs: usize,
    weights: &'a [Word],
    biases: Floats<'a>,
}

impl<'a> Network<'a> {
    /// Network of `widths` from input to output (empty for the identity) with `parameters` in this module's order;
    /// `None` if a width is 0 or over [`MAX_WIDTH`], the layers are too many, or the parameters' count differs.
    pub fn new(widths: &[u16], parameters: Floats<'a>) -> Option<Self> {
        let in_range = widths.iter().all(|&w| (1..=MAX_WIDTH).contains(&usize::from(w)));
        let shape = widths.len() != 1 && in_range && parameter_count(widths) == parameters.len();
        let widths = Vec::from_slice(widths).ok()?;
        shape.then_some(Self { widths, parameters })
    }

    /// Widths from input to output; empty for the identity.
    pub fn widths(&self) -> &[u16] {
        &self.widths
    }

    /// Parameters in their stored order.
    pub fn parameters(&self) -> Floats<'a> {
        self.parameters
    }

    /// Width of the widest hidden layer; [`Network::forward`] needs twice and [`Network::tangent`] four
    /// times as many floats of scratch.
    pub fn hidden_width(&self) -> usize {
        let hidden = self.widths.get(1..self.widths.len().saturating_sub(1)).unwrap_or(&[]);
        hidden.iter().map(|&w| usize::from(w)).max().unwrap_or(0)
    }

    /// Multiplications of one forward pass.
    pub fn multiply_adds(&self) -> usize {
        self.widths.windows(2).map(|w| usize::from(w[0]) * usize::from(w[1])).sum()
    }

    /// Sigmoids of one pass.
    pub fn sigmoids(&self) -> usize {
        let hidden = self.widths.get(1..self.widths.len().saturating_sub(1)).unwrap_or(&[]);
        hidden.iter().map(|&w| usize::from(w)).sum()
    }

    fn layers(&self) -> impl ExactSizeIterator<Item = Layer<'a>> + '_ {
        let mut rest = self.parameters.0;
        self.widths.windows(2).map(move |w| {
            let (inputs, outputs) = (usize::from(w[0]), usize::from(w[1]));
            let (weights, after) = rest.split_at_checked(inputs * outputs).unwrap_or((&[], &[]));
            let (biases, after) = after.split_at_checked(outputs).unwrap_or((&[], &[]));
            rest = after;
            Layer { inputs, outputs, weights, biases: Floats(biases) }
        })
    }

    /// Computes y = network(x), theory (9).
    pub fn forward(&self, x: &[f32], y: &mut [f32], scratch: &mut [f32]) {
        let layers = self.layers();
        let count = layers.len();
        if count == 0 {
            return copy(x, y);
        }
        let width = self.hidden_width();
        let Some((mut from, rest)) = scratch.split_at_mut_checked(width) else { return };
        let Some(mut to) = rest.get_mut(..width) else { return };
        for (n, layer) in layers.enumerate() {
            let input = if n == 0 { x } else { &*from };
            if n + 1 == count {
                layer.affine(input, y);
            } else {
                layer.affine(input, to);
                to.iter_mut().take(layer.outputs).for_each(|h| *h = math::sigmoid(*h));
                core::mem::swap(&mut from, &mut to);
            }
        }
    }

    /// Computes dy = (∂network/∂x)(x) dx, theory (11) and (12), without the value itself.
    pub fn tangent(&self, x: &[f32], dx: &[f32], dy: &mut [f32], scratch: &mut [f32]) {
        let layers = self.layers();
        let count = layers.len();
        if count == 0 {
            return copy(dx, dy);
        }
        let width = self.hidden_width();
        let Some((mut from, rest)) = scratch.split_at_mut_checked(2 * width) else { return };
        let Some(mut to) = rest.get_mut(..2 * width) else { return };
        for (n, layer) in layers.enumerate() {
            let (h, dh) = if n == 0 { (x, dx) } else { from.split_at(width) };
            if n + 1 == count {
                layer.linear(dh, dy);
            } else {
                let (to_h, to_dh) = to.split_at_mut(width);
                layer.affine(h, to_h);
                layer.linear(dh, to_dh);
                for (h, dh) in to_h.iter_mut().zip(to_dh).take(layer.outputs) {
                    *h = math::sigmoid(*h);
                    *dh *= *h * (1.0 - *h);
                }
                core::mem::swap(&mut from, &mut to);
            }
        }
    }
}

fn copy(from: &[f32], to: &mut [f32]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
}

/// Number of parameters of a network of these widths.
pub fn parameter_count(widths: &[u16]) -> usize {
    widths.windows(2).map(|w| (usize::from(w[0]) + 1) * usize::from(w[1])).sum()
}

impl Layer<'_> {
    /// Computes y = W x + b.
    fn affine(&self, x: &[f32], y: &mut [f32]) {
        y.iter_mut().zip(self.biases.iter()).for_each(|(y, b)| *y = b);
        self.accumulate(x, y);
    }

    /// Computes y = W x.
    fn linear(&self, x: &[f32], y: &mut [f32]) {
        y.iter_mut().take(self.outputs).for_each(|y| *y = 0.0);
        self.accumulate(x, y);
    }

    /// Adds W x to y, each output in the order of the inputs.
    fn accumulate(&self, x: &[f32], y: &mut [f32]) {
        let Some(y) = y.get_mut(..self.outputs) else { return };
        let (full, last) = y.as_chunks_mut::<PANEL>();
        let mut panels = self.weights.chunks_exact((PANEL * self.inputs).max(1));
        for (y, panel) in full.iter_mut().zip(&mut panels) {
            let mut sums = *y;
            for (weights, &x) in panel.as_chunks::<PANEL>().0.iter().zip(x) {
                for (sum, w) in sums.iter_mut().zip(weights) {
                    *sum += f32::from_le_bytes(*w) * x;
                }
            }
            *y = sums;
        }
        // The last panel, narrower, lies behind the full ones.
        let rest = self.weights.get(full.len() * PANEL * self.inputs..).unwrap_or(&[]);
        for (weights, &x) in rest.chunks_exact(last.len().max(1)).zip(x) {
            for (sum, w) in last.iter_mut().zip(weights) {
                *sum += f32::from_le_bytes(*w) * x;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    /// The definition: row-major weights, one output after the other.
    struct Plain {
        widths: Vec<u16>,
        layers: Vec<(Vec<Vec<f32>>, Vec<f32>)>,
    }

    fn plain(widths: &[u16]) -> Plain {
        let mut seed = 12345u32;
        let mut next = move || {
            seed = seed.wrapping_mul(1664525).wrapping_add(1013904223);
            (seed >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let layers = widths
            .windows(2)
            .map(|w| {
                let weights = (0..w[1]).map(|_| (0..w[0]).map(|_| next()).collect()).collect();
                (weights, (0..w[1]).map(|_| next()).collect())
            })
            .collect();
        Plain { widths: widths.to_vec(), layers }
    }

    impl Plain {
        fn words(&self) -> Vec<Word> {
            let mut out = Vec::new();
            for (weights, biases) in &self.layers {
                let (outputs, inputs) = (weights.len(), weights[0].len());
                let mut packed = std::vec![[0; 4]; outputs * inputs];
                for (o, row) in weights.iter().enumerate() {
                    for (i, w) in row.iter().enumerate() {
                        packed[weight_index(inputs, outputs, o, i)] = w.to_le_bytes();
                    }
                }
                out.extend(packed);
                out.extend(biases.iter().map(|b| b.to_le_bytes()));
            }
            out
        }

        fn forward(&self, x: &[f32]) -> Vec<f32> {
            let mut h = x.to_vec();
            for (n, (weights, biases)) in self.layers.iter().enumerate() {
                h = weights
                    .iter()
                    .zip(biases)
                    .map(|(row, b)| row.iter().zip(&h).fold(*b, |sum, (w, x)| sum + w * x))
                    .map(|a| if n + 1 < self.layers.len() { math::sigmoid(a) } else { a })
                    .collect();
            }
            h
        }
    }

    #[test]
    fn forward_equals_the_plain_definition_to_the_bit() {
        for widths in [&[8u16, 256, 8][..], &[128, 64, 32, 3], &[3, 5], &[1, 1, 1], &[9, 17, 11, 7, 2]] {
            let plain = plain(widths);
            let words = plain.words();
            let network = Network::new(&plain.widths, Floats(&words)).unwrap();
            let x: Vec<f32> = (0..widths[0]).map(|i| (f32::from(i) * 0.7).sin()).collect();
            let mut y = std::vec![f32::NAN; usize::from(*widths.last().unwrap())];
            let mut scratch = std::vec![f32::NAN; 2 * network.hidden_width()];
            network.forward(&x, &mut y, &mut scratch);
            assert_eq!(y, plain.forward(&x), "{widths:?}");
        }
    }

    #[test]
    fn tangent_is_the_derivative() {
        for widths in [&[8u16, 64, 8][..], &[12, 9, 5, 3], &[3, 5]] {
            let plain = plain(widths);
            let words = plain.words();
            let network = Network::new(&plain.widths, Floats(&words)).unwrap();
            let n = usize::from(widths[0]);
            let x: Vec<f32> = (0..n).map(|i| (i as f32 * 0.7).sin()).collect();
            let dx: Vec<f32> = (0..n).map(|i| (i as f32 * 1.3).cos()).collect();
            let mut dy = std::vec![f32::NAN; usize::from(*widths.last().unwrap())];
            let mut scratch = std::vec![f32::NAN; 4 * network.hidden_width()];
            network.tangent(&x, &dx, &mut dy, &mut scratch);
            let at = |h: f32| plain.forward(&x.iter().zip(&dx).map(|(x, d)| x + h * d).collect::<Vec<_>>());
            let h = 1e-2;
            // The approximate sigmoid's slope is that of its table's chords.
            let tolerance = if cfg!(feature = "approx") { 5e-2 } else { 2e-3 };
            for ((got, plus), minus) in dy.iter().zip(at(h)).zip(at(-h)) {
                assert!((got - (plus - minus) / (2.0 * h)).abs() < tolerance * (1.0 + got.abs()), "{widths:?}");
            }
        }
    }

    #[test]
    fn identity_and_refusals() {
        let identity = Network::new(&[], Floats::default()).unwrap();
        let (mut y, mut dy) = ([0.0; 2], [0.0; 2]);
        identity.forward(&[1.0, 2.0], &mut y, &mut []);
        identity.tangent(&[1.0, 2.0], &[3.0, 4.0], &mut dy, &mut []);
        assert_eq!((y, dy), ([1.0, 2.0], [3.0, 4.0]));
        let words = [[0; 4]; 6];
        assert!(Network::new(&[2, 2], Floats(&words)).is_some());
        assert!(Network::new(&[2, 2], Floats(&words[..5])).is_none());
        assert!(Network::new(&[2], Floats::default()).is_none());
        assert!(Network::new(&[0, 2], Floats(&words[..2])).is_none());
        assert!(Network::new(&[1; 8], Floats(&[[0; 4]; 14])).is_none());
    }
}
