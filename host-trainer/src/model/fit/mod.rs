//! Fit of a model to recordings, with four scores: in sample, held out, causal, null.
//!
//! [`fit`] runs the same [`Solver`] on the recordings in the chosen alignment, on the recordings in the causal
//! alignment, and on surrogates of them in both. Every score is taken by core's evaluator, sample by
//! sample, as on the device. The findings of a diagnosis enter the library by [`terms`].

pub mod choice;
mod describe;
pub mod limits;
mod monitor_levels;
pub mod report;
pub mod score;
mod scored;
pub(crate) mod settings;
mod single_fit;
pub mod terms;
pub mod text;
pub mod verdict;

use ballrace_core::library::Library;
use ballrace_core::model::ModelError;
use ballrace_core::network::{Arithmetic, FixedError};
use ballrace_core::states::{Alignment, Estimator, MAX_DIMENSION, Orders, SpecError, StateSpec};

use crate::model::OwnedModel;
use crate::model::sindy_nn::config::{PAPER_UNITS, TrainConfig};
use crate::model::stlsq::{StlsqConfig, noise_terms};
use crate::recording::input::Series;
use crate::signal::surrogate::SurrogateKind;
use report::{Report, Training};
use scored::{Scored, scored};
pub use scored::{ScoredModel, score_fit};
use settings::{LibrarySettings, RowSettings};
pub use single_fit::Split;

/// Solver for Ξ.
#[derive(Clone, Debug, PartialEq)]
pub enum Solver {
    /// An autoencoder with sparse dynamics in its latent variables.
    SindyNn {
        /// Widths of the encoder's hidden layers; reversed for the decoder.
        hidden: Vec<usize>,
        /// Options of the training.
        train: TrainConfig,
    },
    /// Sequentially thresholded least squares on the scaled states themselves.
    Stlsq(StlsqConfig),
}

/// Options of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct FitConfig {
    /// Virtual states: dimension, orders, alignment.
    pub spec: StateSpec,
    /// Polynomial degree n_D, 0 for none.
    pub degree: usize,
    /// Harmonics n_F, 0 for none.
    pub harmonics: usize,
    /// Whether the library has the powers ⅔ of each variable, theory (112).
    pub powers: bool,
    /// Latent variables of SINDy-NN; `None`: as many as states. Least squares has no latent variables.
    pub latent: Option<usize>,
    /// Solver for Ξ.
    pub solver: Solver,
    /// Arithmetic of the networks, on the device and in every score. The training is in single precision.
    pub arithmetic: Arithmetic,
    /// Every n-th recording is held out; at least 2.
    pub hold_out_every: usize,
    /// Surrogate fits for the null.
    pub null_fits: usize,
    /// Kind of the surrogates.
    pub null_kind: SurrogateKind,
    /// Whether the same model is fitted in the causal alignment too.
    pub causal: bool,
    /// Trainings of SINDy-NN, each from a seed of its own; the model is the best on the validation recordings.
    pub trainings: usize,
    /// Seed of initial weights, shuffles and surrogates.
    pub seed: u64,
    /// Samples per block of the monitor; `None`: a tenth of a second, less in short recordings.
    pub block: Option<u32>,
    /// Full scale of the sensor, m/s²; 0: derived from the healthy recordings.
    pub full_scale: f32,
    /// False alarms a day for which the monitor's limit is set; positive.
    pub false_alarms_per_day: f64,
    /// Time from the start of one recording to that of the next, s; `None`: the device monitors without a pause.
    pub interval_s: Option<f64>,
}

