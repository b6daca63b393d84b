//! A model's networks and dynamics on vectors, a sample in each lane: the device's sums in the device's order.

use ballrace_core::dynamics::decode_term;
use ballrace_core::library::Term;
use ballrace_core::model::Model;
use ballrace_core::network::Network;
use ballrace_core::network::float::{PANEL, weight_index};
use pulp::{Simd, WithSimd, bytemuck};

use super::CHUNK;
use super::functions::{cos, lane_by_lane, sigmoids, sin};

/// A model's numbers in the order in which they are used.
#[derive(Debug)]
pub struct Kernel {
    inputs: usize,
    latent: usize,
    /// Mean and reciprocal scale of each state.
    scaling: Vec<(f32, f32)>,
    encoder: Vec<Layer>,
    decoder: Vec<Layer>,
    /// Terms in use with their coefficients and equations.
    terms: Vec<(Term, Vec<(usize, f32)>)>,
}

/// A dense layer; weights in panels of [`PANEL`] outputs, padded with zeros, each panel input by input.
#[derive(Debug)]
struct Layer {
    inputs: usize,
    outputs: usize,
    panels: Vec<[f32; PANEL]>,
    biases: Vec<[f32; PANEL]>,
}

impl Layer {
    /// Outputs with those that fill the last panel.
    fn padded(&self) -> usize {
        self.outputs.next_multiple_of(PANEL)
    }
}

impl Kernel {
    /// Numbers of a model whose networks are in single precision.
    pub fn new(model: &Model<'_>) -> Self {
        let scaling = model.states.mean.iter().zip(model.states.scale.iter());
        let d = &model.dynamics;
        let index = |word: &[u8; 4]| u32::from_le_bytes(*word) as usize;
        let starts = std::iter::once(0).chain(d.ends.iter().map(index));
        let runs = d.terms.iter().zip(starts.zip(d.ends.iter().map(index)));
        let terms = runs.map(|(code, (start, end))| {
            let entry = |i: usize| (index(&d.equations[i]), d.coefficients.get(i).expect("checked by the model"));
            let term = decode_term(code, &model.library).expect("checked by the model");
            (term, (start..end).map(entry).collect())
        });
        Self {
            inputs: model.input.len(),
            latent: model.latent(),
            scaling: scaling.map(|(mean, scale)| (mean, 1.0 / scale)).collect(),
            encoder: layers(&model.encoder),
            decoder: layers(&model.decoder),
            terms: terms.collect(),
        }
    }
}

fn layers(network: &Network<'_>) -> Vec<Layer> {
    let mut words = network.words().iter().map(|word| f32::from_le_bytes(*word));
    let layer = |widths: &[u16]| {
        let (inputs, outputs) = (usize::from(widths[0]), usize::from(widths[1]));
        let weights: Vec<f32> = words.by_ref().take(inputs * outputs).collect();
        let weight = |o: usize, i: usize| if o < outputs { weights[weight_index(inputs, outputs, o, i)] } else { 0.0 };
        let firsts = || (0..outputs).step_by(PANEL);
        let panels = firsts().flat_map(|first| (0..inputs).map(move |i| (first, i)));
        let panels = panels.map(|(first, i)| std::array::from_fn(|k| weight(first + k, i))).collect();
        let biases: Vec<f32> = words.by_ref().take(outputs).collect();
        let bias = |o: usize| biases.get(o).copied().unwrap_or(0.0);
        let biases = firsts().map(|first| std::array::from_fn(|k| bias(first + k))).collect();
        Layer { inputs, outputs, panels, biases }
    };
    network.widths().windows(2).map(layer).collect()
}

/// Rows of states and their predicted derivatives.
pub struct Chunks<'c> {
    pub kernel: &'c Kernel,
    pub states: &'c [f32],
    pub predicted: &'c mut [f32],
}

impl WithSimd for Chunks<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { kernel, states, predicted } = self;
        let n = kernel.inputs;
        let mut run = Run::new(simd, kernel);
        for (states, predicted) in states.chunks(n * CHUNK).zip(predicted.chunks_mut(n * CHUNK)) {
            for (states, predicted) in states.chunks(n * S::F32_LANES).zip(predicted.chunks_mut(n * S::F32_LANES)) {
                run.load(states);
                simd.vectorize(Step(&mut run));
                run.store(predicted);
            }
        }
    }
}

