//! Training, theory (15) and (16): shuffled batches, sequential thresholding of Ξ, early stop, refinement with the
//! zeros frozen.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::adam::Adam;
use super::engine::Engine;
use super::gradient::{Lambdas, Losses};
use super::layout::Layout;
use super::settings::RunSettings;
use crate::model::samples::Samples;

const SETTINGS: RunSettings = RunSettings::DEFAULT;

/// Options of a training.
///
/// [`TrainConfig::default`] is the paper's Table 2 with two differences: a limit on the gradient steps, and sequential
/// thresholding as in Champion et al. 2019, but by a term's share of power instead of a coefficient's absolute size.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainConfig {
    /// Weights of the losses.
    pub lambdas: Lambdas,
    /// Adam's learning rate.
    pub learning_rate: f32,
    /// Samples in a batch.
    pub batch: usize,
    /// Epoch limit, refinement not counted.
    pub epochs: usize,
    /// Limit of the gradient steps, refinement not counted: bounds the time on long recordings.
    pub max_steps: usize,
    /// Share of its equation's power below which a term's coefficient is masked, theory (16); 0 never.
    pub threshold: f64,
    /// Applications of the threshold, evenly over the planned steps; one more precedes the refinement.
    pub threshold_rounds: usize,
    /// Steps of the refinement, with the zeros frozen and without L_reg, as a share of the planned steps.
    pub refine: f64,
    /// Checks of the held-out loss without improvement that end the training; 0 never.
    pub patience: usize,
    /// Seed of initial weights and shuffles.
    pub seed: u64,
}

impl Default for TrainConfig {
    fn default() -> Self {
        Self {
            lambdas: Lambdas::PAPER,
            learning_rate: 1e-3,
            batch: 1024,
            epochs: 500,
            max_steps: 6000,
            threshold: 1e-3,
            threshold_rounds: 4,
            refine: 0.2,
            patience: 8,
            seed: 0,
        }
    }
}

/// Result of a training.
#[derive(Clone, Debug, PartialEq)]
pub struct Trained {
    /// All parameters, in the order of [`Layout`].
    pub parameters: Vec<f32>,
    /// Losses of the last batch.
    pub last_batch: Losses,
    /// Epochs, refinement included; the last may be partial.
    pub epochs: usize,
    /// Gradient steps, refinement included.
    pub steps: usize,
    /// Whether the held-out loss ended the training early.
    pub stopped_early: bool,
    /// Nonzero coefficients of Ξ.
    pub active: usize,
}

/// State of a training run, for a progress display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Steps done.
    pub step: usize,
    /// Steps planned.
    pub of: usize,
    /// Losses of the last batch.
    pub losses: Losses,
    /// Nonzero coefficients of Ξ.
    pub active: usize,
}

/// Initial parameters: weights and biases uniform in ±1/√inputs, Ξ 0.01, as in the reference implementations.
pub fn initial_parameters(layout: &Layout, rng: &mut ChaCha8Rng) -> Vec<f32> {
    use rand::RngExt;
    let mut parameters = vec![0.0; layout.parameter_count()];
    for layer in [&layout.encoder, &layout.decoder].into_iter().flat_map(|n| n.layers()) {
        let limit = 1.0 / (layer.inputs as f32).sqrt();
        for p in &mut parameters[layer.weights.start..layer.biases.end] {
            *p = rng.random_range(-limit..limit);
        }
    }
    parameters[layout.xi()].fill(SETTINGS.initial_coefficient);
    parameters
}

