//! The loss of SINDy-NN and its gradient, by hand (method: the four losses).
//!
//! Every row of a panel holds S samples' values and then their S tangents, so encoder and decoder
//! with their Jacobians are one product a layer: φ maps (x, ẋ) to (z, ∇φ ẋ), ψ maps (z, Θ(z) Ξ) to
//! (x̂, ∇ψ Θ Ξ). With h = σ(a) and its tangent ḣ = h(1−h) ȧ, the adjoints of a hidden unit are
//! ȧ* = h(1−h) ḣ* and a* = h(1−h) h* + (1−2h) ḣ ḣ*, since σ″ ȧ = (1−2h) ḣ.

use pulp::{Simd, WithSimd};

use super::layout::{LayerLayout, Layout, NetworkLayout};
use super::panel::{Panel, TILE, Tiles, dots, multiply, total};
use super::real::Real;
use super::terms::LatentRows;

/// Weights of the losses beside the reconstruction's 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambdas {
    /// λ1 of L_dx/dt.
    pub derivative: f64,
    /// λ2 of L_dz/dt.
    pub latent: f64,
    /// λ3 of L_reg, the mean |Ξ| over coefficients that are not masked.
    pub sparsity: f64,
}

impl Lambdas {
    /// The paper's, Table 2.
    pub const PAPER: Self = Self { derivative: 0.5, latent: 0.01, sparsity: 0.01 };
}

/// The four losses, each a mean over samples and components; not yet weighted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses {
    /// L_recon.
    pub reconstruction: f64,
    /// L_dx/dt.
    pub derivative: f64,
    /// L_dz/dt.
    pub latent: f64,
    /// L_reg.
    pub sparsity: f64,
}

impl Losses {
    /// L_recon + λ1 L_dx/dt + λ2 L_dz/dt + λ3 L_reg.
    pub fn total(&self, lambdas: Lambdas) -> f64 {
        self.reconstruction
            + lambdas.derivative * self.derivative
            + lambdas.latent * self.latent
            + lambdas.sparsity * self.sparsity
    }

    pub(super) fn add(&mut self, other: &Losses) {
        self.reconstruction += other.reconstruction;
        self.derivative += other.derivative;
        self.latent += other.latent;
    }
}

/// Weights in the shapes the kernel multiplies with; packed once a step, shared by all blocks.
#[derive(Clone, Debug, Default)]
pub struct Packed<T> {
    encoder: Vec<PackedLayer<T>>,
    decoder: Vec<PackedLayer<T>>,
    /// Ξᵀ: equations × terms.
    xi_transposed: Tiles<T>,
    /// Ξ: terms × equations.
    xi: Tiles<T>,
}

#[derive(Clone, Debug, Default)]
struct PackedLayer<T> {
    forward: Tiles<T>,
    transposed: Tiles<T>,
    biases: Vec<T>,
}

impl<T: Real> Packed<T> {
    /// Packs the parameters.
    pub fn pack(&mut self, layout: &Layout, parameters: &[T]) {
        for (network, packed) in [(&layout.encoder, &mut self.encoder), (&layout.decoder, &mut self.decoder)] {
            let layers = network.layers();
            packed.resize_with(layers.len(), PackedLayer::default);
            for (layer, packed) in layers.iter().zip(packed) {
                let w = &parameters[layer.weights.clone()];
                packed.forward.pack(layer.outputs, layer.inputs, |r, c| w[r * layer.inputs + c]);
                packed.transposed.pack(layer.inputs, layer.outputs, |r, c| w[c * layer.inputs + r]);
                packed.biases.clear();
                packed.biases.extend_from_slice(&parameters[layer.biases.clone()]);
            }
        }
        let xi = &parameters[layout.xi()];
        let (terms, equations) = (layout.terms.count(), layout.latent);
        self.xi_transposed.pack(equations, terms, |r, c| xi[c * equations + r]);
        self.xi.pack(terms, equations, |r, c| xi[r * equations + c]);
    }
}

/// Samples gathered together: a cache line of `f32`.
const LINE: usize = 16;

