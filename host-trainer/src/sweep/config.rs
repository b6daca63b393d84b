//! `sweep.toml`: recordings, and the grid of the fits.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::job::{Job, Material, NO_FILTER};
use super::method::Method;
use super::preset::Preset;
use crate::model::fit::choice::{AlignmentKind, EstimatorKind};
use crate::model::sindy_nn::gradient::SparsityNorm;
use crate::recording::input::{Input, InputError};
use crate::recording::{Recording, bounded};
use crate::signal::surrogate::SurrogateKind;
use crate::signal::wavelet::Wavelet;

/// Study of a `sweep.toml`. Keys of the grid take one value or a list; the jobs are all their combinations.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Files and folders, relative to the file.
    pub recordings: Vec<PathBuf>,
    /// Channel; by default the first.
    pub channel: Option<String>,
    /// Index of the first recording and one past the last, from 0; by default all.
    pub range: Option<[usize; 2]>,
    /// Whether each recording is a fit of its own, as in the paper, or all are one.
    #[serde(default = "yes")]
    pub one_by_one: bool,
    /// Surrogate fits for the null.
    #[serde(default = "one")]
    pub null: usize,
    /// Kinds of the surrogates.
    #[serde(default)]
    null_kind: Many<SurrogateKind>,
    /// Whether the same models are fitted in the causal alignment too.
    #[serde(default = "yes")]
    pub causal: bool,
    /// Epochs of SINDy-NN.
    #[serde(default = "epochs")]
    pub epochs: usize,
    /// Models of a table or figure of the paper beside those stated.
    pub preset: Option<Preset>,
    /// Models, each with its own `nd`, `nmd` and `nf`: beside the grid of these three.
    #[serde(default)]
    pub model: Vec<Sizes>,
    /// Polynomial degrees n_D.
    #[serde(default)]
    nd: Many<usize>,
    /// Dimensions n_MD.
    #[serde(default)]
    nmd: Many<usize>,
    /// Fourier harmonics n_F.
    #[serde(default)]
    nf: Many<usize>,
    /// Whether there are the powers of two thirds.
    #[serde(default)]
    powers: Many<bool>,
    /// Solvers, and rivals.
    #[serde(default)]
    solver: Many<Method>,
    /// Alignments of the finite differences.
    #[serde(default)]
    alignment: Many<AlignmentKind>,
    /// Estimators of the states.
    #[serde(default)]
    estimator: Many<EstimatorKind>,
    /// `"none"`, or the wavelet by which the recordings are denoised.
    #[serde(default)]
    filter: Many<String>,
    /// Triples λ1, λ2, λ3.
    #[serde(default)]
    lambda: Many<[f64; 3]>,
    /// Norms of the coefficients that λ3 weighs.
    #[serde(default)]
    sparsity: Many<SparsityNorm>,
    /// Seeds.
    #[serde(default)]
    seed: Many<u64>,
    /// Folder of the file.
    #[serde(skip)]
    pub base: PathBuf,
}

/// Sizes of a library.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sizes {
    /// Name, such as the number in the paper's Table 3.
    #[serde(default)]
    pub name: String,
    /// Polynomial degree n_D.
    pub nd: usize,
    /// Dimension n_MD.
    pub nmd: usize,
    /// Fourier harmonics n_F.
    pub nf: usize,
}

/// One value or a list.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(untagged)]
enum Many<T> {
    #[default]
    Unstated,
    One(T),
    List(Vec<T>),
}

impl<T: Clone> Many<T> {
    fn or(&self, default: T) -> Vec<T> {
        match self {
            Self::Unstated => vec![default],
            Self::One(value) => vec![value.clone()],
            Self::List(values) => values.clone(),
        }
    }
}

const fn yes() -> bool {
    true
}

/// Every job with every value.
pub(super) fn each<T: Clone>(jobs: Vec<Job>, values: Vec<T>, set: impl Fn(&mut Job, T)) -> Vec<Job> {
    let with = |job: &Job, value: &T| {
        let mut job = job.clone();
        set(&mut job, value.clone());
        job
    };
    jobs.iter().flat_map(|job| values.iter().map(|value| with(job, value)).collect::<Vec<_>>()).collect()
}

const fn one() -> usize {
    1
}

const fn epochs() -> usize {
    500
}

/// Error in a `sweep.toml`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// Error of the operating system.
    #[error("{path}: {source}")]
    Io {
        /// File.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// Not TOML, or with a key that a sweep has not.
    #[error("{path}: {source}")]
    Toml {
        /// File.
        path: PathBuf,
        /// Cause, with its line.
        source: Box<toml::de::Error>,
    },
    /// A value out of range.
    #[error("{path}, {key}: found {found}, expected {expected}")]
    Value {
        /// File.
        path: PathBuf,
        /// Key.
        key: &'static str,
        /// Value.
        found: String,
        /// What it should be.
        expected: &'static str,
    },
}

/// Recordings of which a sweep cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MaterialError {
    /// Recordings without the channel, or of several rates.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A range beyond the recordings.
    #[error("range: found [{first}, {end}], expected within 0 to {count}")]
    Range {
        /// First recording.
        first: usize,
        /// One past the last.
        end: usize,
        /// Recordings there are.
        count: usize,
    },
    /// No bearing that ages.
    #[error("found no folder with an aging phase, expected one such as {}", super::preset::PAPER_BEARING)]
    NoAging,
    /// Bearings of different sample rates.
    #[error("{bearing}: found {found_hz} Hz, expected {expected_hz} Hz as the others")]
    Rate {
        /// Bearing.
        bearing: String,
        /// Its sample rate, Hz.
        found_hz: f64,
        /// Sample rate of the others, Hz.
        expected_hz: f64,
    },
}

