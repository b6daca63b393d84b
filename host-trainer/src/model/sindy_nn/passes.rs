//! Forward and backward passes of values and tangents through a network, theory (9), (11) and (12).
//!
//! Every row of a panel holds S samples' values and then their S tangents, so that one product a layer serves both.
//! Adjoints are marked by a star; σ″ ȧ = (1−2h) ḣ.

use pulp::Simd;

use super::layout::{LayerLayout, NetworkLayout};
use super::panel::{Panel, TILE, Tiles, dots, multiply, total};
use super::real::Real;

/// Weights of a layer in the shapes the kernel multiplies with.
#[derive(Clone, Debug, Default)]
pub struct PackedLayer<T> {
    forward: Tiles<T>,
    transposed: Tiles<T>,
    biases: Vec<T>,
}

impl<T: Real> PackedLayer<T> {
    /// Packs one layer's parameters.
    pub fn pack(&mut self, layer: &LayerLayout, parameters: &[T]) {
        let w = &parameters[layer.weights.clone()];
        self.forward.pack(layer.outputs, layer.inputs, |r, c| w[r * layer.inputs + c]);
        self.transposed.pack(layer.inputs, layer.outputs, |r, c| w[c * layer.inputs + r]);
        self.biases.clear();
        self.biases.extend_from_slice(&parameters[layer.biases.clone()]);
    }
}

/// Hidden panels (h | ḣ) of a network, its output panel, and adjoints.
#[derive(Clone, Debug)]
pub struct Activations<T> {
    hidden: Vec<Panel<T>>,
    /// Adjoints of the hidden layers that another hidden layer precedes.
    adjoints: Vec<Panel<T>>,
    /// Output, then its adjoint.
    pub output: Panel<T>,
}

impl<T: Real> Activations<T> {
    /// Memory for a network's activations.
    pub fn new(network: &NetworkLayout, outputs: usize, columns: usize) -> Self {
        let widths = network.widths();
        let hidden: Vec<_> = widths.get(1..widths.len().saturating_sub(1)).unwrap_or(&[]).to_vec();
        let adjoints = hidden.iter().enumerate().map(|(n, w)| if n == 0 { 0 } else { *w });
        Self {
            adjoints: adjoints.map(|w| Panel::new(w, columns)).collect(),
            hidden: hidden.iter().map(|w| Panel::new(*w, columns)).collect(),
            output: Panel::new(outputs, columns),
        }
    }
}

/// Computes out = tiles · B.
#[inline(always)]
pub fn multiply_all<S: Simd, T: Real>(simd: S, tiles: &Tiles<T>, b: &[T], columns: usize, out: &mut [T]) {
    for (t, out) in out.chunks_mut(TILE * columns).enumerate() {
        multiply(simd, tiles.tile(t), b, columns, out, false);
    }
}

/// Fills `activations` from `input`, a panel of (value | tangent), theory (9) and (12).
#[inline(always)]
pub fn forward<S: Simd, T: Real>(
    simd: S,
    network: &NetworkLayout,
    packed: &[PackedLayer<T>],
    input: &Panel<T>,
    activations: &mut Activations<T>,
) {
    let Activations { hidden, output, .. } = activations;
    let Some((last, inner)) = packed.split_last() else {
        debug_assert!(network.widths().is_empty());
        return output.values_mut().copy_from_slice(input.values());
    };
    let columns = input.values().len() / input.rows();
    let (value, mut below) = (columns / 2, input);
    for (layer, panel) in inner.iter().zip(hidden) {
        for (t, rows) in panel.values_mut().chunks_mut(TILE * columns).enumerate() {
            multiply(simd, layer.forward.tile(t), below.values(), columns, rows, false);
            for (row, bias) in rows.chunks_exact_mut(columns).zip(&layer.biases[t * TILE..]) {
                let (h, dh) = row.split_at_mut(value);
                activate(simd, *bias, T::vectors_mut::<S>(h), T::vectors_mut::<S>(dh));
            }
        }
        below = panel;
    }
    multiply_all(simd, &last.forward, below.values(), columns, output.values_mut());
    for (row, bias) in output.values_mut().chunks_exact_mut(columns).zip(&last.biases) {
        let bias = T::splat(simd, *bias);
        T::vectors_mut::<S>(&mut row[..value]).iter_mut().for_each(|v| *v = T::add(simd, *v, bias));
    }
}

/// Activates a hidden layer in place: (a, ȧ) → (h, ḣ).
#[inline(always)]
fn activate<S: Simd, T: Real>(simd: S, bias: T, h: &mut [T::V<S>], dh: &mut [T::V<S>]) {
    let bias = T::splat(simd, bias);
    for (h, dh) in h.iter_mut().zip(dh) {
        let value = T::sigmoid(simd, T::add(simd, *h, bias));
        // h(1−h) = h − h²
        let slope = T::sub(simd, value, T::mul(simd, value, value));
        *h = value;
        *dh = T::mul(simd, *dh, slope);
    }
}