/// One block's memory: inputs, activations, adjoints, gradient, losses.
#[derive(Clone, Debug)]
pub struct Block<T> {
    /// Samples there is room for.
    capacity: usize,
    /// Samples in it.
    samples: usize,
    /// (x | ẋ).
    input: Panel<T>,
    encoder: Activations<T>,
    /// (z | Θ(z) Ξ).
    latent: Panel<T>,
    theta: Panel<T>,
    theta_adjoint: Panel<T>,
    rate: Panel<T>,
    decoder: Activations<T>,
    latent_adjoint: Panel<T>,
    tile: Panel<T>,
    /// Gradient of the weighted data losses, summed over this block.
    pub gradient: Vec<T>,
    /// Sums of squares over this block, divided as means over the batch.
    pub losses: Losses,
}

/// A network's hidden panels (h | ḣ), its output panel, and adjoints.
#[derive(Clone, Debug)]
struct Activations<T> {
    hidden: Vec<Panel<T>>,
    /// Adjoints of the hidden layers that another hidden layer precedes.
    adjoints: Vec<Panel<T>>,
    output: Panel<T>,
}

impl<T: Real> Activations<T> {
    fn new(network: &NetworkLayout, outputs: usize, columns: usize) -> Self {
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

impl<T: Real> Block<T> {
    /// Memory for blocks of up to `capacity` samples, a multiple of 16.
    pub fn new(layout: &Layout, capacity: usize) -> Self {
        let columns = 2 * capacity;
        let terms = layout.terms.count();
        Self {
            capacity,
            samples: 0,
            input: Panel::new(layout.inputs, columns),
            encoder: Activations::new(&layout.encoder, layout.latent, columns),
            latent: Panel::new(layout.latent, columns),
            theta: Panel::new(terms, capacity),
            theta_adjoint: Panel::new(terms.next_multiple_of(TILE), capacity),
            rate: Panel::new(layout.latent, capacity),
            decoder: Activations::new(&layout.decoder, layout.inputs, columns),
            latent_adjoint: Panel::new(layout.latent, columns),
            tile: Panel::new(TILE, columns),
            gradient: vec![T::ZERO; layout.parameter_count()],
            losses: Losses::default(),
        }
    }

    /// Gathers samples: rows of x and ẋ (`inputs` values each).
    pub fn fill<'a>(&mut self, rows: impl ExactSizeIterator<Item = (&'a [T], &'a [T])>) {
        self.samples = rows.len();
        let (columns, capacity) = (2 * self.capacity, self.capacity);
        let values = self.input.values_mut();
        if self.samples < capacity {
            values.fill(T::ZERO);
        }
        // A cache line of samples at a time: the panel's rows are far apart, so each value written
        // alone would cost a line.
        let mut rows = rows.enumerate();
        let mut line: Vec<(&[T], &[T])> = Vec::with_capacity(LINE);
        while let Some((first, row)) = rows.next() {
            line.clear();
            line.push(row);
            line.extend(rows.by_ref().take(LINE - 1).map(|(_, row)| row));
            for (i, row) in values.chunks_exact_mut(columns).enumerate() {
                let (x_row, dx_row) = row.split_at_mut(capacity);
                let slots = x_row[first..].iter_mut().zip(&mut dx_row[first..]);
                for ((x_slot, dx_slot), (x, dx)) in slots.zip(&line) {
                    *x_slot = x[i];
                    *dx_slot = dx[i];
                }
            }
        }
    }
}

/// Computes a block's losses and gradient; the means are over `batch` samples.
pub struct Pass<'a, T> {
    /// Sizes.
    pub layout: &'a Layout,
    /// Weights.
    pub packed: &'a Packed<T>,
    /// Weights of the losses.
    pub lambdas: Lambdas,
    /// Samples in the whole batch.
    pub batch: usize,
    /// The block.
    pub block: &'a mut Block<T>,
}