/// Rescales the encoder's output layer so that the latent variables start with mean 0 and standard
/// deviation 1 on the samples: the columns 1, z, z², sin z, … of a z that hardly varies are nearly collinear.
fn standardise_latent(layout: &Layout, parameters: &mut [f32], samples: &Samples<f32>) {
    let Some(last) = layout.encoder.layers().pop() else { return };
    let (mut mean, mut square) = (vec![0.0; layout.latent], vec![0.0; layout.latent]);
    let count = for_each_latent(layout, parameters, samples, |z| {
        for ((m, s), z) in mean.iter_mut().zip(&mut square).zip(z) {
            *m += f64::from(*z);
            *s += f64::from(z * z);
        }
    });
    for i in 0..layout.latent {
        let mean = mean[i] / count;
        let spread = (square[i] / count - mean * mean).max(0.0).sqrt();
        if spread > 0.0 {
            let scale = (1.0 / spread) as f32;
            parameters[last.weights.clone()][i * last.inputs..][..last.inputs].iter_mut().for_each(|w| *w *= scale);
            let bias = &mut parameters[last.biases.clone()][i];
            *bias = (*bias - mean as f32) * scale;
        }
    }
}

/// Trains on `train`; `held_out` (may be empty) only decides the early stop and which parameters are kept.
pub fn train(
    layout: &Layout,
    train: &Samples<f32>,
    held_out: &Samples<f32>,
    config: &TrainConfig,
    progress: &mut dyn FnMut(Progress),
) -> Trained {
    let mut rng = ChaCha8Rng::seed_from_u64(config.seed);
    let mut parameters = initial_parameters(layout, &mut rng);
    standardise_latent(layout, &mut parameters, train);
    let mut run = Run {
        engine: Engine::new(layout.clone(), config.batch.max(1)),
        adam: Adam::new(parameters.len()),
        keep: vec![1.0; parameters.len()],
        parameters,
        order: (0..train.len() as u32).collect(),
        at: 0,
        rng,
        last: Losses::default(),
        steps: 0,
    };
    let per_epoch = train.len().div_ceil(config.batch.max(1));
    let planned = (config.epochs * per_epoch).min(config.max_steps);
    let refine = if config.threshold > 0.0 { (planned as f64 * config.refine) as usize } else { 0 };
    let mut stopped_early = false;

    let rounds = if config.threshold > 0.0 { config.threshold_rounds } else { 0 };
    let mut best: Option<(f64, Vec<f32>)> = None;
    let mut since_best = 0;
    let check_every = (planned / SETTINGS.checks).max(1);
    for step in 1..=planned {
        run.step(train, config, config.lambdas);
        if (1..=rounds).any(|round| step == round * planned / (rounds + 1)) {
            run.threshold(layout, train, config.threshold);
            best = None; // parameters from before a threshold belong to another model
        }
        if step % check_every == 0 || step == planned {
            progress(run.progress(planned + refine));
            let settled = step > rounds * planned / (rounds + 1);
            if settled && config.patience > 0 && !held_out.is_empty() {
                let loss = run.held_out_loss(held_out, config.lambdas);
                if best.as_ref().is_none_or(|(least, _)| loss < *least) {
                    best = Some((loss, run.parameters.clone()));
                    since_best = 0;
                } else {
                    since_best += 1;
                    if since_best >= config.patience {
                        stopped_early = true;
                        break;
                    }
                }
            }
        }
    }
    if let Some((_, parameters)) = best {
        run.parameters = parameters;
    }
    if refine > 0 {
        run.threshold(layout, train, config.threshold);
        // The old moments belong to a loss with the L1 term.
        run.adam = Adam::new(run.parameters.len());
        let lambdas = Lambdas { sparsity: 0.0, ..config.lambdas };
        for step in 1..=refine {
            run.step(train, config, lambdas);
            if step % check_every == 0 || step == refine {
                progress(run.progress(planned + refine));
            }
        }
    }
    Trained {
        active: run.active(),
        last_batch: run.last,
        epochs: run.steps.div_ceil(per_epoch.max(1)),
        steps: run.steps,
        stopped_early,
        parameters: run.parameters,
    }
}

struct Run {
    engine: Engine<f32>,
    adam: Adam,
    parameters: Vec<f32>,
    /// Mask: 0 for masked coefficients, 1 for everything else.
    keep: Vec<f32>,
    order: Vec<u32>,
    at: usize,
    rng: ChaCha8Rng,
    last: Losses,
    steps: usize,
}

