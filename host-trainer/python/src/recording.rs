//! Recordings: numpy arrays with their sample rate and operating condition.

use std::collections::BTreeMap;
use std::path::PathBuf;

use ballrace::recording::{self as lib, LoadOptions, Unit};
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::input;

/// Recording of a machine: channels of equal length, accelerations in m/s².
#[pyclass(module = "ballrace", frozen)]
pub struct Recording {
    /// All but the samples.
    about: lib::Recording,
    /// Samples of each channel.
    channels: Vec<(String, Py<PyArray1<f64>>)>,
}

#[pymethods]
impl Recording {
    /// Recording of arrays.
    ///
    /// channels: dict of names (`ax`, `ay`, `tacho`, `u`, `q`, ...) to float64 arrays of equal length; they are kept, not
    /// copied. Accelerations in m/s². sample_rate_hz in Hz, shaft_hz in revolutions per second, load_n in N.
    #[new]
    #[pyo3(signature = (channels, sample_rate_hz, *, name="recording", shaft_hz=None, load_n=None))]
    fn new(
        channels: BTreeMap<String, Py<PyArray1<f64>>>,
        sample_rate_hz: f64,
        name: &str,
        shaft_hz: Option<f64>,
        load_n: Option<f64>,
        py: Python<'_>,
    ) -> PyResult<Self> {
        let lengths: Vec<usize> = channels.values().map(|samples| samples.bind(py).len().unwrap_or(0)).collect();
        let equal = lengths.windows(2).all(|pair| pair[0] == pair[1]);
        if lengths.first().is_none_or(|length| *length == 0) || !equal {
            return Err(input(format!("channels: found lengths {lengths:?}, expected arrays of one length above 0")));
        }
        if !(sample_rate_hz.is_finite() && sample_rate_hz > 0.0) {
            return Err(input(format!("sample_rate_hz: found {sample_rate_hz}, expected a positive number of Hz")));
        }
        for (channel, samples) in &channels {
            let samples = samples.bind(py).readonly();
            if let Some(at) = samples.as_array().iter().position(|v| !v.is_finite()) {
                return Err(input(format!(
                    "channels[{channel:?}][{at}]: found a number that is not finite, expected one"
                )));
            }
        }
        // With an extension: the name of a recording is its file's without one.
        let source = lib::Source { path: PathBuf::from(format!("{name}.csv")), variable: None };
        let about = lib::Recording { source, sample_rate_hz, shaft_hz, load_n, ..lib::Recording::default() };
        Ok(Self { about, channels: channels.into_iter().collect() })
    }

    /// Name of the recording.
    #[getter]
    fn name(&self) -> String {
        self.about.name()
    }

    /// Sample rate, Hz.
    #[getter]
    fn sample_rate_hz(&self) -> f64 {
        self.about.sample_rate_hz
    }

    /// Shaft speed, revolutions per second, or None.
    #[getter]
    fn shaft_hz(&self) -> Option<f64> {
        self.about.shaft_hz
    }

    /// Radial load, N, or None.
    #[getter]
    fn load_n(&self) -> Option<f64> {
        self.about.load_n
    }

    /// Dict of the channels: name to float64 array (samples,), m/s² for accelerations. The arrays are the recording's own.
    #[getter]
    fn channels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        self.channels.iter().try_for_each(|(name, samples)| out.set_item(name, samples))?;
        Ok(out)
    }

    /// Array (samples,) of a channel.
    fn __getitem__(&self, channel: &str, py: Python<'_>) -> PyResult<Py<PyArray1<f64>>> {
        let found = self.channels.iter().find(|(name, _)| name == channel);
        found.map(|(_, samples)| samples.clone_ref(py)).ok_or_else(|| {
            let names: Vec<&str> = self.channels.iter().map(|(name, _)| name.as_str()).collect();
            pyo3::exceptions::PyKeyError::new_err(format!("found channels {}, expected `{channel}`", names.join(", ")))
        })
    }

    /// Samples per channel.
    fn __len__(&self, py: Python<'_>) -> usize {
        self.channels.first().map_or(0, |(_, samples)| samples.bind(py).len().unwrap_or(0))
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let names: Vec<&str> = self.channels.iter().map(|(name, _)| name.as_str()).collect();
        let (name, rate) = (self.about.name(), self.about.sample_rate_hz);
        format!("<Recording {name}: {}, {} samples at {rate} Hz>", names.join(", "), self.__len__(py))
    }
}