/// A function of its own with the instruction set's features.
struct Step<'r, 'k, S: Simd>(&'r mut Run<'k, S>);

impl<S: Simd> pulp::NullaryFnOnce for Step<'_, '_, S> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.0.step();
    }
}

/// Memory of the samples in the lanes of one vector; lengths are padded to whole panels.
struct Run<'k, S: Simd> {
    simd: S,
    kernel: &'k Kernel,
    states: Vec<S::f32s>,
    latent: Vec<S::f32s>,
    rates: Vec<S::f32s>,
    predicted: Vec<S::f32s>,
    /// Hidden values and their derivatives, of a layer and of the next.
    hidden: [Vec<S::f32s>; 4],
}

impl<'k, S: Simd> Run<'k, S> {
    fn new(simd: S, kernel: &'k Kernel) -> Self {
        let zero = simd.splat_f32s(0.0);
        let widest = kernel.encoder.iter().chain(&kernel.decoder).map(Layer::padded).max().unwrap_or(0);
        let padded = |count: usize| vec![zero; count.next_multiple_of(PANEL)];
        Self {
            simd,
            kernel,
            states: padded(kernel.inputs),
            latent: padded(kernel.latent),
            rates: padded(kernel.latent),
            predicted: padded(kernel.inputs),
            hidden: std::array::from_fn(|_| vec![zero; widest]),
        }
    }

    /// Scales rows of states into the lanes; lanes without a row keep what they have.
    fn load(&mut self, rows: &[f32]) {
        let states = bytemuck::cast_slice_mut::<S::f32s, f32>(&mut self.states);
        for (lane, row) in rows.chunks_exact(self.kernel.inputs).enumerate() {
            for (i, (state, (mean, reciprocal))) in row.iter().zip(&self.kernel.scaling).enumerate() {
                states[i * S::F32_LANES + lane] = (state - mean) * reciprocal;
            }
        }
    }

    fn store(&self, rows: &mut [f32]) {
        let predicted = bytemuck::cast_slice::<S::f32s, f32>(&self.predicted);
        for (lane, row) in rows.chunks_exact_mut(self.kernel.inputs).enumerate() {
            row.iter_mut().enumerate().for_each(|(i, to)| *to = predicted[i * S::F32_LANES + lane]);
        }
    }

    #[inline(always)]
    fn step(&mut self) {
        let Self { simd, kernel, states, latent, rates, predicted, hidden } = self;
        forward(*simd, &kernel.encoder, states, latent, hidden);
        rate(*simd, &kernel.terms, latent, rates);
        tangent(*simd, &kernel.decoder, latent, rates, predicted, hidden);
    }
}

/// Computes y = network(x), as `core::network::float::forward`.
#[inline(always)]
fn forward<S: Simd>(simd: S, layers: &[Layer], x: &[S::f32s], y: &mut [S::f32s], hidden: &mut [Vec<S::f32s>; 4]) {
    let Some((last, inner)) = layers.split_last() else { return y.copy_from_slice(x) };
    let [from, to, ..] = hidden;
    for (n, layer) in inner.iter().enumerate() {
        let to_h = &mut to[..layer.padded()];
        layer.affine(simd, if n == 0 { x } else { &from[..layer.inputs] }, to_h);
        sigmoids(simd, to_h);
        std::mem::swap(from, to);
    }
    last.affine(simd, if inner.is_empty() { x } else { &from[..last.inputs] }, y);
}

