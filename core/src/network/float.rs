//! A network in single precision.
//!
//! Parameters lie layer by layer: weights, then biases. A layer's weights lie in panels of
//! [`PANEL`] outputs, each panel input by input, so that a step over one input reads its panel's
//! weights in sequence ([`weight_index`] is the definition). An output is its bias plus its
//! products in the order of the inputs, whatever the panel, so the layout never changes a bit.

use super::Network;
use crate::hardware::{Stored, aligned};
use crate::math;
use crate::{Floats, Word};

/// Outputs of a panel, computed at once.
pub const PANEL: usize = 8;

/// Position of the weight from input `i` to output `o` within a layer of `inputs` × `outputs`.
pub const fn weight_index(inputs: usize, outputs: usize, o: usize, i: usize) -> usize {
    let first = o - o % PANEL;
    let width = if outputs - first < PANEL { outputs - first } else { PANEL };
    first * inputs + i * width + (o - first)
}

/// One dense layer.
#[derive(Clone, Copy)]
struct Layer<'a> {
    inputs: usize,
    outputs: usize,
    weights: &'a [Word],
    biases: Floats<'a>,
}

fn layers<'n, 'a>(network: &'n Network<'a>) -> impl ExactSizeIterator<Item = Layer<'a>> + use<'n, 'a> {
    let mut rest = network.words;
    network.widths.windows(2).map(move |w| {
        let (inputs, outputs) = (usize::from(w[0]), usize::from(w[1]));
        let (weights, after) = rest.split_at_checked(inputs * outputs).unwrap_or((&[], &[]));
        let (biases, after) = after.split_at_checked(outputs).unwrap_or((&[], &[]));
        rest = after;
        Layer { inputs, outputs, weights, biases: Floats(biases) }
    })
}

/// Computes y = network(x), theory (9).
pub(super) fn forward(network: &Network<'_>, x: &[f32], y: &mut [f32], scratch: &mut [f32]) {
    let layers = layers(network);
    let count = layers.len();
    if count == 0 {
        return copy(x, y);
    }
    let width = network.hidden_width();
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
pub(super) fn tangent(network: &Network<'_>, x: &[f32], dx: &[f32], dy: &mut [f32], scratch: &mut [f32]) {
    let layers = layers(network);
    let count = layers.len();
    if count == 0 {
        return copy(dx, dy);
    }
    let width = network.hidden_width();
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

/// Number of words of a network of these widths.
pub fn word_count(widths: &[u16]) -> usize {
    widths.windows(2).map(|w| (usize::from(w[0]) + 1) * usize::from(w[1])).sum()
}

fn copy(from: &[f32], to: &mut [f32]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
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
        match aligned(self.weights) {
            Some(weights) => self.accumulate_over(weights, x, y),
            None => self.accumulate_over(self.weights, x, y),
        }
    }

    fn accumulate_over<W: Stored>(&self, weights: &[W], x: &[f32], y: &mut [f32]) {
        let Some(y) = y.get_mut(..self.outputs) else { return };
        let (full, last) = y.as_chunks_mut::<PANEL>();
        let mut panels = weights.chunks_exact((PANEL * self.inputs).max(1));
        for (y, panel) in full.iter_mut().zip(&mut panels) {
            let mut sums = *y;
            for (weights, &x) in panel.as_chunks::<PANEL>().0.iter().zip(x) {
                for (sum, w) in sums.iter_mut().zip(weights) {
                    *sum += f32::from_bits(w.bits()) * x;
                }
            }
            *y = sums;
        }
        // The last panel, narrower, lies behind the full ones.
        let rest = weights.get(full.len() * PANEL * self.inputs..).unwrap_or(&[]);
        for (weights, &x) in rest.chunks_exact(last.len().max(1)).zip(x) {
            for (sum, w) in last.iter_mut().zip(weights) {
                *sum += f32::from_bits(w.bits()) * x;
            }
        }
    }
}