impl Recording {
    /// Python's recording of the library's, whose samples it takes over.
    pub fn from_library(py: Python<'_>, mut recording: lib::Recording) -> Self {
        let channels = std::mem::take(&mut recording.channels);
        let array = |channel: lib::Channel| (channel.name, channel.samples.into_pyarray(py).unbind());
        Self { about: recording, channels: channels.into_iter().map(array).collect() }
    }

    /// The library's recording, with a copy of the samples.
    fn to_library(&self, py: Python<'_>) -> lib::Recording {
        let channel = |(name, samples): &(String, Py<PyArray1<f64>>)| {
            let samples: PyReadonlyArray1<'_, f64> = samples.bind(py).readonly();
            lib::Channel { name: name.clone(), location: None, samples: samples.as_array().to_vec() }
        };
        lib::Recording { channels: self.channels.iter().map(channel).collect(), ..self.about.clone() }
    }
}

/// Recordings as a caller has them: paths, one path, recordings or one recording.
#[derive(FromPyObject)]
pub enum Recordings {
    /// One recording.
    One(Py<Recording>),
    /// Several.
    Several(Vec<Py<Recording>>),
    /// File or folder.
    Path(PathBuf),
    /// Files and folders.
    Paths(Vec<PathBuf>),
}

impl Recordings {
    /// Path, if it is one.
    pub fn folder(&self) -> Option<PathBuf> {
        match self {
            Self::Path(path) => Some(path.clone()),
            _ => None,
        }
    }

    /// Files and folders, if they are paths.
    pub fn paths(&self) -> Option<&[PathBuf]> {
        match self {
            Self::Path(path) => Some(std::slice::from_ref(path)),
            Self::Paths(paths) => Some(paths),
            _ => None,
        }
    }

    /// The library's recordings.
    ///
    /// # Errors
    /// `InputError` of reading.
    pub fn read(&self, py: Python<'_>) -> PyResult<Vec<lib::Recording>> {
        let load = |paths: &[PathBuf]| {
            let loaded = py.detach(|| lib::load(paths, &LoadOptions::default())).map_err(input)?;
            Ok(loaded.recordings)
        };
        match self {
            Self::One(one) => Ok(vec![one.get().to_library(py)]),
            Self::Several(several) => Ok(several.iter().map(|one| one.get().to_library(py)).collect()),
            Self::Path(path) => load(std::slice::from_ref(path)),
            Self::Paths(paths) => load(paths),
        }
    }
}

/// Reads recordings from files and folders: FEMTO, CSV, MATLAB v5, NumPy, Parquet, or a folder with recordings.toml.
///
/// unit is "m/s^2" or "g", resample_hz an anti-aliased new rate in Hz. Returns a list of Recording. Raises InputError with
/// file, row, what was found and what was expected.
#[pyfunction]
#[pyo3(signature = (*paths, sample_rate_hz=None, unit=None, variable=None, channels=None, resample_hz=None))]
pub fn load(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    sample_rate_hz: Option<f64>,
    unit: Option<&str>,
    variable: Option<String>,
    channels: Option<Vec<String>>,
    resample_hz: Option<f64>,
) -> PyResult<Vec<Recording>> {
    let unit = unit
        .map(|text| Unit::parse(text).ok_or_else(|| input(format!("unit: found `{text}`, expected g or m/s^2"))))
        .transpose()?;
    let options = LoadOptions { sample_rate_hz, unit, variable, channels, resample_hz, ..LoadOptions::default() };
    let loaded = crate::run::run(py, None, move |_| lib::load(&paths, &options))?.map_err(input)?;
    Ok(loaded.recordings.into_iter().map(|recording| Recording::from_library(py, recording)).collect())
}