impl Run {
    fn step(&mut self, samples: &Samples<f32>, config: &TrainConfig, lambdas: Lambdas) {
        if self.at == 0 {
            self.order.shuffle(&mut self.rng);
        }
        let end = (self.at + config.batch).min(self.order.len());
        let chosen = &self.order[self.at..end];
        self.last = self.engine.evaluate(&self.parameters, samples, chosen, lambdas);
        self.adam.step(&mut self.parameters, &self.engine.gradient, &self.keep, config.learning_rate);
        self.at = if end == self.order.len() { 0 } else { end };
        self.steps += 1;
    }

    fn progress(&self, of: usize) -> Progress {
        Progress { step: self.steps, of, losses: self.last, active: self.active() }
    }

    fn active(&self) -> usize {
        self.parameters[self.engine.layout().xi()].iter().filter(|v| **v != 0.0).count()
    }

    fn held_out_loss(&mut self, held_out: &Samples<f32>, lambdas: Lambdas) -> f64 {
        let chosen = spread(held_out.len());
        let mut total = 0.0;
        for part in chosen.chunks(self.engine.capacity()) {
            let losses = self.engine.evaluate(&self.parameters, held_out, part, lambdas);
            total += losses.total(lambdas) * part.len() as f64 / chosen.len() as f64;
        }
        total
    }

    /// Masks coefficients whose term carries less than `share` of its equation's power, theory (16).
    fn threshold(&mut self, layout: &Layout, samples: &Samples<f32>, share: f64) {
        let (theta_power, rate_power) = powers(layout, &self.parameters, samples);
        let xi = layout.xi();
        let equations = layout.latent;
        let (values, keep) = (&mut self.parameters[xi.clone()], &mut self.keep[xi]);
        for (n, (value, keep)) in values.iter_mut().zip(keep).enumerate() {
            let power = f64::from(*value * *value) * theta_power[n / equations];
            if power < share * rate_power[n % equations] {
                *value = 0.0;
                *keep = 0.0;
            }
        }
    }
}

/// Indices spread evenly over `len`, at most `max_judged`.
fn spread(len: usize) -> Vec<u32> {
    let count = len.min(SETTINGS.max_judged);
    (0..count).map(|i| (i * len / count) as u32).collect()
}

/// Mean squares of every term and of every equation's rate over the samples.
fn powers(layout: &Layout, parameters: &[f32], samples: &Samples<f32>) -> (Vec<f64>, Vec<f64>) {
    let xi = &parameters[layout.xi()];
    let (terms, equations) = (layout.terms.count(), layout.latent);
    let mut theta = vec![0.0; terms];
    let (mut theta_power, mut rate_power) = (vec![0.0; terms], vec![0.0; equations]);
    let count = for_each_latent(layout, parameters, samples, |z| {
        layout.library.row(z, &mut theta);
        theta_power.iter_mut().zip(&theta).for_each(|(p, t)| *p += f64::from(t * t));
        for (e, power) in rate_power.iter_mut().enumerate() {
            let rate: f32 = theta.iter().zip(xi[e..].iter().step_by(equations)).map(|(t, x)| t * x).sum();
            *power += f64::from(rate * rate);
        }
    });
    [&mut theta_power, &mut rate_power].into_iter().flatten().for_each(|p| *p /= count);
    (theta_power, rate_power)
}

/// Visits z = φ(x) of samples spread evenly; returns their number, at least 1.
fn for_each_latent(layout: &Layout, parameters: &[f32], samples: &Samples<f32>, mut visit: impl FnMut(&[f32])) -> f64 {
    let encoder = super::export::network(&layout.encoder, parameters);
    let encoder = encoder.view();
    let mut hidden = vec![0.0; 2 * encoder.hidden_width()];
    let mut z = vec![0.0; layout.latent];
    let chosen = spread(samples.len());
    for s in &chosen {
        encoder.forward(samples.row(*s as usize).0, &mut z, &mut hidden);
        visit(&z);
    }
    chosen.len().max(1) as f64
}