/// Adjoint of the activation in place: (h*, ḣ*) → (a*, ȧ*), from (h, ḣ).
#[inline(always)]
fn activate_back<S: Simd, T: Real>(simd: S, row: &[T], adjoint: &mut [T], value: usize) {
    let (h, dh) = row.split_at(value);
    let (a, da) = adjoint.split_at_mut(value);
    let (h, dh) = (T::vectors::<S>(h), T::vectors::<S>(dh));
    let (a, da) = (T::vectors_mut::<S>(a), T::vectors_mut::<S>(da));
    let one = T::splat(simd, T::from_f64(1.0));
    for i in 0..h.len() {
        let slope = T::sub(simd, h[i], T::mul(simd, h[i], h[i]));
        let bend = T::mul(simd, T::sub(simd, T::sub(simd, one, h[i]), h[i]), dh[i]);
        a[i] = T::mul_add(simd, slope, a[i], T::mul(simd, bend, da[i]));
        da[i] = T::mul(simd, slope, da[i]);
    }
}

/// Propagates the adjoints in `activations.output` back; writes this network's part of `gradient` and adds to
/// `input_adjoint`, if given.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // memory of its own for each part of the block
pub fn backward<S: Simd, T: Real>(
    simd: S,
    network: &NetworkLayout,
    packed: &[PackedLayer<T>],
    input: &Panel<T>,
    activations: &mut Activations<T>,
    tile: &mut Panel<T>,
    mut input_adjoint: Option<&mut Panel<T>>,
    gradient: &mut [T],
) {
    let Activations { hidden, adjoints, output } = activations;
    let layers = network.layers();
    let columns = input.values().len() / input.rows();
    let value = columns / 2;
    let Some(last) = layers.last() else {
        if let Some(adjoint) = input_adjoint {
            adjoint.values_mut().copy_from_slice(output.values());
        }
        return;
    };
    bias_gradient(simd, last, 0, output.values(), columns, gradient);
    if hidden.is_empty() {
        weight_gradient(simd, last, (0, output.values()), (0, input.values()), columns, gradient);
        if let Some(adjoint) = input_adjoint {
            multiply_all(simd, &packed[0].transposed, output.values(), columns, adjoint.values_mut());
        }
        return;
    }
    for l in (0..hidden.len()).rev() {
        // Layer l leads to hidden panel l, layer l + 1 away from it.
        let (here, above) = adjoints.split_at_mut(l + 1);
        let above = if l + 1 == layers.len() - 1 { &*output } else { &above[0] };
        let rows = hidden[l].values().chunks(TILE * columns);
        for (t, h) in rows.enumerate() {
            let first = t * TILE;
            let adjoint = &mut tile.values_mut()[..h.len()];
            multiply(simd, packed[l + 1].transposed.tile(t), above.values(), columns, adjoint, false);
            weight_gradient(simd, &layers[l + 1], (0, above.values()), (first, h), columns, gradient);
            for (h, adjoint) in h.chunks_exact(columns).zip(adjoint.chunks_exact_mut(columns)) {
                activate_back::<S, T>(simd, h, adjoint, value);
            }
            bias_gradient(simd, &layers[l], first, adjoint, columns, gradient);
            let below = if l == 0 { input.values() } else { hidden[l - 1].values() };
            weight_gradient(simd, &layers[l], (first, adjoint), (0, below), columns, gradient);
            if l > 0 {
                here[l].values_mut()[first * columns..][..adjoint.len()].copy_from_slice(adjoint);
            } else if let Some(out) = &mut input_adjoint {
                let chosen = first..first + adjoint.len() / columns;
                for (t, out) in out.values_mut().chunks_mut(TILE * columns).enumerate() {
                    let part = packed[0].transposed.columns(t, chosen.clone());
                    multiply(simd, part, adjoint, columns, out, true);
                }
            }
        }
    }
}

/// Weight gradient dW[i, j] = adjoint_i · below_j, rows from the stated first ones on.
#[inline(always)]
fn weight_gradient<S: Simd, T: Real>(
    simd: S,
    layer: &LayerLayout,
    (first_out, adjoint): (usize, &[T]),
    (first_in, below): (usize, &[T]),
    columns: usize,
    gradient: &mut [T],
) {
    let weights = &mut gradient[layer.weights.clone()][first_out * layer.inputs + first_in..];
    dots(simd, adjoint, below, columns, weights, layer.inputs);
}

#[inline(always)]
fn bias_gradient<S: Simd, T: Real>(
    simd: S,
    layer: &LayerLayout,
    first: usize,
    adjoint: &[T],
    columns: usize,
    gradient: &mut [T],
) {
    let biases = &mut gradient[layer.biases.clone()][first..];
    for (row, bias) in adjoint.chunks_exact(columns).zip(biases) {
        *bias = total(simd, &row[..columns / 2]);
    }
}