impl<T: Real> WithSimd for Pass<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Pass { layout, packed, lambdas, batch, block: b } = self;
        let (capacity, columns) = (b.capacity, 2 * b.capacity);
        b.gradient.fill(T::ZERO);

        forward(simd, &layout.encoder, &packed.encoder, &b.input, &mut b.encoder);
        let z = &b.encoder.output;
        layout.terms.forward(simd, LatentRows { values: z.values(), stride: columns }, &mut b.theta, capacity);
        multiply_all(simd, &packed.xi_transposed, b.theta.values(), capacity, b.rate.values_mut());
        for i in 0..layout.latent {
            let (value, tangent) = b.latent.row_mut(i).split_at_mut(capacity);
            value.copy_from_slice(&z.row(i)[..capacity]);
            tangent.copy_from_slice(b.rate.row(i));
        }
        forward(simd, &layout.decoder, &packed.decoder, &b.latent, &mut b.decoder);

        // From here on the output panels hold adjoints.
        let scale = |lambda: f64, components: usize| 2.0 * lambda / (batch * components) as f64;
        let out = &mut b.decoder.output;
        let squares = residual(simd, b.input.values(), out.values_mut(), b.samples, capacity, {
            [scale(1.0, layout.inputs), scale(lambdas.derivative, layout.inputs)]
        });
        let mean = |square: f64, components: usize| square / (batch * components) as f64;
        b.losses.reconstruction = mean(squares[0], layout.inputs);
        b.losses.derivative = mean(squares[1], layout.inputs);
        b.latent_adjoint.values_mut().fill(T::ZERO);
        backward(
            simd,
            &layout.decoder,
            &packed.decoder,
            &b.latent,
            &mut b.decoder,
            &mut b.tile,
            Some(&mut b.latent_adjoint),
            &mut b.gradient,
        );

        // L_dz/dt pulls on both sides: (∇φ) ẋ and Θ(z) Ξ.
        let pull = T::of(scale(lambdas.latent, layout.latent));
        let mut square = 0.0;
        for i in 0..layout.latent {
            let measured = &mut b.encoder.output.row_mut(i)[capacity..];
            let adjoint = &mut b.latent_adjoint.row_mut(i)[capacity..];
            let rate = b.rate.row(i);
            square += latent_residual(simd, measured, rate, adjoint, b.samples, pull);
        }
        b.losses.latent = mean(square, layout.latent);

        // Ξ, then z through Θ.
        for i in 0..layout.latent {
            b.rate.row_mut(i).copy_from_slice(&b.latent_adjoint.row(i)[capacity..]);
        }
        let xi = layout.xi();
        let equations = layout.latent;
        let gradient = &mut b.gradient[xi];
        dots(simd, b.theta.values(), b.rate.values(), capacity, |term, equation, dot| {
            gradient[term * equations + equation] = dot;
        });
        multiply_all(simd, &packed.xi, b.rate.values(), capacity, b.theta_adjoint.values_mut());
        let z_adjoint = b.latent_adjoint.values_mut();
        let z = LatentRows { values: b.encoder.output.values(), stride: columns };
        layout.terms.backward(simd, z, &b.theta, &mut b.theta_adjoint, z_adjoint, capacity);
        for i in 0..layout.latent {
            // The tangent half already holds the adjoint of ∇φ ẋ.
            b.encoder.output.row_mut(i)[..capacity].copy_from_slice(&b.latent_adjoint.row(i)[..capacity]);
        }
        backward(simd, &layout.encoder, &packed.encoder, &b.input, &mut b.encoder, &mut b.tile, None, &mut b.gradient);
    }
}

/// All rows of tiles · B.
#[inline(always)]
fn multiply_all<S: Simd, T: Real>(simd: S, tiles: &Tiles<T>, b: &[T], columns: usize, out: &mut [T]) {
    for (t, out) in out.chunks_mut(TILE * columns).enumerate() {
        multiply(simd, tiles, t, b, columns, out, false);
    }
}