/// Failure of a fit.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// Sizes out of range.
    #[error(
        "library of degree {degree} with {harmonics} harmonics in {variables} variables: expected 1 to 16 variables, degree up to 11 and at least one term"
    )]
    Library {
        /// Variables.
        variables: usize,
        /// Degree.
        degree: usize,
        /// Harmonics.
        harmonics: usize,
    },
    /// Recordings most of which the sensor cannot hold.
    #[error("full scale {full_scale} m/s²: found {found} of {total} samples at or beyond it, expected few")]
    Saturated {
        /// Full scale, m/s².
        full_scale: f32,
        /// Samples at or beyond it.
        found: usize,
        /// All samples.
        total: usize,
    },
    /// Library of too many functions.
    #[error("library of {found} functions: expected at most {most}; more take gigabytes and hours")]
    Functions {
        /// Functions found.
        found: usize,
        /// Most functions.
        most: usize,
    },
    /// Latent variables out of range.
    #[error("latent: found {found}, expected 1 to 16 variables")]
    Latent {
        /// Latent variables found.
        found: usize,
    },
    /// Dimension out of range.
    #[error("n_MD {found}: expected 1 to 16")]
    Dimension {
        /// Dimension found.
        found: usize,
    },
    /// Virtual states that cannot be streamed.
    #[error("virtual states: {0}")]
    States(SpecError),
    /// Widths out of range.
    #[error("hidden widths {found:?}: expected 1 to 5 layers of 1 to 1024 units")]
    Hidden {
        /// Widths found.
        found: Vec<usize>,
    },
    /// Networks without a form in fixed point.
    #[error("fixed point: {0}")]
    FixedPoint(FixedError),
    /// Too few rows of virtual states.
    #[error("{found} samples give {rows} rows of virtual states, expected at least {expected}")]
    TooShort {
        /// Samples.
        found: usize,
        /// Rows.
        rows: usize,
        /// Rows needed.
        expected: usize,
    },
    /// A sample that is not finite.
    #[error("{name}, sample {index}: found {found}, expected a finite number")]
    NotFinite {
        /// Name of the recording.
        name: String,
        /// Index of the sample.
        index: usize,
        /// Value found.
        found: f32,
    },
    /// Full scale out of range.
    #[error("full scale: found {found} m/s², expected a positive number, or 0 to derive it")]
    FullScale {
        /// Full scale found, m/s².
        found: f32,
    },
    /// Rate of false alarms, or interval between recordings, out of range.
    #[error("{name}: found {found}, expected a positive number")]
    FalseAlarms {
        /// Name of the option.
        name: &'static str,
        /// Value found.
        found: f64,
    },
    /// Block length out of range.
    #[error("block: found {found} samples, expected 1 to the {total} there are")]
    Block {
        /// Block length found, samples.
        found: u32,
        /// Samples of all recordings.
        total: usize,
    },
    /// A channel that does not vary.
    #[error("every sample is {value} m/s², expected a channel that varies")]
    Constant {
        /// Value of every sample, m/s².
        value: f32,
    },
    /// The training diverged.
    #[error("the training diverged: {0}; a smaller learning rate may help")]
    Diverged(ModelError),
}

/// Stage of a fit, for a progress display.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// Name of the stage.
    pub name: String,
    /// Share of the whole fit that is done, 0 to 1.
    pub done: f64,
}

/// A fitted model with its report.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// The model.
    pub model: OwnedModel,
    /// Scores, equations, diagnosis, verdict.
    pub report: Report,
}

/// Fits a model to recordings of the healthy machine.
///
/// # Errors
/// [`FitError`]: options or recordings out of range, found before the first fit, or a training that diverged.
///
/// # Examples
///
/// ```
/// use ballrace::model::fit::{FitConfig, Solver, fit};
/// use ballrace::model::stlsq::StlsqConfig;
/// use ballrace::recording::input::Series;
///
/// let samples = (0..4000).map(|k| (0.3 * k as f32).sin() + 0.1 * (1.7 * k as f32).sin()).collect();
/// let config = FitConfig {
///     degree: 1,
///     harmonics: 0,
///     solver: Solver::Stlsq(StlsqConfig::default()),
///     null_fits: 0,
///     ..FitConfig::default()
/// };
/// let fitted = fit(&[Series { name: "two tones".into(), samples }], 1000.0, &config, &|_| ())?;
/// // Two tones are predictable.
/// assert!(fitted.report.scores.causal.next_sample.is_some_and(|r2| r2 > 0.99));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fit(
    recordings: &[Series],
    sample_rate_hz: f64,
    config: &FitConfig,
    progress: &(dyn Fn(Stage) + Sync),
) -> Result<Fitted, FitError> {
    let Scored { main, split, scores, surrogate } = scored(recordings, sample_rate_hz, config, progress)?;
    let (model, monitor) = monitor_levels::monitor(&main, &split, recordings, sample_rate_hz, config)?;
    let described = describe::describe(&main, &split);
    let noise = surrogate.map(|(surrogate, fitted)| match &config.solver {
        Solver::Stlsq(stlsq) => noise_terms(
            main.layout.library,
            &main.standardised(&split.train),
            &main.standardised(&surrogate.train),
            &main.equations,
            stlsq,
        ),
        Solver::SindyNn { .. } => fitted.terms() as f64 / fitted.layout.latent as f64,
    });
    let report = Report {
        created_by: report::CREATED_BY.into(),
        training: Training::new(&split, sample_rate_hz, config, &main),
        verdict: verdict::verdict(&scores),
        scores,
        equations: described.equations,
        terms_kept: main.terms(),
        terms_noise_would_keep: noise,
        path: main.path,
        diagnosis: described.diagnosis,
        monitor,
    };
    Ok(Fitted { model, report })
}

