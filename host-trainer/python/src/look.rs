//! What to look at before any model, and pages in a notebook.

use std::path::PathBuf;

use ballrace::report;
use ballrace::rig::Machine;
use ballrace::rig::Rig;
use ballrace::signal::spectra::{Analysis, Wanted};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{input, other, python};
use crate::recording::Recordings;
use crate::run::run;

/// HTML page; shows itself in a notebook.
#[pyclass(module = "ballrace", frozen)]
pub struct Page {
    html: String,
}

#[pymethods]
impl Page {
    /// The whole page.
    #[getter]
    fn html(&self) -> &str {
        &self.html
    }

    /// Writes the page.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        std::fs::write(&path, &self.html).map_err(|error| other(format!("{}: {error}", path.display())))
    }

    fn _repr_html_(&self) -> String {
        Self::frame(&self.html)
    }
}

impl Page {
    /// Page of HTML.
    pub fn new(html: String) -> Self {
        Self { html }
    }

    /// Frame that shows a page within another.
    pub fn frame(html: &str) -> String {
        format!("<iframe style=\"width:100%;height:640px;border:0\" srcdoc=\"{}\"></iframe>", escaped(html))
    }
}

/// Result with its page as `page`: a dict that shows the page in a notebook.
pub fn with_page<'py>(result: &Bound<'py, PyDict>, html: String) -> PyResult<Bound<'py, PyAny>> {
    let shown = result.py().import("ballrace._report")?.getattr("Report")?.call1((result,))?;
    shown.set_item("page", Page::new(html))?;
    Ok(shown)
}

/// Text for an attribute or an element of HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('"', "&quot;").replace('<', "&lt;")
}

/// Spectrum, kurtogram, envelope and its lines of recordings.
///
/// rig: path of a rig.toml, for the bearing's geometry. Returns a dict of `recordings`, a document each, and
/// `page`, which the dict shows in a notebook.
#[pyfunction]
#[pyo3(signature = (recordings, *, shaft_hz=None, rig=None, band_hz=None, channel=None, seed=0))]
pub fn spectra<'py>(
    recordings: Recordings,
    shaft_hz: Option<f64>,
    rig: Option<PathBuf>,
    band_hz: Option<(f64, f64)>,
    channel: Option<String>,
    seed: u64,
    py: Python<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let geometry = match rig.map(|path| Rig::read(&path)).transpose().map_err(input)?.map(|rig| rig.model) {
        Some(Machine::Bearing(rig)) => Some(rig.bearing.geometry()),
        Some(Machine::Sdof(_)) => return Err(input("rig: found kind = \"sdof\", expected a rig with a bearing")),
        None => None,
    };
    let band_hz = band_hz.map(|(low, high)| low..high);
    let wanted = Wanted { geometry, shaft_hz, band_hz, channel, seed };
    let recordings = recordings.read(py)?;
    let analyses = run(py, None, |_| {
        recordings.iter().map(|recording| Analysis::analyse(recording, &wanted)).collect::<Result<Vec<_>, _>>()
    })?;
    let analyses = analyses.map_err(input)?;
    let out = PyDict::new(py);
    out.set_item("recordings", python(py, &analyses.iter().map(report::spectra::value).collect::<Vec<_>>())?)?;
    with_page(&out, report::spectra::document(&analyses).map_err(other)?.html())
}
