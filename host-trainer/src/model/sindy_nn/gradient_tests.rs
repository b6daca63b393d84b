//! The hand-derived gradient against finite differences in f64, and the losses against their
//! definitions written out sample by sample.

use ballrace_core::library::Library;

use super::engine::Engine;
use super::gradient::{Lambdas, SparsityNorm};
use super::layout::{Layout, NetworkLayout};
use crate::model::samples::Samples;

const LAMBDAS: Lambdas = Lambdas { derivative: 0.5, latent: 0.3, sparsity: 0.2, norm: SparsityNorm::Mean };

fn values(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / (1u64 << 30) as f64 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

fn layouts() -> Vec<(&'static str, Layout)> {
    let library = |n, d, f| Library::new(n, d, f).unwrap();
    let layout = |e: &[usize], d: &[usize], l| Layout::new(e, d, l).unwrap();
    vec![
        ("paper, small", layout(&[4, 19, 3], &[3, 17, 4], library(3, 2, 2))),
        ("deep", layout(&[11, 9, 7, 2], &[2, 6, 10, 11], library(2, 3, 1))),
        ("three hidden", layout(&[5, 12, 9, 10, 2], &[2, 9, 8, 11, 5], library(2, 2, 3))),
        ("linear", layout(&[5, 2], &[2, 5], library(2, 2, 0))),
        ("identity", layout(&[], &[], library(3, 3, 2))),
        ("Fourier only", layout(&[3, 8, 2], &[2, 8, 3], library(2, 0, 4))),
        ("powers", layout(&[4, 9, 3], &[3, 9, 4], library(3, 1, 1).with_powers(true))),
    ]
}

fn problem(layout: &Layout) -> (Vec<f64>, Samples<f64>, Vec<u32>) {
    let mut parameters = values(layout.parameter_count(), 7);
    // A masked coefficient has no gradient of L_reg.
    parameters[layout.xi().start + 1] = 0.0;
    let n = layout.inputs;
    let samples = Samples { inputs: n, x: values(n * 300, 11), dx: values(n * 300, 13) };
    // A full block and a padded one, out of order.
    let chosen = (0..190).map(|i| (i * 89) % 300).collect();
    (parameters, samples, chosen)
}

#[test]
fn gradient_equals_finite_differences() {
    for (name, layout) in layouts() {
        let (parameters, samples, chosen) = problem(&layout);
        let mut engine = Engine::new(layout.clone(), 256);
        engine.evaluate(&parameters, &samples, &chosen, LAMBDAS);
        let gradient = engine.gradient.clone();
        let mut shifted = parameters.clone();
        for (i, analytic) in gradient.iter().enumerate() {
            if parameters[i] == 0.0 {
                continue; // L_reg has a kink there
            }
            let h = 1e-5;
            let mut at = |offset: f64| {
                shifted[i] = parameters[i] + offset;
                engine.evaluate(&shifted, &samples, &chosen, LAMBDAS).total(LAMBDAS)
            };
            let numeric = (at(h) - at(-h)) / (2.0 * h);
            shifted[i] = parameters[i];
            let error = (analytic - numeric).abs() / (1e-4 + analytic.abs());
            assert!(error < 2e-5, "{name}, parameter {i}: by hand {analytic}, by differences {numeric}");
        }
    }
}

/// Value and tangent of a network at one sample.
fn plain(network: &NetworkLayout, p: &[f64], x: &[f64], dx: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut h, mut dh) = (x.to_vec(), dx.to_vec());
    let layers = network.layers();
    for (n, layer) in layers.iter().enumerate() {
        let row = |o: usize, v: &[f64]| -> f64 {
            p[layer.weights.clone()][o * layer.inputs..].iter().zip(v).map(|(w, v)| w * v).sum()
        };
        let a: Vec<f64> = (0..layer.outputs).map(|o| row(o, &h) + p[layer.biases.clone()][o]).collect();
        let da: Vec<f64> = (0..layer.outputs).map(|o| row(o, &dh)).collect();
        (h, dh) = if n + 1 == layers.len() {
            (a, da)
        } else {
            let s: Vec<f64> = a.iter().map(|a| 1.0 / (1.0 + (-a).exp())).collect();
            let ds = s.iter().zip(&da).map(|(s, da)| s * (1.0 - s) * da).collect();
            (s, ds)
        };
    }
    (h, dh)
}

#[test]
fn losses_equal_their_definitions() {
    for (name, layout) in layouts() {
        let (parameters, samples, chosen) = problem(&layout);
        let got = Engine::new(layout.clone(), 256).evaluate(&parameters, &samples, &chosen, LAMBDAS);
        let (n, m) = (layout.inputs, layout.latent);
        let xi = &parameters[layout.xi()];
        let (mut recon, mut derivative, mut latent) = (0.0, 0.0, 0.0);
        for s in &chosen {
            let range = *s as usize * n..(*s as usize + 1) * n;
            let (x, dx) = (&samples.x[range.clone()], &samples.dx[range]);
            let (z, dz) = plain(&layout.encoder, &parameters, x, dx);
            // Core's own terms, in f32: good to 1e-6.
            let z32: Vec<f32> = z.iter().map(|v| *v as f32).collect();
            let mut theta = vec![0.0; layout.library.len()];
            layout.library.row(&z32, &mut theta);
            let rate: Vec<f64> =
                (0..m).map(|e| theta.iter().enumerate().map(|(t, v)| f64::from(*v) * xi[t * m + e]).sum()).collect();
            let (x_hat, dx_hat) = plain(&layout.decoder, &parameters, &z, &rate);
            let square = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            recon += square(x, &x_hat) / (chosen.len() * n) as f64;
            derivative += square(dx, &dx_hat) / (chosen.len() * n) as f64;
            latent += square(&dz, &rate) / (chosen.len() * m) as f64;
        }
        let sparsity = xi.iter().map(|v| v.abs()).sum::<f64>() / xi.len() as f64;
        for (what, got, expected) in [
            ("recon", got.reconstruction, recon),
            ("dx", got.derivative, derivative),
            ("dz", got.latent, latent),
            ("L1", got.sparsity, sparsity),
        ] {
            assert!((got - expected).abs() < 1e-5 * (1.0 + expected), "{name} {what}: {got} for {expected}");
        }
    }
}

#[test]
fn f32_follows_f64_and_threads_change_nothing() {
    for (name, layout) in layouts() {
        let (parameters, samples, chosen) = problem(&layout);
        let narrow = |v: &[f64]| v.iter().map(|v| *v as f32).collect::<Vec<_>>();
        let samples32 = Samples { inputs: samples.inputs, x: narrow(&samples.x), dx: narrow(&samples.dx) };
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut engine = Engine::new(layout.clone(), 256);
                let losses = engine.evaluate(&narrow(&parameters), &samples32, &chosen, LAMBDAS);
                (losses, engine.gradient)
            })
        };
        let (one, two) = (run(1), run(2));
        assert_eq!(one, two, "{name}");
        let mut engine = Engine::new(layout.clone(), 256);
        engine.evaluate(&parameters, &samples, &chosen, LAMBDAS);
        let norm = engine.gradient.iter().fold(0.0f64, |m, g| m.max(g.abs()));
        for (narrow, wide) in one.1.iter().zip(&engine.gradient) {
            assert!((f64::from(*narrow) - wide).abs() < 1e-4 * norm, "{name}: {narrow} for {wide}");
        }
    }
}
