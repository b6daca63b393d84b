//! Rigs: simulation, calibration, and what a rig leaves out.

use std::path::{Path, PathBuf};

use ballrace::diagnose::result::DiagnosisResult;
use ballrace::diagnose::write::Document;
use ballrace::identify::calibrate::bearing::Options;
use ballrace::identify::force_balance::calibrate_sdof;
use ballrace::report;
use ballrace::rig as lib;
use ballrace::rig::{Machine, OperatingCondition, Start, batch};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{input, other, python};
use crate::look::{Page, escaped, with_page};
use crate::recording::{Recording, Recordings};
use crate::run::run;

/// Simulated machine: a bearing of five degrees of freedom, or one degree of freedom.
#[pyclass(module = "ballrace", frozen)]
pub struct Rig {
    rig: lib::Rig,
}

#[pymethods]
impl Rig {
    /// Rig of the text of a rig.toml.
    #[new]
    fn new(toml: &str) -> PyResult<Self> {
        Ok(Self { rig: lib::Rig::parse(toml, Path::new("rig.toml")).map_err(input)? })
    }

    /// Rig of a file rig.toml.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        Ok(Self { rig: lib::Rig::read(&path).map_err(input)? })
    }

    /// Text of the rig's rig.toml, effects included.
    fn to_toml(&self) -> String {
        self.rig.to_toml()
    }

    /// Simulates a bearing rig at shaft_hz under load_n newtons; a Recording with channels `ax`, `ay` in m/s² and `tacho`.
    #[pyo3(signature = (shaft_hz, load_n, *, sample_rate_hz=25600.0, seconds=1.0, seed=0))]
    fn simulate(
        &self,
        shaft_hz: f64,
        load_n: f64,
        sample_rate_hz: f64,
        seconds: f64,
        seed: u64,
        py: Python<'_>,
    ) -> PyResult<Recording> {
        let samples = (seconds * sample_rate_hz).round().clamp(0.0, u32::MAX.into()) as usize;
        let condition = OperatingCondition { shaft_hz, load_n, sample_rate_hz, samples };
        let made = run(py, None, |_| lib::simulate(&self.rig, &condition, &Start::seeded(seed)))?.map_err(input)?;
        Ok(Recording::from_library(py, made))
    }

    /// Simulates the rig as each of the recordings was made: its speed, load and length; of one degree of freedom, its input.
    #[pyo3(signature = (recordings, *, seed=0))]
    fn predict(&self, recordings: Recordings, seed: u64, py: Python<'_>) -> PyResult<Vec<Recording>> {
        let recordings = recordings.read(py)?;
        let made = run(py, None, |_| batch::recordings(&self.rig, &recordings, seed))?.map_err(input)?;
        Ok(made.into_iter().map(|recording| Recording::from_library(py, recording)).collect())
    }

    fn _repr_html_(&self) -> String {
        format!("<pre>{}</pre>", escaped(&self.to_toml()))
    }

    fn __repr__(&self) -> String {
        let kind = if matches!(self.rig.model, Machine::Bearing(_)) { "bearing-5dof" } else { "sdof" };
        let effects: Vec<&str> = self.rig.effects.iter().map(|e| e.kind.definition().name).collect();
        let effects = if effects.is_empty() { "none".to_owned() } else { effects.join(", ") };
        format!("<Rig {kind}, effects: {effects}>")
    }
}

