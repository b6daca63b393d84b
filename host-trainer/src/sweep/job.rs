//! One fit of a sweep.

use std::time::Instant;

use ballrace_core::library::Library;
use ballrace_core::states::{Orders, StateSpec};
use serde::{Deserialize, Serialize};

use super::config::Sizes;
use super::method::Method;
use crate::model::fit::choice::{AlignmentKind, EstimatorKind};
use crate::model::fit::report::CREATED_BY;
use crate::model::fit::{FitConfig, FitError, ScoredModel, Solver, Split, score_fit};
use crate::model::sindy_nn::config::{PAPER_UNITS, TrainConfig};
use crate::model::sindy_nn::gradient::{Lambdas, SparsityNorm};
use crate::model::stlsq::StlsqConfig;
use crate::recording::input::Series;
use crate::rivals::{self, BothScores, Rival};
use crate::signal::surrogate::SurrogateKind;
use crate::signal::wavelet::denoise::Denoising;

/// Recordings of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// One channel of each recording.
    pub series: Vec<Series>,
    /// Common sample rate, Hz.
    pub sample_rate_hz: f64,
}

/// Fit of a grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Job {
    /// Recording; `None` for all together.
    pub recording: Option<String>,
    /// Sizes of the library.
    pub sizes: Sizes,
    /// Whether the library has the powers of two thirds.
    pub powers: bool,
    /// Solver, or rival.
    pub solver: Method,
    /// Alignment of the finite differences.
    pub alignment: AlignmentKind,
    /// Estimator of the states, with its default parameters; all but differences need the causal alignment.
    pub estimator: EstimatorKind,
    /// `"none"`, or the wavelet by which the recordings are denoised.
    pub filter: String,
    /// λ1, λ2, λ3.
    pub lambda: [f64; 3],
    /// Norm of the coefficients that λ3 weighs.
    pub sparsity: SparsityNorm,
    /// Seed.
    pub seed: u64,
    /// Surrogate fits for the null.
    pub null: usize,
    /// Kind of the surrogates.
    pub null_kind: SurrogateKind,
    /// Whether the same model is fitted in the causal alignment too.
    pub causal: bool,
    /// Epochs of SINDy-NN.
    pub epochs: usize,
    /// Checksum of the samples, of all recordings of the fit; empty before the job is run.
    pub samples: String,
    /// Program and version.
    pub program: String,
}

/// Name of no filter.
pub const NO_FILTER: &str = "none";

impl Default for Job {
    /// The paper's model: one surrogate, 500 epochs.
    fn default() -> Self {
        Self {
            recording: None,
            sizes: Sizes::default(),
            powers: false,
            solver: Method::default(),
            alignment: AlignmentKind::default(),
            estimator: EstimatorKind::default(),
            filter: NO_FILTER.into(),
            lambda: [Lambdas::PAPER.derivative, Lambdas::PAPER.latent, Lambdas::PAPER.sparsity],
            sparsity: SparsityNorm::default(),
            seed: 0,
            null: 1,
            null_kind: SurrogateKind::default(),
            causal: true,
            epochs: TrainConfig::PAPER.epochs.unwrap_or_default(),
            samples: String::new(),
            program: CREATED_BY.into(),
        }
    }
}

/// Result of a fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The fit.
    pub job: Job,
    /// Functions of its library; 0 of a rival.
    pub functions: usize,
    /// Coefficients that are not 0, of a rival its parameters; `None` if the fit failed.
    pub terms: Option<usize>,
    /// R² in sample.
    pub r2: Option<f64>,
    /// R² on the validation part, which chooses the threshold.
    pub r2_validation: Option<f64>,
    /// R² held out.
    pub r2_held_out: Option<f64>,
    /// R² of the next sample in the causal alignment, held out.
    pub r2_causal: Option<f64>,
    /// Mean R² in sample on surrogates.
    pub r2_null: Option<f64>,
    /// Mean R² of the next sample in the causal alignment on surrogates, held out.
    pub r2_causal_null: Option<f64>,
    /// Time of the fit with its null, s.
    pub seconds: f64,
    /// Why the fit failed.
    pub error: Option<String>,
}

impl Row {
    /// Row of a fit without scores.
    pub fn failed(job: &Job, functions: usize, error: Option<String>) -> Self {
        Self {
            job: job.clone(),
            functions,
            terms: None,
            r2: None,
            r2_validation: None,
            r2_held_out: None,
            r2_causal: None,
            r2_null: None,
            r2_causal_null: None,
            seconds: 0.0,
            error,
        }
    }
}

impl Job {
    /// Row of this fit.
    pub fn fit(&self, material: &Material) -> Row {
        if let Some(rival) = self.solver.rival() {
            return self.rival_row(rival, material);
        }
        let begin = Instant::now();
        let fitted = self.fitted(material);
        let library = Library::new(self.sizes.nmd, self.sizes.nd, self.sizes.nf);
        let row = Row {
            seconds: begin.elapsed().as_secs_f64(),
            ..Row::failed(self, library.map_or(0, |l| l.with_powers(self.powers).len()), None)
        };
        let ScoredModel { scores, terms, r2_validation } = match fitted {
            Ok(fitted) => fitted,
            Err(error) => return Row { error: Some(error.to_string()), ..row },
        };
        let count = scores.null.len() as f64;
        let null = scores.null.iter().map(|null| null.in_sample).sum::<f64>() / count;
        let causal_null = scores.null.iter().map(|null| null.causal).sum::<Option<f64>>().map(|sum| sum / count);
        Row {
            terms: Some(terms),
            r2_validation: finite(r2_validation),
            r2: finite(scores.in_sample.mean()),
            r2_held_out: finite(scores.held_out.mean()),
            r2_causal: scores.causal.next_sample.and_then(finite),
            r2_null: finite(null),
            r2_causal_null: causal_null.and_then(finite),
            ..row
        }
    }

