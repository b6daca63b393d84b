//! Models: fit, prediction, export, and the device's monitor over recordings.

use std::path::PathBuf;

use ballrace::model::export::{Format, export};
use ballrace::model::fit::report::Report;
use ballrace::model::fit::{FitConfig, Solver, Stage, text};
use ballrace::model::replay::{Options, replay};
use ballrace::model::stlsq::StlsqConfig;
use ballrace::model::trace::Trace;
use ballrace::model::{OwnedModel, file};
use ballrace::recording::input::Input;
use ballrace::report;
use ballrace::report::monitor::Vibration;
use ballrace::signal::indicators::Indicators;
use ballrace_core::states::Alignment;
use numpy::{IntoPyArray, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::error::{input, other, python};
use crate::look::{Page, with_page};
use crate::recording::Recordings;
use crate::run::run;

/// Model of a healthy machine: sparse dynamics of virtual states, as the device runs it.
#[pyclass(module = "ballrace", frozen)]
pub struct Model {
    model: OwnedModel,
    report: Option<Report>,
    page: Option<String>,
}

#[pymethods]
impl Model {
    /// Model of a file that `save`, `export` or the command `fit` wrote.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        let (model, report) = file::read(&path).map_err(input)?;
        Ok(Self { model, report, page: None })
    }

    /// Writes the model with its report, whole or not at all.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        let report = self
            .report
            .as_ref()
            .ok_or_else(|| input("save: found a device's model, which has no report; export writes it as it is"))?;
        file::write(&path, &self.model, report).map_err(other)
    }

    /// Bytes for the device: format is "json", "bin", "rust" or "c".
    #[pyo3(signature = (format="bin"))]
    fn export<'py>(&self, format: &str, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let format = match format {
            "json" => Format::Json,
            "bin" => Format::Bin,
            "rust" => Format::Rust,
            "c" => Format::C,
            found => return Err(input(format!("format: found `{found}`, expected json, bin, rust or c"))),
        };
        Ok(PyBytes::new(py, &export(&self.model, format).map_err(other)?))
    }

    /// Report of the fit as a dict: scores, equations, limits. None for a device's model.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.report.as_ref().map(|report| python(py, report)).transpose()
    }

    /// Sample rate, Hz.
    #[getter]
    fn sample_rate_hz(&self) -> f64 {
        f64::from(self.model.view().sample_rate_hz)
    }

    /// One-step prediction of the derivatives over samples (float64 array (n,), m/s²).
    ///
    /// Returns a dict of float32 arrays: `measured` and `predicted`, each (rows, derivatives) in the model's scaled units;
    /// `residual` (rows,), root mean square in healthy spreads; and `time_s` (rows,) float64, of the sample that completed
    /// each row.
    fn predict<'py>(&self, samples: PyReadonlyArray1<'py, f64>, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let samples: Vec<f32> = samples.as_array().iter().map(|v| *v as f32).collect();
        let rate = self.sample_rate_hz();
        let trace = py.detach(|| Trace::record(&self.model.view(), &samples, rate, 0..samples.len()));
        let out = PyDict::new(py);
        let rows = trace.times_s.len();
        for (name, columns) in [("measured", &trace.measured), ("predicted", &trace.predicted)] {
            let flat: Vec<f32> = (0..rows).flat_map(|row| columns.iter().map(move |column| column[row])).collect();
            out.set_item(name, flat.into_pyarray(py).reshape([rows, columns.len()])?)?;
        }
        out.set_item("residual", trace.residual.into_pyarray(py))?;
        out.set_item("time_s", trace.times_s.into_pyarray(py))?;
        Ok(out)
    }

    /// The sparse equations and scores as text.
    #[pyo3(signature = (terms=6))]
    fn text(&self, terms: usize) -> String {
        self.report.as_ref().map_or_else(|| self.__repr__(), |report| text::report(report, terms))
    }

    /// Prints `text()`.
    #[pyo3(signature = (terms=6))]
    fn print(&self, terms: usize, py: Python<'_>) -> PyResult<()> {
        py.import("builtins")?.call_method1("print", (self.text(terms),)).map(|_| ())
    }

    fn __repr__(&self) -> String {
        format!("<Model: {} bytes on the device, {} Hz>", self.model.bytes().len(), self.sample_rate_hz())
    }

    fn _repr_html_(&self) -> String {
        match &self.page {
            Some(page) => Page::frame(page),
            None => format!("<pre>{}</pre>", crate::look::escaped(&self.text(6))),
        }
    }
}

