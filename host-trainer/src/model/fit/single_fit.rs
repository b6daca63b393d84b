//! One fit of one solver in one alignment.

use ballrace_core::input_check::ScreenConfig;
use ballrace_core::library::Library;
use ballrace_core::model::Input;
use ballrace_core::monitor::MonitorConfig;
use ballrace_core::states::StateSpec;
use rayon::prelude::*;

use super::settings::SplitSettings;
use super::{FitConfig, FitError, Solver};
use crate::model::path::PathPoint;
use crate::model::samples::Samples;
use crate::model::sindy_nn::config::TrainConfig;
use crate::model::sindy_nn::export::{self, OwnedNetwork};
use crate::model::sindy_nn::layout::Layout;
use crate::model::sindy_nn::train::{Sets, Trained, train};
use crate::model::states::{self, Scales};
use crate::model::stlsq::{Equation, RFactor, StlsqConfig, fit_with_path};
use crate::model::{OwnedModel, Parts};
use crate::recording::input::Series;
use crate::signal::surrogate::SurrogateKind;

const SETTINGS: SplitSettings = SplitSettings::DEFAULT;

/// Recordings by what they are used for.
#[derive(Clone, Debug, PartialEq)]
pub struct Split {
    /// Recordings fitted to.
    pub train: Vec<Series>,
    /// Validation recordings: they choose thresholds, the early stop, and one of several trainings.
    pub validation: Vec<Series>,
    /// Held-out recordings: they score, and choose nothing.
    pub held_out: Vec<Series>,
    /// Places of the held-out ones among all recordings; empty if they are the end of the only one.
    pub held_out_places: Vec<usize>,
    /// Whether validation and held-out part are the end of the only recording.
    pub within: bool,
}

impl Split {
    /// Holds out every n-th recording, the last of each n, and of the others every n-th for validation, or, of few, the last
    /// fifth of each; of a single recording the last fifth is held out and the fifth before it is for validation.
    pub fn holding_out(recordings: &[Series], every: usize, warm_up: usize) -> Self {
        let least = warm_up + SETTINGS.min_piece_rows;
        if let [only] = recordings {
            let (first, last) = only.samples.split_at(only.samples.len() * 4 / 5);
            let (first, middle) = first.split_at(first.len() * 3 / 4);
            return Self {
                train: vec![Series { name: format!("{}, first 3/5", only.name), samples: first.to_vec() }],
                validation: pieces(&format!("{}, fourth 1/5", only.name), middle, least),
                held_out: vec![Series { name: format!("{}, last 1/5", only.name), samples: last.to_vec() }],
                held_out_places: Vec::new(),
                within: true,
            };
        }
        let every = every.clamp(2, recordings.len().max(2));
        let nth = |recordings: Vec<Series>| {
            let (others, nth): (Vec<_>, Vec<_>) =
                recordings.into_iter().enumerate().partition(|(n, _)| n % every != every - 1);
            let series = |part: Vec<(usize, Series)>| part.into_iter().map(|(_, series)| series).collect::<Vec<_>>();
            (series(others), series(nth))
        };
        let (others, held_out) = nth(recordings.to_vec());
        let held_out_places = (0..recordings.len()).filter(|n| n % every == every - 1).collect();
        if others.len() >= SETTINGS.min_validation * every {
            let (train, validation) = nth(others);
            return Self { train, validation, held_out, held_out_places, within: false };
        }
        let (mut train, mut validation) = (Vec::new(), Vec::new());
        for Series { name, samples } in others {
            let (first, last) = samples.split_at(samples.len() * 4 / 5);
            validation.extend(pieces(&format!("{name}, last 1/5"), last, least));
            train.push(Series { samples: first.to_vec(), name });
        }
        Self { train, validation, held_out, held_out_places, within: false }
    }

    /// Surrogates of all recordings, the `k`-th of their kind, split as these.
    pub fn surrogate(&self, kind: SurrogateKind, seed: u64, k: u64) -> Self {
        let part = |series: &[Series], which: u64| surrogates(series, kind, seed, 3 * k + which);
        Self {
            train: part(&self.train, 0),
            validation: part(&self.validation, 1),
            held_out: part(&self.held_out, 2),
            held_out_places: self.held_out_places.clone(),
            within: self.within,
        }
    }
}

fn surrogates(recordings: &[Series], kind: SurrogateKind, seed: u64, which: u64) -> Vec<Series> {
    let each = |(n, series): (usize, &Series)| Series {
        name: series.name.clone(),
        samples: kind
            .of(&series.samples, seed.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (which << 32) ^ n as u64),
    };
    recordings.par_iter().enumerate().map(each).collect()
}

/// Part of a recording in pieces of `least` samples or more, so that its error has a standard error.
fn pieces(name: &str, samples: &[f32], least: usize) -> Vec<Series> {
    let count = (samples.len() / least).clamp(1, SETTINGS.max_pieces);
    let pieces = samples.chunks(samples.len().div_ceil(count).max(1)).enumerate();
    pieces.map(|(n, piece)| Series { name: format!("{name}, piece {}", n + 1), samples: piece.to_vec() }).collect()
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
    /// Path from all terms to few.
    pub path: Vec<PathPoint>,
    /// Result of the training; `None` for least squares.
    pub trained: Option<Trained>,
}