    /// Row of a rival: its derivatives and its next sample are a training each, and so are those of each surrogate.
    fn rival_row(&self, rival: Rival, material: &Material) -> Row {
        let begin = Instant::now();
        let failed = |error: String| Row { error: Some(error), ..Row::failed(self, 0, None) };
        let split = match self.split(material) {
            Ok(split) => split,
            Err(error) => return failed(error),
        };
        let score = |split: &Split| rivals::score_both(rival, split, self.spec(), self.causal, self.seed);
        let nulls = (0..self.null as u64).map(|k| score(&split.surrogate(self.null_kind, self.seed, k)));
        let (own, nulls) = match (score(&split), nulls.collect::<Result<Vec<_>, _>>()) {
            (Ok(own), Ok(nulls)) => (own, nulls),
            (Err(error), _) | (_, Err(error)) => return failed(error),
        };
        let mean = |of: fn(&BothScores) -> Option<f64>| {
            let sum: Option<f64> = nulls.iter().map(of).sum();
            sum.map(|sum| sum / nulls.len() as f64).and_then(finite)
        };
        let BothScores { derivatives, next_sample } = own;
        Row {
            terms: Some(derivatives.parameters),
            r2: finite(derivatives.in_sample),
            r2_validation: finite(derivatives.validation),
            r2_held_out: finite(derivatives.held_out),
            r2_causal: next_sample.and_then(|next| finite(next.held_out)),
            r2_null: mean(|null| Some(null.derivatives.in_sample)),
            r2_causal_null: mean(|null| Some(null.next_sample?.held_out)),
            seconds: begin.elapsed().as_secs_f64(),
            ..Row::failed(self, 0, None)
        }
    }

    /// Parts of the recordings, as a fit splits them.
    fn split(&self, material: &Material) -> Result<Split, String> {
        let spec = self.spec();
        spec.check().map_err(|error| error.to_string())?;
        Ok(Split::holding_out(&self.series(material), FitConfig::default().hold_out_every, spec.warm_up()))
    }

    /// Virtual states.
    fn spec(&self) -> StateSpec {
        StateSpec {
            dimension: self.sizes.nmd,
            orders: Orders::Even,
            alignment: self.alignment.into(),
            estimator: self.estimator.with(None, None, None),
        }
    }

    /// Recordings of this fit, denoised if it says so.
    fn series(&self, material: &Material) -> Vec<Series> {
        self.own(material).map(|series| self.filtered(series, material.sample_rate_hz)).collect()
    }

    /// Job with the checksum of its samples: a row of other samples by the same names is no row of this job.
    pub fn identified(&self, material: &Material) -> Self {
        let bytes: Vec<u8> =
            self.own(material).flat_map(|series| &series.samples).flat_map(|sample| sample.to_le_bytes()).collect();
        Self { samples: format!("crc32:{:08x}", ballrace_core::model::crc32(&bytes)), ..self.clone() }
    }

    /// Recordings of this fit.
    fn own<'a>(&'a self, material: &'a Material) -> impl Iterator<Item = &'a Series> {
        material.series.iter().filter(|series| self.recording.as_ref().is_none_or(|name| *name == series.name))
    }

    fn fitted(&self, material: &Material) -> Result<ScoredModel, FitError> {
        let [derivative, latent, sparsity] = self.lambda;
        let train = TrainConfig {
            lambdas: Lambdas { derivative, latent, sparsity, norm: self.sparsity },
            epochs: Some(self.epochs),
            ..TrainConfig::PAPER
        };
        let solver = match self.solver {
            Method::Stlsq => Solver::Stlsq(StlsqConfig::default()),
            _ => Solver::SindyNn { hidden: vec![PAPER_UNITS], train },
        };
        let config = FitConfig {
            spec: self.spec(),
            degree: self.sizes.nd,
            harmonics: self.sizes.nf,
            powers: self.powers,
            solver,
            null_fits: self.null,
            null_kind: self.null_kind,
            causal: self.causal,
            trainings: 1,
            seed: self.seed,
            ..FitConfig::default()
        };
        score_fit(&self.series(material), material.sample_rate_hz, &config)
    }

    /// Recording as it is, or denoised.
    fn filtered(&self, series: &Series, sample_rate_hz: f64) -> Series {
        let Ok(wavelet) = self.filter.parse() else { return series.clone() };
        let denoising = Denoising::of_paper(wavelet, sample_rate_hz);
        let samples: Vec<f64> = series.samples.iter().map(|v| f64::from(*v)).collect();
        let samples = denoising.apply(&samples).into_iter().map(|v| v as f32).collect();
        Series { name: series.name.clone(), samples }
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