/// Fits a model to recordings of the healthy machine.
///
/// recordings: path, paths, Recording or list of Recording. solver is "sindy-nn" or "stlsq"; dimension, degree and harmonics
/// are n_MD, n_D and n_F of the library; alignment is "half", "forward" or "causal"; null the number of surrogates
/// without dynamics that are fitted beside. progress: True for a bar of tqdm, or a callable of (done, text), called about 20
/// times a second, done from 0 to 1.
/// Raises InputError with the command's text; KeyboardInterrupt ends the fit.
#[pyfunction]
#[pyo3(signature = (recordings, *, channel=None, solver="sindy-nn", dimension=None, degree=None, harmonics=None,
    hidden=None, alignment=None, max_steps=None, trainings=None, null=None, false_alarms_per_day=None, seed=0,
    progress=None))]
#[allow(clippy::too_many_arguments)]
pub fn fit(
    py: Python<'_>,
    recordings: Recordings,
    channel: Option<&str>,
    solver: &str,
    dimension: Option<usize>,
    degree: Option<usize>,
    harmonics: Option<usize>,
    hidden: Option<Vec<usize>>,
    alignment: Option<&str>,
    max_steps: Option<usize>,
    trainings: Option<usize>,
    null: Option<usize>,
    false_alarms_per_day: Option<f64>,
    seed: u64,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Model> {
    let mut config = FitConfig { seed, ..FitConfig::default() };
    config.spec.dimension = dimension.unwrap_or(config.spec.dimension);
    config.spec.alignment = match alignment {
        None | Some("half") => Alignment::Half,
        Some("forward") => Alignment::Forward,
        Some("causal") => Alignment::Causal,
        Some(found) => return Err(input(format!("alignment: found `{found}`, expected half, forward or causal"))),
    };
    config.degree = degree.unwrap_or(config.degree);
    config.harmonics = harmonics.unwrap_or(config.harmonics);
    config.trainings = trainings.unwrap_or(config.trainings);
    config.null_fits = null.unwrap_or(config.null_fits);
    config.false_alarms_per_day = false_alarms_per_day.unwrap_or(config.false_alarms_per_day);
    match (solver, &mut config.solver) {
        ("stlsq", solver) => *solver = Solver::Stlsq(StlsqConfig::default()),
        ("sindy-nn", Solver::SindyNn { hidden: widths, train }) => {
            *widths = hidden.unwrap_or_else(|| widths.clone());
            train.max_steps = max_steps.or(train.max_steps);
        }
        (found, _) => return Err(input(format!("solver: found `{found}`, expected sindy-nn or stlsq"))),
    }
    let read = Input::from_recordings(&recordings.read(py)?, channel).map_err(input)?;
    let series = read.continuous(read.series.len());
    config.interval_s = read.interval_s;
    let fitted = run(py, progress, |progress| {
        let told = |stage: Stage| progress.report(Some(stage.done), &stage.name);
        ballrace::fit(&series, read.sample_rate_hz, &config, &told)
    })?;
    let mut fitted = fitted.map_err(input)?;
    fitted.report.training.channel = Some(read.channel.clone());
    let page = report::fit::document(&fitted, &read).map_err(other)?.html();
    Ok(Model { model: fitted.model, report: Some(fitted.report), page: Some(page) })
}

/// Runs the device's own code over recordings.
///
/// Returns a dict: `events` (status changes and faults), `recordings` (vibration indicators of each), `blocks` (each block of
/// the monitor) and `summary`, with the keys of the command's JSON lines, and `page`, the report, which the dict shows in a
/// notebook.
#[pyfunction]
#[pyo3(signature = (model, recordings, *, channel=None))]
pub fn monitor<'py>(
    model: &Model,
    recordings: Recordings,
    channel: Option<&str>,
    py: Python<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let of_model = model.report.as_ref().and_then(|report| report.training.channel.clone());
    let read = Input::from_recordings(&recordings.read(py)?, channel.or(of_model.as_deref())).map_err(input)?;
    let (done, indicators) = run(py, None, |_| {
        (replay(&model.model, &read, &Options::default(), &mut |_, _| ()), Indicators::of_each(&read))
    })?;
    let done = done.map_err(input)?;
    let vibration = Vibration { indicators: &indicators, class: None };
    let ewma = |n: usize| done.blocks.iter().rev().find(|b| b.recording <= n).map(|b| b.statistics.ewma);
    let each: Vec<_> = (0..indicators.len()).map(|n| vibration.event(&read, n, ewma(n))).collect();
    let block = |b: &ballrace::model::replay::Block| serde_json::json!({ "recording_index": b.recording, "status": b.status, "statistics": b.statistics });
    let out = PyDict::new(py);
    out.set_item("events", python(py, &done.events)?)?;
    out.set_item("recordings", python(py, &each)?)?;
    out.set_item("blocks", python(py, &done.blocks.iter().map(block).collect::<Vec<_>>())?)?;
    out.set_item("summary", python(py, &done.summary)?)?;
    let page = report::monitor::document(&model.model, &read, &done, &vibration).map_err(other)?.html();
    with_page(&out, page)
}