fn check(recordings: &[Series], config: &FitConfig) -> Result<(), FitError> {
    config.spec.check().map_err(|error| match error {
        SpecError::Dimension { found } => FitError::Dimension { found },
        error => FitError::States(error),
    })?;
    let variables = config.variables();
    if let Some(found) = config.latent.filter(|latent| !(1..=MAX_DIMENSION).contains(latent)) {
        return Err(FitError::Latent { found });
    }
    let Some(library) = Library::new(variables, config.degree, config.harmonics) else {
        return Err(FitError::Library { variables, degree: config.degree, harmonics: config.harmonics });
    };
    let (found, most) = (library.len(), LibrarySettings::DEFAULT.max_functions);
    if found > most {
        return Err(FitError::Functions { found, most });
    }
    if let Solver::SindyNn { hidden, .. } = &config.solver {
        let in_range = |w: &usize| (1..=ballrace_core::network::MAX_WIDTH).contains(w);
        if !(1..ballrace_core::network::MAX_LAYERS).contains(&hidden.len()) || !hidden.iter().all(in_range) {
            return Err(FitError::Hidden { found: hidden.clone() });
        }
        if config.arithmetic == Arithmetic::Fixed && hidden.len() != 1 {
            return Err(FitError::FixedPoint(FixedError::Shape));
        }
    }
    if !(config.full_scale.is_finite() && config.full_scale >= 0.0) {
        return Err(FitError::FullScale { found: config.full_scale });
    }
    for (name, found) in
        [("false alarms per day", config.false_alarms_per_day), ("interval", config.interval_s.unwrap_or(1.0))]
    {
        if !(found.is_finite() && found > 0.0) {
            return Err(FitError::FalseAlarms { name, found });
        }
    }
    let total: usize = recordings.iter().map(|s| s.samples.len()).sum();
    if let Some(found) = config.block.filter(|b| *b == 0 || *b as usize > total) {
        return Err(FitError::Block { found, total });
    }
    let mut values = recordings.iter().flat_map(|s| &s.samples);
    if let Some(value) = values.next().copied()
        && total > 1
        && values.all(|v| *v == value)
    {
        return Err(FitError::Constant { value });
    }
    for series in recordings {
        if let Some(index) = series.samples.iter().position(|v| !v.is_finite()) {
            return Err(FitError::NotFinite { name: series.name.clone(), index, found: series.samples[index] });
        }
    }
    let saturated = |v: &&f32| config.full_scale > 0.0 && v.abs() >= config.full_scale;
    let found = recordings.iter().flat_map(|s| &s.samples).filter(saturated).count();
    if found as f64 > RowSettings::DEFAULT.max_saturated * total as f64 {
        return Err(FitError::Saturated { full_scale: config.full_scale, found, total });
    }
    let rows = |series: &Series| (series.samples.len() + 1).saturating_sub(config.spec.warm_up());
    let (found, rows) = (recordings.iter().map(|s| s.samples.len()).sum(), recordings.iter().map(rows).sum());
    let least = RowSettings::DEFAULT;
    let expected = least.rows_per_dimension * config.spec.dimension.max(least.min_dimension);
    if rows < expected { Err(FitError::TooShort { found, rows, expected }) } else { Ok(()) }
}

/// Checks that all parts of a split have enough rows.
fn check_split(split: &Split, config: &FitConfig) -> Result<(), FitError> {
    for part in [&split.train, &split.validation, &split.held_out] {
        let rows = |s: &Series| (s.samples.len() + 1).saturating_sub(config.spec.warm_up());
        let (found, rows) = (part.iter().map(|s| s.samples.len()).sum(), part.iter().map(rows).sum::<usize>());
        let least = RowSettings::DEFAULT;
        let expected = least.split_rows_per_dimension * config.spec.dimension.max(least.min_dimension);
        if rows < expected {
            return Err(FitError::TooShort { found, rows, expected });
        }
    }
    Ok(())
}

impl Default for FitConfig {
    /// The sizes of the paper's best model, Machines 2026, 14(6), 620, tables 2 and 3: n_D = 2, n_MD = 8, n_F = 2, one hidden
    /// layer of 256 units; five surrogates.
    fn default() -> Self {
        Self {
            spec: StateSpec {
                dimension: 8,
                orders: Orders::Even,
                alignment: Alignment::Half,
                estimator: Estimator::Differences,
            },
            degree: 2,
            harmonics: 2,
            powers: false,
            latent: None,
            solver: Solver::SindyNn { hidden: vec![PAPER_UNITS], train: TrainConfig::default() },
            arithmetic: Arithmetic::Float,
            hold_out_every: 5,
            null_fits: 5,
            null_kind: SurrogateKind::default(),
            causal: true,
            trainings: 3,
            seed: 0,
            block: None,
            full_scale: 0.0,
            false_alarms_per_day: settings::LimitSettings::DEFAULT.false_alarms_per_day,
            interval_s: None,
        }
    }
}

impl FitConfig {
    /// Variables of the library.
    pub fn variables(&self) -> usize {
        match self.solver {
            Solver::SindyNn { .. } => self.latent.unwrap_or(self.spec.dimension),
            Solver::Stlsq(_) => self.spec.dimension,
        }
    }
}

#[cfg(test)]
mod estimator_tests;
#[cfg(test)]
mod tests;