/// Computes dy = (∂network/∂x)(x) dx, as `core::network::float::tangent`.
#[inline(always)]
fn tangent<S: Simd>(
    simd: S,
    layers: &[Layer],
    x: &[S::f32s],
    dx: &[S::f32s],
    dy: &mut [S::f32s],
    hidden: &mut [Vec<S::f32s>; 4],
) {
    let Some((last, inner)) = layers.split_last() else { return dy.copy_from_slice(dx) };
    let [from, to, d_from, d_to] = hidden;
    let one = simd.splat_f32s(1.0);
    for (n, layer) in inner.iter().enumerate() {
        let (h, dh) = if n == 0 { (x, dx) } else { (&from[..layer.inputs], &d_from[..layer.inputs]) };
        let (to_h, to_dh) = (&mut to[..layer.padded()], &mut d_to[..layer.padded()]);
        layer.affine(simd, h, to_h);
        sigmoids(simd, to_h);
        layer.linear(simd, dh, to_dh);
        for (h, dh) in to_h.iter().zip(to_dh) {
            *dh = simd.mul_f32s(*dh, simd.mul_f32s(*h, simd.sub_f32s(one, *h)));
        }
        std::mem::swap(from, to);
        std::mem::swap(d_from, d_to);
    }
    last.linear(simd, if inner.is_empty() { dx } else { &d_from[..last.inputs] }, dy);
}

impl Layer {
    /// Computes W x + b.
    #[inline(always)]
    fn affine<S: Simd>(&self, simd: S, x: &[S::f32s], y: &mut [S::f32s]) {
        let panels = self.panels.chunks_exact(self.inputs).zip(&self.biases);
        for ((panel, biases), y) in panels.zip(y.as_chunks_mut::<PANEL>().0) {
            let mut sums = [simd.splat_f32s(0.0); PANEL];
            for (sum, bias) in sums.iter_mut().zip(biases) {
                *sum = simd.splat_f32s(*bias);
            }
            *y = accumulated(simd, panel, x, sums);
        }
    }

    /// Computes W x.
    #[inline(always)]
    fn linear<S: Simd>(&self, simd: S, x: &[S::f32s], y: &mut [S::f32s]) {
        for (panel, y) in self.panels.chunks_exact(self.inputs).zip(y.as_chunks_mut::<PANEL>().0) {
            *y = accumulated(simd, panel, x, [simd.splat_f32s(0.0); PANEL]);
        }
    }
}

/// Sums and a panel of W x, each output in the order of the inputs.
#[inline(always)]
fn accumulated<S: Simd>(
    simd: S,
    panel: &[[f32; PANEL]],
    x: &[S::f32s],
    mut sums: [S::f32s; PANEL],
) -> [S::f32s; PANEL] {
    for (weights, x) in panel.iter().zip(x) {
        for (sum, weight) in sums.iter_mut().zip(weights) {
            *sum = simd.add_f32s(*sum, simd.mul_f32s(simd.splat_f32s(*weight), *x));
        }
    }
    sums
}

/// Computes the rates Θ(z) Ξ, as `core::dynamics::Dynamics::rate`.
#[inline(always)]
fn rate<S: Simd>(simd: S, terms: &[(Term, Vec<(usize, f32)>)], z: &[S::f32s], rates: &mut [S::f32s]) {
    rates.fill(simd.splat_f32s(0.0));
    for (term, entries) in terms {
        let theta = value(simd, term, z);
        for (equation, coefficient) in entries {
            let product = simd.mul_f32s(simd.splat_f32s(*coefficient), theta);
            rates[*equation] = simd.add_f32s(rates[*equation], product);
        }
    }
}

#[inline(always)]
fn value<S: Simd>(simd: S, term: &Term, z: &[S::f32s]) -> S::f32s {
    let angle =
        |variable: u8, harmonic: u16| simd.mul_f32s(simd.splat_f32s(f32::from(harmonic)), z[usize::from(variable)]);
    match *term {
        Term::Monomial(monomial) => {
            let factors = monomial.factors().iter().map(|&factor| z[usize::from(factor)]);
            factors.reduce(|product, factor| simd.mul_f32s(product, factor)).unwrap_or(simd.splat_f32s(1.0))
        }
        Term::Sin { variable, harmonic } => sin(simd, angle(variable, harmonic)),
        Term::Cos { variable, harmonic } => cos(simd, angle(variable, harmonic)),
        Term::Power { variable } => {
            lane_by_lane::<S>(z[usize::from(variable)], |z| Term::Power { variable: 0 }.eval(&[z]))
        }
        Term::OddPower { variable } => {
            lane_by_lane::<S>(z[usize::from(variable)], |z| Term::OddPower { variable: 0 }.eval(&[z]))
        }
    }
}
