//! A random model of any size whose monitor is set to its own residual on a signal, so that this
//! signal is the healthy machine. Shared by the tests and the example `paper_sizes`.
#![allow(dead_code, reason = "each of the two uses a part")]

use ballrace_core::device::Device;
use ballrace_core::dynamics::{Dynamics, TERM_WORDS, encode_term};
use ballrace_core::input_check::ScreenConfig;
use ballrace_core::library::Library;
use ballrace_core::model::{Input, Model, Scaling};
use ballrace_core::monitor::MonitorConfig;
use ballrace_core::network::{Arithmetic, Network, fixed, float::word_count, to_fixed};
use ballrace_core::states::{Alignment, Estimator, Orders, StateSpec};
use ballrace_core::{Floats, Word};

pub const SAMPLE_RATE_HZ: f32 = 25_600.0;
pub const FULL_SCALE: f32 = 50.0;
pub const STUCK_AFTER: u32 = 8;
pub const BLOCK: u32 = 64;

pub const SAVITZKY_GOLAY: Estimator = Estimator::SavitzkyGolay { excess: 0, stretch: 1.25 };
pub const KALMAN: Estimator = Estimator::Kalman { cutoff: 0.22 };

/// Uniform numbers in −1…1.
pub struct Noise(pub u32);

impl Noise {
    pub fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / (1 << 23) as f32 - 1.0
    }
}

/// A made-up vibration, m/s²: two tones and noise.
pub fn signal(count: usize, seed: u32) -> Vec<f32> {
    let mut noise = Noise(seed);
    (0..count).map(|i| (i as f32 * 0.37).sin() * 4.0 + (i as f32 * 1.9).cos() + 0.5 * noise.next()).collect()
}

#[derive(Clone, Copy)]
pub struct Sizes {
    pub dimension: usize,
    pub latent: usize,
    pub hidden: u16,
    pub arithmetic: Arithmetic,
    pub degree: usize,
    pub harmonics: usize,
    /// Terms of the library that are used.
    pub nonzeros: usize,
    /// Equations that each of them is in.
    pub equations: usize,
    /// Hidden layers of each network.
    pub depth: usize,
    /// Whether the library has powers.
    pub powers: bool,
    pub orders: Orders,
    pub alignment: Alignment,
    pub estimator: Estimator,
    /// Full scale of the sensor, m/s².
    pub full_scale: f32,
}

pub const SMALL: Sizes = Sizes {
    dimension: 3,
    latent: 2,
    hidden: 12,
    arithmetic: Arithmetic::Float,
    degree: 3,
    harmonics: 2,
    nonzeros: 9,
    equations: 1,
    depth: 1,
    powers: false,
    orders: Orders::Even,
    alignment: Alignment::Half,
    estimator: Estimator::Differences,
    full_scale: FULL_SCALE,
};

/// The paper's best model, Machines 2026, 14(6), 620, with 40 terms of its library in use.
pub const PAPER: Sizes = Sizes { dimension: 8, latent: 8, hidden: 256, degree: 2, harmonics: 2, nonzeros: 40, ..SMALL };
/// The binary form of a random model for which `healthy` is healthy.
pub fn model(sizes: Sizes, healthy: &[f32]) -> Vec<u8> {
    let bytes = build(sizes, MonitorConfig::new(BLOCK, 0.0, 1.0));
    let model = Model::from_bytes(&bytes).unwrap();
    let mut scratch = vec![0.0; Device::scratch_len(&model)];
    let mut device = Device::new(&model, &mut scratch).unwrap();
    let levels: Vec<f32> = healthy.iter().filter_map(|s| device.push(*s).block).map(|b| b.level).collect();
    let count = levels.len() as f32;
    let mean = levels.iter().sum::<f32>() / count;
    let variance = levels.iter().map(|l| (l - mean).powi(2)).sum::<f32>() / count;
    build(sizes, MonitorConfig::from_levels(BLOCK, mean, variance.sqrt()))
}

fn fixed_words(network: &Network<'_>) -> Vec<Word> {
    let mut words = vec![[0; 4]; fixed::word_count(network.widths()).unwrap()];
    to_fixed(network, &mut words).unwrap();
    words
}

fn build(sizes: Sizes, monitor: MonitorConfig) -> Vec<u8> {
    let Sizes {
        dimension,
        latent,
        hidden,
        arithmetic,
        degree,
        harmonics,
        nonzeros,
        equations,
        depth,
        orders,
        alignment,
        estimator,
        ..
    } = sizes;
    let mut noise = Noise(7);
    let mut random =
        |count: usize, scale: f32| -> Vec<Word> { (0..count).map(|_| (scale * noise.next()).to_le_bytes()).collect() };
    // A difference of order k of white noise has variance C(2k, k), about 4^k / √(πk).
    let power = |k: usize| 2.0_f32.powi(k as i32).to_le_bytes();
    let zeros = vec![[0; 4]; dimension];
    let ones = vec![1.0_f32.to_le_bytes(); dimension];
    let state_scale: Vec<_> = (0..dimension).map(|i| power(orders.state(i))).collect();
    let derivative_scale: Vec<_> = (0..dimension).map(|i| power(orders.state(i) + 1)).collect();
    let widths = |from: usize, to: usize| [vec![from as u16], vec![hidden; depth], vec![to as u16]].concat();
    let (up, down) = (widths(dimension, latent), widths(latent, dimension));
    let (encoder, decoder) = (random(word_count(&up), 0.5), random(word_count(&down), 0.5));
    let [encoder, decoder] = [(&up, encoder), (&down, decoder)].map(|(widths, words)| match arithmetic {
        Arithmetic::Float => words,
        Arithmetic::Fixed => fixed_words(&Network::new(widths, Arithmetic::Float, &words).unwrap()),
    });
    let library = Library::new(latent, degree, harmonics).unwrap().with_powers(sizes.powers);
    // Spread over the whole library, so that every kind of term takes part.
    let term = |i: usize| encode_term(library.term(i * library.len() / nonzeros).unwrap());
    let terms: Vec<[Word; TERM_WORDS]> = (0..nonzeros).map(term).collect();
    let ends: Vec<Word> = (1..=nonzeros).map(|i| ((i * equations) as u32).to_le_bytes()).collect();
    let equation = |i: usize| ((i / equations + i % equations) % latent) as u32;
    let count = nonzeros * equations;
    let equations: Vec<Word> = (0..count).map(|i| equation(i).to_le_bytes()).collect();
    let coefficients = random(count, 0.5);
    let model = Model::new(Model {
        sample_rate_hz: SAMPLE_RATE_HZ,
        input: Input::VirtualStates(StateSpec { dimension, orders, alignment, estimator }),
        states: Scaling { mean: Floats(&zeros), scale: Floats(&state_scale) },
        derivatives: Scaling { mean: Floats(&zeros), scale: Floats(&derivative_scale) },
        encoder: Network::new(&up, arithmetic, &encoder).unwrap(),
        decoder: Network::new(&down, arithmetic, &decoder).unwrap(),
        library,
        dynamics: Dynamics { terms: &terms, ends: &ends, equations: &equations, coefficients: Floats(&coefficients) },
        residual_spread: Floats(&ones),
        screen: ScreenConfig { full_scale: sizes.full_scale, stuck_after: STUCK_AFTER },
        monitor,
    })
    .unwrap();
    let mut bytes = vec![0; model.byte_len()];
    model.to_bytes(&mut bytes).unwrap();
    bytes
}
