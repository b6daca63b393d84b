//! Training, theory (15) and (16): shuffled batches and early stop with all terms; then a path of growing thresholds, after
//! each of which the terms that are left are refined, and the choice of one of them on validation recordings.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::adam::Adam;
use super::config::TrainConfig;
use super::engine::Engine;
use super::gradient::{Lambdas, Losses};
use super::layout::Layout;
use super::prune::prune;
use super::schedule::Schedule;
use super::settings::{PruneSettings, RunSettings};
use crate::model::path::{PathPoint, last_as_good_as_best};
use crate::model::samples::Samples;
use crate::stats::cancel;

const SETTINGS: RunSettings = RunSettings::DEFAULT;

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
    /// Whether the validation loss ended the training with all terms early.
    pub stopped_early: bool,
    /// Nonzero coefficients of Ξ.
    pub active: usize,
    /// Threshold chosen or stated.
    pub threshold: f64,
    /// Models on the path from all terms to few.
    pub path: Vec<PathPoint>,
    /// Unexplained share of the power of ẋ on the validation recordings; NaN without any.
    pub validation_error: f64,
}

/// Samples of a training, standardised alike.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sets<'a> {
    /// Validation recordings: they decide the early stop and choose the threshold.
    pub validation: &'a [Samples<f32>],
    /// Held-out recordings: scored along the path, used for nothing.
    pub held_out: &'a [Samples<f32>],
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

/// Trains on `train`.
pub fn train(
    layout: &Layout,
    train: &Samples<f32>,
    others: Sets<'_>,
    config: &TrainConfig,
    progress: &mut dyn FnMut(Progress),
) -> Trained {
    let mut rng = ChaCha8Rng::seed_from_u64(config.seed);
    let mut parameters = initial_parameters(layout, &mut rng);
    standardise_latent(layout, &mut parameters, train);
    let rates = scale_terms(layout, &mut parameters, train);
    let mut run = Run {
        // Room for no more than there are.
        engine: Engine::new(layout.clone(), config.batch.clamp(1, train.len().max(1))),
        adam: Adam::new(parameters.len()),
        rates,
        parameters,
        order: (0..train.len() as u32).collect(),
        at: 0,
        rng,
        last: Losses::default(),
        steps: 0,
    };
    let planned = config.planned_steps(layout, train.len());
    let thresholds = thresholds(config.threshold, others.validation.is_empty());
    let refine = if thresholds.is_empty() { 0 } else { ((planned as f64 * config.refine) as usize).max(1) };
    let of = planned + thresholds.len() * refine;
    let stopped_early = run.all_terms(train, others.validation, config, planned, &mut |run| progress(run.progress(of)));
    let lambdas = Lambdas { sparsity: 0.0, ..config.lambdas };
    let mut path: Vec<PathPoint> = Vec::new();
    let mut models: Vec<(Vec<f32>, Vec<f64>)> = Vec::new();
    for threshold in thresholds {
        if threshold > 0.0 {
            run.prune(train, lambdas, threshold);
        }
        if path.last().is_none_or(|last| last.terms != run.active()) {
            // The moments belong to a loss with the L1 term, or with other terms.
            run.adam = Adam::new(run.parameters.len());
            (0..refine).for_each(|step| run.step(train, config, lambdas, config.schedule.refinement(step, refine)));
        }
        progress(run.progress(of));
        let (validation, held_out) = (run.squares(others.validation, lambdas), run.squares(others.held_out, lambdas));
        let terms = run.active();
        path.push(PathPoint { threshold, terms, validation: r_squared(&validation), held_out: r_squared(&held_out) });
        models.push((run.parameters.clone(), unexplained(&validation)));
    }
    let chosen = match config.threshold {
        Some(_) => models.len().saturating_sub(1),
        None => {
            let errors: Vec<_> = models.iter().map(|(_, errors)| errors.clone()).collect();
            last_as_good_as_best(&errors, config.immaterial)
        }
    };
    if chosen < models.len() {
        run.parameters = models.swap_remove(chosen).0;
    }
    let errors = unexplained(&run.squares(others.validation, lambdas));
    Trained {
        active: run.active(),
        last_batch: run.last,
        epochs: run.steps.div_ceil(config.steps_per_epoch(train.len()).max(1)),
        steps: run.steps,
        stopped_early,
        threshold: path.get(chosen).map_or(0.0, |point| point.threshold),
        path,
        validation_error: errors.iter().sum::<f64>() / errors.len() as f64,
        parameters: run.parameters,
    }
}

/// Thresholds of the path: 0 and, up to the one that is stated, 1e-5 to 1e-1; none where it is stated that all terms are kept.
fn thresholds(stated: Option<f64>, no_validation: bool) -> Vec<f64> {
    let PruneSettings { min_exponent, per_decade, intervals, .. } = PruneSettings::DEFAULT;
    let grid = (0..=intervals).map(|k| 10f64.powf(min_exponent + f64::from(k) / per_decade));
    match stated {
        Some(stated) if stated <= 0.0 => Vec::new(),
        Some(stated) => std::iter::once(0.0).chain(grid.filter(|t| *t < stated)).chain([stated]).collect(),
        None if no_validation => vec![0.0],
        None => std::iter::once(0.0).chain(grid).collect(),
    }
}