/// Fits the unknown parameters of a rig to recordings of the healthy machine.
///
/// Returns the calibrated Rig and a dict of the estimates with their 95 % intervals and of `page`, the report, which the dict
/// shows in a notebook. progress: True for a bar of tqdm, or a callable of (None, text), which is told of each step.
#[pyfunction]
#[pyo3(signature = (rig, recordings, *, seed=0, progress=None))]
pub fn calibrate<'py>(
    rig: &Rig,
    recordings: Recordings,
    seed: u64,
    progress: Option<Bound<'py, PyAny>>,
    py: Python<'py>,
) -> PyResult<(Rig, Bound<'py, PyAny>)> {
    let recordings = recordings.read(py)?;
    let (rig, about, page) = if matches!(rig.rig.model, Machine::Sdof(_)) {
        let (done, page) = run(py, progress, |progress| {
            progress.report(None, "fitting force balance and simulation");
            let done = calibrate_sdof(&rig.rig, &recordings).map_err(input)?;
            let page = report::calibrate_sdof::document(&done, &recordings).map_err(other)?.html();
            Ok::<_, PyErr>((done, page))
        })??;
        (done.rig.clone(), python(py, &done)?, page)
    } else {
        let options = Options { seed, ..Options::default() };
        let (done, page) = run(py, progress, |progress| {
            let told = |what: &str| progress.report(None, what);
            let done = ballrace::calibrate(&rig.rig, &recordings, &options, &told).map_err(input)?;
            progress.report(None, "drawing the report");
            let page = report::calibrate::document(&rig.rig, &done, &recordings, seed).map_err(other)?.html();
            Ok::<_, PyErr>((done, page))
        })??;
        (done.rig.clone(), python(py, &done)?, page)
    };
    let about = with_page(about.cast::<PyDict>()?, page)?;
    Ok((Rig { rig }, about))
}

/// What a rig leaves out: causes with probability, parameters and intervals, and the corrected rig.
#[pyclass(module = "ballrace", frozen)]
pub struct Diagnosis {
    outcome: DiagnosisResult,
    page: String,
}

#[pymethods]
impl Diagnosis {
    /// "mismatch", "no-mismatch" or "unexplained".
    #[getter]
    fn verdict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.to_dict(py)?.get_item("verdict")
    }

    /// The verdict in a sentence with units.
    #[getter]
    fn sentence(&self) -> String {
        report::diagnosis::verdict(&self.outcome).1
    }

    /// Causes, the most probable first: dicts of name, probability, parameters, interval95, evidence, equation.
    #[getter]
    fn causes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.to_dict(py)?.get_item("causes")
    }

    /// The document diagnosis.json as a dict.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python(py, &Document::from_result(&self.outcome))
    }

    /// Rig with the causes in it.
    #[getter]
    fn corrected_rig(&self) -> Rig {
        Rig { rig: self.outcome.rig.clone() }
    }

    /// The report as a page.
    #[getter]
    fn page(&self) -> Page {
        Page::new(self.page.clone())
    }

    fn __repr__(&self) -> String {
        format!("<Diagnosis: {}>", self.sentence())
    }

    fn _repr_html_(&self) -> String {
        Page::frame(&self.page)
    }
}

/// Finds what a rig lacks: fits the causes of the vocabulary to what the rig leaves and selects among them on recordings that
/// took no part in the fit.
///
/// baseline: recordings of the healthy machine. progress: True for a bar of tqdm, or a callable of (None, text), which is
/// told of each step. KeyboardInterrupt ends the diagnosis.
#[pyfunction]
#[pyo3(signature = (rig, recordings, *, baseline=None, seed=0, progress=None))]
pub fn diagnose(
    rig: &Rig,
    recordings: Recordings,
    baseline: Option<Recordings>,
    seed: u64,
    progress: Option<Bound<'_, PyAny>>,
    py: Python<'_>,
) -> PyResult<Diagnosis> {
    let recordings = recordings.read(py)?;
    let baseline = baseline.map(|baseline| baseline.read(py)).transpose()?;
    let task = ballrace::Task { rig: &rig.rig, baseline: baseline.as_deref(), recordings: &recordings, seed };
    let (outcome, page) = run(py, progress, |progress| {
        let outcome = ballrace::diagnose(&task, &|what: &str| progress.report(None, what)).map_err(input)?;
        progress.report(None, "drawing the report");
        let page = report::diagnosis::document(&task, &outcome).map_err(other)?.html();
        Ok::<_, PyErr>((outcome, page))
    })??;
    Ok(Diagnosis { outcome, page })
}
