//! One fit of one solver in one alignment.

use ballrace_core::input_check::ScreenConfig;
use ballrace_core::library::Library;
use ballrace_core::model::Input;
use ballrace_core::monitor::MonitorConfig;
use ballrace_core::states::StateSpec;
use rayon::prelude::*;

use super::settings::SplitSettings;
use super::{FitConfig, FitError, Solver};
use crate::model::samples::Samples;
use crate::model::sindy_nn::export;
use crate::model::sindy_nn::layout::Layout;
use crate::model::sindy_nn::train::{TrainConfig, Trained, train};
use crate::model::states::{self, Scales};
use crate::model::stlsq::{Equation, RFactor, StlsqConfig};
use crate::model::{OwnedModel, Parts};
use crate::recording::input::Series;

const SETTINGS: SplitSettings = SplitSettings::DEFAULT;

/// Recordings to fit to and held-out recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct Split {
    /// Recordings fitted to.
    pub train: Vec<Series>,
    /// Held-out recordings; they choose thresholds and the early stop.
    pub held_out: Vec<Series>,
    /// Whether the held-out part is the end of the only recording.
    pub within: bool,
}

impl Split {
    /// Holds out every n-th recording, the last of each n; of a single one its last fifth.
    pub fn holding_out(recordings: &[Series], every: usize, warm_up: usize) -> Self {
        if let [only] = recordings {
            let (first, last) = only.samples.split_at(only.samples.len() * 4 / 5);
            let part = |name: String, samples: &[f32]| Series { name, samples: samples.to_vec() };
            // In pieces, so that the held-out error has a standard error.
            let count = (last.len() / (warm_up + SETTINGS.min_piece_rows)).clamp(1, SETTINGS.max_pieces);
            let pieces = last.chunks(last.len().div_ceil(count).max(1)).enumerate();
            return Self {
                train: vec![part(format!("{}, first 4/5", only.name), first)],
                held_out: pieces.map(|(n, p)| part(format!("{}, last 1/5, piece {}", only.name, n + 1), p)).collect(),
                within: true,
            };
        }
        let every = every.clamp(2, recordings.len().max(2));
        let (mut train, mut held_out) = (Vec::new(), Vec::new());
        for (n, series) in recordings.iter().enumerate() {
            if n % every == every - 1 { &mut held_out } else { &mut train }.push(series.clone());
        }
        Self { train, held_out, within: false }
    }
}

/// A fitted model before its monitor is calibrated.
pub struct SingleFit {
    /// Model with a provisional monitor.
    pub model: OwnedModel,
    /// Parts of the model.
    pub parts: Parts,
    /// Sizes and parameter layout.
    pub layout: Layout,
    /// Least squares' equations with their thresholds; empty for SINDy-NN.
    pub equations: Vec<Equation>,
    /// Result of the training; `None` for least squares.
    pub trained: Option<Trained>,
}

impl SingleFit {
    /// Rows of recordings in this model's alignment and scaling.
    pub fn standardised(&self, recordings: &[Series]) -> Vec<Samples<f32>> {
        let Input::VirtualStates(spec) = self.parts.input else { return Vec::new() };
        standardised(recordings, spec, &self.parts.scales)
    }
}

fn rows(recordings: &[Series], spec: StateSpec) -> Vec<Samples<f32>> {
    recordings.par_iter().map(|s| states::rows(&s.samples, spec)).collect()
}

fn standardised(recordings: &[Series], spec: StateSpec, scales: &Scales) -> Vec<Samples<f32>> {
    let mut rows = rows(recordings, spec);
    rows.par_iter_mut().for_each(|rows| scales.apply(rows));
    rows
}

/// Fits one model.
///
/// # Errors
/// Hidden widths that give no network, or a training that diverged.
pub fn fit_once(
    split: &Split,
    sample_rate_hz: f64,
    spec: StateSpec,
    config: &FitConfig,
    progress: &dyn Fn(f64),
) -> Result<SingleFit, FitError> {
    let library = Library::new(config.variables(), config.degree, config.harmonics).expect("checked before");
    let mut train_rows = rows(&split.train, spec);
    let scales = Scales::from_rows(&train_rows);
    train_rows.par_iter_mut().for_each(|rows| scales.apply(rows));
    let held_out = standardised(&split.held_out, spec, &scales);
    let found = match &config.solver {
        Solver::Stlsq(stlsq) => least_squares(library, &train_rows, &held_out, stlsq),
        Solver::SindyNn { hidden, train } => {
            network(library, spec.dimension, hidden, &train_rows, &held_out, config, train, progress)?
        }
    };
    progress(1.0);
    let parts = Parts {
        sample_rate_hz,
        input: Input::VirtualStates(spec),
        encoder: export::network(&found.layout.encoder, &found.parameters),
        decoder: export::network(&found.layout.decoder, &found.parameters),
        xi: found.parameters[found.layout.xi()].to_vec(),
        library,
        // Provisional: the monitor's calibration replaces spread, screen and monitor.
        residual_spread: vec![1.0; scales.states.len()],
        scales,
        screen: ScreenConfig { full_scale: config.full_scale, stuck_after: 0 },
        monitor: MonitorConfig::new(1, 1.0, 1.0),
    };
    let model = parts.assemble().map_err(FitError::Diverged)?;
    Ok(SingleFit { model, parts, layout: found.layout, equations: found.equations, trained: found.trained })
}

struct FittedCoefficients {
    layout: Layout,
    parameters: Vec<f32>,
    equations: Vec<Equation>,
    trained: Option<Trained>,
}

fn least_squares(
    library: Library,
    train: &[Samples<f32>],
    held_out: &[Samples<f32>],
    config: &StlsqConfig,
) -> FittedCoefficients {
    let layout = Layout::new(&[], &[], library).expect("no networks to disagree");
    let parts = RFactor::from_each(library, train);
    let moments = RFactor::merge(&parts.iter().collect::<Vec<_>>()).expect("at least one recording");
    let held_out = RFactor::from_each(library, held_out);
    let equations = crate::model::stlsq::fit(&moments, &held_out, config);
    let mut parameters = vec![0.0; layout.parameter_count()];
    for (e, equation) in equations.iter().enumerate() {
        for (t, c) in equation.coefficients.iter().enumerate() {
            parameters[t * layout.latent + e] = *c as f32;
        }
    }
    FittedCoefficients { layout, parameters, equations, trained: None }
}

#[allow(clippy::too_many_arguments)]
fn network(
    library: Library,
    inputs: usize,
    hidden: &[usize],
    train_rows: &[Samples<f32>],
    held_out: &[Samples<f32>],
    config: &FitConfig,
    train_config: &TrainConfig,
    progress: &dyn Fn(f64),
) -> Result<FittedCoefficients, FitError> {
    let latent = usize::from(library.variables);
    let encoder: Vec<usize> = [&[inputs], hidden, &[latent]].concat();
    let decoder: Vec<usize> = encoder.iter().rev().copied().collect();
    let layout = Layout::new(&encoder, &decoder, library).ok_or_else(|| FitError::Hidden { found: hidden.to_vec() })?;
    let (all, judged) = (states::concatenate(train_rows), states::concatenate(held_out));
    let train_config = TrainConfig { seed: config.seed, ..train_config.clone() };
    let trained = train(&layout, &all, &judged, &train_config, &mut |p| progress(p.step as f64 / p.of.max(1) as f64));
    Ok(FittedCoefficients {
        parameters: trained.parameters.clone(),
        layout,
        equations: Vec::new(),
        trained: Some(trained),
    })
}