impl SingleFit {
    /// Nonzero coefficients.
    pub fn terms(&self) -> usize {
        self.parts.xi.iter().filter(|v| **v != 0.0).count()
    }

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

/// Whether each standardised target has a variance.
fn varies(rows: &Samples<f32>) -> bool {
    let variance = |output: usize| {
        let values = || rows.dx.iter().skip(output).step_by(rows.inputs).map(|v| f64::from(*v));
        let mean = values().sum::<f64>() / rows.len() as f64;
        values().map(|v| (v - mean).powi(2)).sum::<f64>() / rows.len() as f64
    };
    !rows.is_empty() && (0..rows.inputs).all(|output| variance(output) > SETTINGS.min_variance)
}

/// Fits one model, trained from `seed`.
///
/// # Errors
/// Hidden widths that give no network, or a training that diverged.
pub fn fit_once(
    split: &Split,
    sample_rate_hz: f64,
    spec: StateSpec,
    config: &FitConfig,
    seed: u64,
    progress: &dyn Fn(f64),
) -> Result<SingleFit, FitError> {
    let library = Library::new(config.variables(), config.degree, config.harmonics)
        .expect("checked before")
        .with_powers(config.powers);
    let mut train_rows = rows(&split.train, spec);
    let scales = Scales::from_rows(&train_rows);
    train_rows.par_iter_mut().for_each(|rows| scales.apply(rows));
    // A recording that is too short or does not vary has no error relative to its own power.
    let judged = |recordings: &[Series]| {
        let mut rows = standardised(recordings, spec, &scales);
        rows.retain(varies);
        rows
    };
    let rows = Rows { validation: judged(&split.validation), held_out: judged(&split.held_out), train: train_rows };
    let found = match &config.solver {
        Solver::Stlsq(stlsq) => least_squares(library, &rows, stlsq),
        Solver::SindyNn { hidden, train } => {
            let train = TrainConfig { seed, ..train.clone() };
            network(library, spec.dimension, hidden, &rows, &train, progress)?
        }
    };
    progress(1.0);
    let network_on_device = |layout| {
        let trained = export::network(layout, &found.parameters);
        OwnedNetwork::converted(&trained.view(), config.arithmetic).map_err(FitError::FixedPoint)
    };
    let parts = Parts {
        sample_rate_hz,
        input: Input::VirtualStates(spec),
        encoder: network_on_device(&found.layout.encoder)?,
        decoder: network_on_device(&found.layout.decoder)?,
        xi: found.parameters[found.layout.xi()].to_vec(),
        library,
        // Provisional: the monitor's calibration replaces spread, screen and monitor.
        residual_spread: vec![1.0; scales.states.len()],
        scales,
        screen: ScreenConfig { full_scale: config.full_scale, stuck_after: 0 },
        monitor: MonitorConfig::new(1, 0.0, 1.0),
    };
    let model = parts.assemble().map_err(FitError::Diverged)?;
    let FittedCoefficients { layout, equations, path, trained, .. } = found;
    Ok(SingleFit { model, parts, layout, equations, path, trained })
}

/// Standardised rows of each part of a split.
struct Rows {
    train: Vec<Samples<f32>>,
    validation: Vec<Samples<f32>>,
    held_out: Vec<Samples<f32>>,
}

struct FittedCoefficients {
    layout: Layout,
    parameters: Vec<f32>,
    equations: Vec<Equation>,
    path: Vec<PathPoint>,
    trained: Option<Trained>,
}

fn least_squares(library: Library, rows: &Rows, config: &StlsqConfig) -> FittedCoefficients {
    let layout = Layout::new(&[], &[], library).expect("no networks to disagree");
    let parts = RFactor::from_each(library, &rows.train);
    let train = RFactor::merge(&parts.iter().collect::<Vec<_>>()).expect("at least one recording");
    let [validation, held_out] = [&rows.validation, &rows.held_out].map(|rows| RFactor::from_each(library, rows));
    let (equations, path) = fit_with_path(&train, &validation, &held_out, config);
    let mut parameters = vec![0.0; layout.parameter_count()];
    for (e, equation) in equations.iter().enumerate() {
        for (t, c) in equation.coefficients.iter().enumerate() {
            parameters[t * layout.latent + e] = *c as f32;
        }
    }
    FittedCoefficients { layout, parameters, equations, path, trained: None }
}

fn network(
    library: Library,
    inputs: usize,
    hidden: &[usize],
    rows: &Rows,
    config: &TrainConfig,
    progress: &dyn Fn(f64),
) -> Result<FittedCoefficients, FitError> {
    let latent = usize::from(library.variables);
    let encoder: Vec<usize> = [&[inputs], hidden, &[latent]].concat();
    let decoder: Vec<usize> = encoder.iter().rev().copied().collect();
    let layout = Layout::new(&encoder, &decoder, library).ok_or_else(|| FitError::Hidden { found: hidden.to_vec() })?;
    let all = states::concatenate(&rows.train);
    let others = Sets { validation: &rows.validation, held_out: &rows.held_out };
    let trained = train(&layout, &all, others, config, &mut |p| progress(p.step as f64 / p.of.max(1) as f64));
    Ok(FittedCoefficients {
        parameters: trained.parameters.clone(),
        path: trained.path.clone(),
        layout,
        equations: Vec::new(),
        trained: Some(trained),
    })
}