/// Learning rates of all parameters, as shares of Adam's. A term's coefficient starts and moves in inverse proportion to the
/// term's RMS where that is over 1: z⁹ of a standardised z has 5,900.
fn scale_terms(layout: &Layout, parameters: &mut [f32], samples: &Samples<f32>) -> Vec<f32> {
    let mut rates = vec![1.0; parameters.len()];
    let mut power = vec![0.0; layout.terms.count()];
    let mut theta = vec![0.0; power.len()];
    let count = for_each_latent(layout, parameters, samples, |z| {
        layout.library.row(z, &mut theta);
        power.iter_mut().zip(&theta).for_each(|(p, t)| *p += f64::from(*t).powi(2));
    });
    for (n, place) in layout.xi().enumerate() {
        let scale = (1.0 / (power[n / layout.latent] / count).sqrt().max(1.0)) as f32;
        rates[place] = scale;
        parameters[place] *= scale;
    }
    rates
}

struct Run {
    engine: Engine<f32>,
    adam: Adam,
    parameters: Vec<f32>,
    /// Learning rate of each parameter as a share of Adam's: 0 for masked coefficients.
    rates: Vec<f32>,
    order: Vec<u32>,
    at: usize,
    rng: ChaCha8Rng,
    last: Losses,
    steps: usize,
}

impl Run {
    /// One step, at a `share` of the learning rate.
    fn step(&mut self, samples: &Samples<f32>, config: &TrainConfig, lambdas: Lambdas, share: f32) {
        cancel::check();
        if self.at == 0 {
            self.order.shuffle(&mut self.rng);
        }
        let end = self.at.saturating_add(config.batch).min(self.order.len());
        let chosen = &self.order[self.at..end];
        self.last = self.engine.evaluate(&self.parameters, samples, chosen, lambdas);
        self.adam.step(&mut self.parameters, &self.engine.gradient, &self.rates, share * config.learning_rate);
        self.at = if end == self.order.len() { 0 } else { end };
        self.steps += 1;
    }

    fn progress(&self, of: usize) -> Progress {
        Progress { step: self.steps, of, losses: self.last, active: self.active() }
    }

    fn active(&self) -> usize {
        self.parameters[self.engine.layout().xi()].iter().filter(|v| **v != 0.0).count()
    }

    /// Planned steps with all terms, at a constant learning rate fewer if the validation loss no longer improves: its best
    /// parameters are kept. Returns whether it ended early.
    fn all_terms(
        &mut self,
        samples: &Samples<f32>,
        validation: &[Samples<f32>],
        config: &TrainConfig,
        planned: usize,
        progress: &mut dyn FnMut(&Self),
    ) -> bool {
        let mut best: Option<(f64, Vec<f32>)> = None;
        let (mut since_best, mut stopped) = (0, false);
        let check_every = (planned / SETTINGS.checks).max(1);
        for step in 1..=planned {
            self.step(samples, config, config.lambdas, config.schedule.share(step - 1, planned));
            if step % check_every != 0 && step != planned {
                continue;
            }
            progress(self);
            if config.patience == 0 || validation.is_empty() {
                continue;
            }
            let loss = validation
                .iter()
                .map(|recording| self.mean_loss(recording, config.lambdas).total(config.lambdas))
                .sum();
            since_best += 1;
            if best.as_ref().is_none_or(|(least, _)| loss < *least) {
                best = Some((loss, self.parameters.clone()));
                since_best = 0;
            }
            if config.schedule == Schedule::Constant && since_best >= config.patience {
                stopped = true;
                break;
            }
        }
        if let Some((_, parameters)) = best {
            self.parameters = parameters;
        }
        stopped
    }

    /// Mean losses over samples of a recording, spread evenly.
    fn mean_loss(&mut self, recording: &Samples<f32>, lambdas: Lambdas) -> Losses {
        let chosen = spread(recording.len());
        let mut mean = Losses::default();
        for part in chosen.chunks(self.engine.capacity()) {
            let share = part.len() as f64 / chosen.len() as f64;
            mean.add_share(&self.engine.evaluate(&self.parameters, recording, part, lambdas), share);
        }
        mean
    }

    /// Squares of each recording.
    fn squares(&mut self, recordings: &[Samples<f32>], lambdas: Lambdas) -> Vec<Squares> {
        let of = |recording: &Samples<f32>| Squares {
            error: self.mean_loss(recording, lambdas).derivative * recording.dx.len() as f64,
            power: recording.dx.iter().map(|v| f64::from(v * v)).sum(),
        };
        recordings.iter().map(of).collect()
    }

    /// Removes terms that are worth less than `share` of the power of ẋ.
    fn prune(&mut self, samples: &Samples<f32>, lambdas: Lambdas, share: f64) {
        prune(self.engine.layout(), &mut self.parameters, samples, lambdas, share);
        for place in self.engine.layout().xi() {
            if self.parameters[place] == 0.0 {
                self.rates[place] = 0.0;
            }
        }
    }
}

/// Sums of squares over a recording.
#[derive(Clone, Copy, Debug)]
struct Squares {
    /// Of the residual of ẋ.
    error: f64,
    /// Of ẋ.
    power: f64,
}

/// Unexplained share of each recording: relative to its own power, or a loud recording decides alone.
fn unexplained(recordings: &[Squares]) -> Vec<f64> {
    recordings.iter().map(|squares| squares.error / squares.power).collect()
}

/// R² over all recordings and derivatives together; `None` without any. Standardised derivatives have nearly equal powers, so
/// that this is nearly the mean of theory (22).
fn r_squared(recordings: &[Squares]) -> Option<f64> {
    let sum = |of: fn(&Squares) -> f64| recordings.iter().map(of).sum::<f64>();
    (!recordings.is_empty()).then(|| 1.0 - sum(|squares| squares.error) / sum(|squares| squares.power))
}

/// Indices spread evenly over `len`, at most `max_judged`.
fn spread(len: usize) -> Vec<u32> {
    let count = len.min(SETTINGS.max_judged);
    (0..count).map(|i| (i * len / count) as u32).collect()
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
