//! Losses of SINDy-NN, theory (10), (11), (13) and (14), and their gradient, by hand.
//!
//! Encoder and decoder carry values and tangents together (`super::passes`): φ maps (x, ẋ) to
//! (z, ∇φ ẋ), ψ maps (z, Θ(z) Ξ) to (x̂, ∇ψ Θ(z) Ξ), and each data loss is a difference of two of these.

use pulp::{Simd, WithSimd};
use serde::{Deserialize, Serialize};

use super::layout::Layout;
use super::panel::{Panel, TILE, Tiles, dots};
use super::passes::{Activations, PackedLayer, backward, forward, multiply_all};
use super::real::Real;
use super::terms::LatentRows;

/// Weights of the losses, theory (14); the reconstruction's is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambdas {
    /// Weight λ1 of L_dx/dt.
    pub derivative: f64,
    /// Weight λ2 of L_dz/dt.
    pub latent: f64,
    /// Weight λ3 of L_reg; masked coefficients are zero and have no gradient.
    pub sparsity: f64,
    /// Norm of Ξ that L_reg is.
    pub norm: SparsityNorm,
}

/// Norm of Ξ in L_reg, theory (13).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum SparsityNorm {
    /// Mean |ξ| over all coefficients, as in the code of Champion et al. 2019.
    Mean,
    /// Sum of |ξ|, as the paper writes it.
    #[default]
    Sum,
}

impl Lambdas {
    /// Weights of the paper's Table 2.
    pub const PAPER: Self = Self { derivative: 0.5, latent: 0.01, sparsity: 0.01, norm: SparsityNorm::Sum };
}

/// The four losses, theory (13), those of data means over samples and components; not weighted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses {
    /// Reconstruction loss L_recon.
    pub reconstruction: f64,
    /// Derivative loss L_dx/dt.
    pub derivative: f64,
    /// Latent rate loss L_dz/dt.
    pub latent: f64,
    /// Sparsity loss L_reg.
    pub sparsity: f64,
}

impl Losses {
    /// Total loss L_recon + λ1 L_dx/dt + λ2 L_dz/dt + λ3 L_reg, theory (14).
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

    /// Adds a share of all losses.
    pub(super) fn add_share(&mut self, other: &Losses, share: f64) {
        self.reconstruction += share * other.reconstruction;
        self.derivative += share * other.derivative;
        self.latent += share * other.latent;
        self.sparsity += share * other.sparsity;
    }
}

/// Weights in the shapes the kernel multiplies with; packed once a step, shared by all blocks.
#[derive(Clone, Debug, Default)]
pub struct Packed<T> {
    encoder: Vec<PackedLayer<T>>,
    decoder: Vec<PackedLayer<T>>,
    /// Transposed Ξᵀ: equations × terms.
    xi_transposed: Tiles<T>,
    /// Coefficients Ξ: terms × equations.
    xi: Tiles<T>,
}

impl<T: Real> Packed<T> {
    /// Packs the parameters.
    pub fn pack(&mut self, layout: &Layout, parameters: &[T]) {
        for (network, packed) in [(&layout.encoder, &mut self.encoder), (&layout.decoder, &mut self.decoder)] {
            let layers = network.layers();
            packed.resize_with(layers.len(), PackedLayer::default);
            for (layer, packed) in layers.iter().zip(packed) {
                packed.pack(layer, parameters);
            }
        }
        let xi = &parameters[layout.xi()];
        let (terms, equations) = (layout.terms.count(), layout.latent);
        self.xi_transposed.pack(equations, terms, |r, c| xi[c * equations + r]);
        self.xi.pack(terms, equations, |r, c| xi[r * equations + c]);
    }
}

/// Samples gathered at once: a cache line of `f32`.
const LINE: usize = 16;

/// Memory of one block: inputs, activations, adjoints, gradient, losses.
#[derive(Clone, Debug)]
pub struct Block<T> {
    /// Capacity, samples.
    capacity: usize,
    /// Samples in the block.
    samples: usize,
    /// Input (x | ẋ).
    input: Panel<T>,
    encoder: Activations<T>,
    /// Latent variables and rates (z | Θ(z) Ξ).
    latent: Panel<T>,
    theta: Panel<T>,
    theta_adjoint: Panel<T>,
    rate: Panel<T>,
    decoder: Activations<T>,
    latent_adjoint: Panel<T>,
    tile: Panel<T>,
    /// Gradient of the weighted data losses, summed over this block.
    pub gradient: Vec<T>,
    /// Losses of this block's samples, as parts of means over the batch.
    pub losses: Losses,
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
        // A cache line of samples at a time, as the panel's rows are far apart.
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
    /// Sizes and parameter layout.
    pub layout: &'a Layout,
    /// Packed weights.
    pub packed: &'a Packed<T>,
    /// Weights of the losses.
    pub lambdas: Lambdas,
    /// Samples in the whole batch.
    pub batch: usize,
    /// Block of samples.
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

        // L_dz/dt has a gradient on both sides: (∇φ) ẋ and Θ(z) Ξ.
        let pull = T::from_f64(scale(lambdas.latent, layout.latent));
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
        dots(simd, b.theta.values(), b.rate.values(), capacity, &mut b.gradient[xi], equations);
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

/// Residual in place, out ← scale · (out − target), the two halves by their scales, padding zeroed; returns the sums
/// of squares of the two halves.
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
        let scale = T::splat(simd, T::from_f64(scales[n % 2]));
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

/// Latent residual in place, measured ← pull · (measured − rate), subtracted from the adjoint; returns the sum of
/// squares.
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