impl Config {
    /// Reads a file; its paths become relative to the current folder.
    ///
    /// # Errors
    /// [`ConfigError`].
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let bytes = bounded::settings(path).map_err(|source| ConfigError::Io { path: path.to_owned(), source })?;
        let text = String::from_utf8_lossy(&bytes);
        let mut config: Self = toml::from_str(&text)
            .map_err(|source| ConfigError::Toml { path: path.to_owned(), source: Box::new(source) })?;
        config.check(path)?;
        let base = path.parent().unwrap_or(Path::new(""));
        config.base = base.to_owned();
        config.recordings.iter_mut().for_each(|recording| *recording = base.join(&*recording));
        Ok(config)
    }

    /// Checks the values; `path` is where they are from.
    ///
    /// # Errors
    /// [`ConfigError::Value`].
    pub fn check(&self, path: &Path) -> Result<(), ConfigError> {
        let refuse =
            |key, found: String, expected| Err(ConfigError::Value { path: path.to_owned(), key, found, expected });
        if self.recordings.is_empty() {
            return refuse("recordings", "none".into(), "at least one file or folder");
        }
        if let Some([first, end]) = self.range.filter(|[first, end]| first >= end) {
            return refuse("range", format!("[{first}, {end}]"), "the first recording and one past the last");
        }
        let filters = self.filter.or(NO_FILTER.into());
        if let Some(found) = filters.iter().find(|name| *name != NO_FILTER && name.parse::<Wavelet>().is_err()) {
            return refuse("filter", format!("`{found}`"), "none, db1 to db10, or sym2 to sym10");
        }
        if let Some(found) = self.solver.or(Method::default()).into_iter().find(|method| !method.is_built()) {
            return refuse(
                "solver",
                found.paper_name().into(),
                "a build with the feature rivals, or sindy-nn or stlsq",
            );
        }
        if self.lambda.or([0.0; 3]).iter().flatten().any(|l| !(l.is_finite() && *l >= 0.0)) {
            return refuse("lambda", "a negative or infinite number".into(), "three numbers that are not negative");
        }
        Ok(())
    }

    /// Channel of the recordings in the range, named by their paths relative to the file: files of two folders may have one name.
    ///
    /// # Errors
    /// [`MaterialError`].
    pub fn material(&self, recordings: &[Recording]) -> Result<Material, MaterialError> {
        let mut input = Input::from_recordings(recordings, self.channel.as_deref())?;
        for (series, recording) in input.series.iter_mut().zip(recordings) {
            let path = &recording.source.path;
            series.name = path.strip_prefix(&self.base).unwrap_or(path).display().to_string();
        }
        let count = input.series.len();
        let [first, end] = self.range.unwrap_or([0, count]);
        let series = input.series.get(first..end).ok_or(MaterialError::Range { first, end, count })?;
        Ok(Material { series: series.to_vec(), sample_rate_hz: input.sample_rate_hz })
    }

    /// Jobs of the grid on the recordings: all combinations, the recordings last.
    pub fn jobs(&self, material: &Material) -> Vec<Job> {
        let subjects: Vec<Option<String>> = match self.one_by_one {
            true => material.series.iter().map(|series| Some(series.name.clone())).collect(),
            false => vec![None],
        };
        let base = Job { null: self.null, causal: self.causal, epochs: self.epochs, ..Job::default() };
        let jobs = each(vec![base], self.sizes(), |job, sizes| job.sizes = sizes);
        let jobs = each(jobs, self.powers.or(false), |job, powers| job.powers = powers);
        let jobs = each(jobs, self.solver.or(Method::default()), |job, solver| job.solver = solver);
        let jobs = each(jobs, self.alignment.or(AlignmentKind::default()), |job, alignment| job.alignment = alignment);
        let jobs = each(jobs, self.estimator.or(EstimatorKind::default()), |job, estimator| job.estimator = estimator);
        let jobs = each(jobs, self.filter.or(NO_FILTER.into()), |job, filter| job.filter = filter);
        let jobs = each(jobs, self.lambda.or(Job::default().lambda), |job, lambda| job.lambda = lambda);
        let jobs = each(jobs, self.sparsity.or(SparsityNorm::default()), |job, norm| job.sparsity = norm);
        let jobs = each(jobs, self.null_kind.or(SurrogateKind::default()), |job, kind| job.null_kind = kind);
        let jobs = each(jobs, self.seed.or(0), |job, seed| job.seed = seed);
        each(jobs, subjects, |job, recording| job.recording = recording)
    }

    /// Sizes of the stated models, of the preset, and of the grid; the paper's best model if none is stated.
    fn sizes(&self) -> Vec<Sizes> {
        let mut sizes = self.model.clone();
        sizes.extend(self.preset.into_iter().flat_map(Preset::sizes));
        let has_grid = [&self.nd, &self.nmd, &self.nf].into_iter().any(|key| !matches!(key, Many::Unstated));
        if !has_grid && !sizes.is_empty() {
            return sizes;
        }
        for nd in self.nd.or(2) {
            for nmd in self.nmd.or(8) {
                sizes.extend(self.nf.or(2).into_iter().map(|nf| Sizes { name: String::new(), nd, nmd, nf }));
            }
        }
        sizes
    }
}