#[inline(always)]
fn forward<S: Simd, T: Real>(
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
            multiply(simd, &layer.forward, t, below.values(), columns, rows, false);
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

/// (a, ȧ) → (h, ḣ).
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

/// (h*, ḣ*) → (a*, ȧ*), from (h, ḣ).
#[inline(always)]
fn activate_back<S: Simd, T: Real>(simd: S, row: &[T], adjoint: &mut [T], value: usize) {
    let (h, dh) = row.split_at(value);
    let (a, da) = adjoint.split_at_mut(value);
    let (h, dh) = (T::vectors::<S>(h), T::vectors::<S>(dh));
    let (a, da) = (T::vectors_mut::<S>(a), T::vectors_mut::<S>(da));
    let one = T::splat(simd, T::of(1.0));
    for i in 0..h.len() {
        let slope = T::sub(simd, h[i], T::mul(simd, h[i], h[i]));
        let bend = T::mul(simd, T::sub(simd, T::sub(simd, one, h[i]), h[i]), dh[i]);
        a[i] = T::mul_add(simd, slope, a[i], T::mul(simd, bend, da[i]));
        da[i] = T::mul(simd, slope, da[i]);
    }
}

/// Takes the adjoints in `activations.output`; adds to `gradient` and, where asked, to the adjoint
/// of the network's input.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn backward<S: Simd, T: Real>(
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
            multiply(simd, &packed[l + 1].transposed, t, above.values(), columns, adjoint, false);
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
                    super::panel::multiply_tile(simd, part, adjoint, columns, out, true);
                }
            }
        }
    }
}

/// dW[i, j] += adjoint_i · below_j, rows from the stated first ones on.
#[inline(always)]
fn weight_gradient<S: Simd, T: Real>(
    simd: S,
    layer: &LayerLayout,
    (first_out, adjoint): (usize, &[T]),
    (first_in, below): (usize, &[T]),
    columns: usize,
    gradient: &mut [T],
) {
    let weights = &mut gradient[layer.weights.clone()];
    dots(simd, adjoint, below, columns, |o, i, dot| {
        weights[(first_out + o) * layer.inputs + first_in + i] = dot;
    });
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

/// out ← scale · (out − target), the two halves by their scales, padding zeroed; sums of squares of
/// the two halves.
#[inline(always)]
fn residual<S: Simd, T: Real>(
    simd: S,
    target: &[T],
    out: &mut [T],
    samples: usize,
    capacity: usize,
    scales: [f64; 2],
) -> [f64; 2] {
    let mut squares = [0.0; 2];
    for (n, (out, target)) in out.chunks_exact_mut(capacity).zip(target.chunks_exact(capacity)).enumerate() {
        let scale = T::splat(simd, T::of(scales[n % 2]));
        let mut sum = T::splat(simd, T::ZERO);
        out[samples..].copy_from_slice(&target[samples..]);
        for (out, target) in T::vectors_mut::<S>(out).iter_mut().zip(T::vectors::<S>(target)) {
            let difference = T::sub(simd, *out, *target);
            sum = T::mul_add(simd, difference, difference, sum);
            *out = T::mul(simd, difference, scale);
        }
        squares[n % 2] += T::sum(simd, sum).to_f64();
    }
    squares
}

/// measured ← pull · (measured − rate), adjoint −= the same; sum of squares.
#[inline(always)]
fn latent_residual<S: Simd, T: Real>(
    simd: S,
    measured: &mut [T],
    rate: &[T],
    adjoint: &mut [T],
    samples: usize,
    pull: T,
) -> f64 {
    measured[samples..].copy_from_slice(&rate[samples..]);
    let pull = T::splat(simd, pull);
    let mut sum = T::splat(simd, T::ZERO);
    let vectors = T::vectors_mut::<S>(measured).iter_mut().zip(T::vectors::<S>(rate));
    for ((measured, rate), adjoint) in vectors.zip(T::vectors_mut::<S>(adjoint)) {
        let difference = T::sub(simd, *measured, *rate);
        sum = T::mul_add(simd, difference, difference, sum);
        *measured = T::mul(simd, difference, pull);
        *adjoint = T::sub(simd, *adjoint, *measured);
    }
    T::sum(simd, sum).to_f64()
}
