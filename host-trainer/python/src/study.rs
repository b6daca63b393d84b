//! Studies: grids of fits.

use std::ffi::CString;
use std::path::{Path, PathBuf};

use ballrace::recording::{self, LoadOptions};
use ballrace::sweep::config::Config;
use ballrace::sweep::job::{Job, Material};
use ballrace::sweep::life::{self, Life};
use ballrace::sweep::preset::PresetName;
use ballrace::sweep::{self as lib, table};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Map, Value};

use crate::error::{choice, input, other, python};
use crate::recording::Recordings;
use crate::run::run;

/// Name that errors give to the keywords, in place of a file sweep.toml.
const HERE: &str = "sweep";
/// Channel and wavelet of a preset, as the command has them by default.
const CHANNEL: &str = "vertical";
const WAVELET: &str = "db4";

/// Fits a grid of models: all combinations of the keywords, each a value or a list.
///
/// Keywords are the keys of a sweep.toml: the sizes `nd` (degree), `nmd` (dimension), `nf` (harmonics) or `model`, a list of
/// dicts of the three; `powers`, `solver` ("sindy-nn", "stlsq"), `alignment`, `estimator`, `filter` ("none" or a wavelet),
/// `lambda_` (triples; the key `lambda`, which Python reserves), `sparsity`, `null_kind`, `seed`; and `channel`, `range` (first
/// recording and one past the last), `one_by_one` (whether each recording is a fit of its own, by default True), `null`
/// (surrogate fits), `causal`, `epochs`. Docs: formats, sweep.toml.
///
/// preset: grid of a table or figure of the paper, "table3", "table4", "table5", "fig10", "fig11" or "all", as --preset of the
/// command, with its rows, not its page. Recordings are then the path of a run-to-failure folder, or several, of which `count`
/// recordings of each aging phase are taken (by default 8 for table5, 4 for table4, else 1); beside it only `channel` (by
/// default "vertical") is a keyword. A folder that shows no aging is left out with a warning.
///
/// Returns a list of rows, dicts with the columns of the command's sweep.csv, for pandas.DataFrame: R² in sample, validation,
/// held out, causal and on surrogates; `error` says why a fit failed. out: folder whose rows.jsonl keeps what is done, so that
/// the same call goes on after a stop. progress: True for a bar of tqdm, or a callable of (done, text). Raises InputError for a
/// key or value that there is not.
#[pyfunction]
#[pyo3(signature = (recordings, *, preset=None, count=None, lambda_=None, out=None, progress=None, **grid))]
#[allow(clippy::too_many_arguments)]
pub fn sweep<'py>(
    recordings: Recordings,
    preset: Option<&str>,
    count: Option<usize>,
    lambda_: Option<Bound<'py, PyAny>>,
    out: Option<PathBuf>,
    progress: Option<Bound<'py, PyAny>>,
    grid: Option<Bound<'py, PyDict>>,
    py: Python<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let grid = grid.unwrap_or_else(|| PyDict::new(py));
    if let Some(lambda) = lambda_ {
        if grid.contains("lambda")? {
            return Err(input(format!("{HERE}: found both lambda_ and lambda, expected one")));
        }
        grid.set_item("lambda", lambda)?;
    }
    let keys: Map<String, Value> = pythonize::depythonize(&grid).map_err(|error| input(format!("{HERE}: {error}")))?;
    let (material, jobs) = match preset {
        Some(preset) => of_preset(py, &recordings, preset, count, keys)?,
        None if count.is_some() => return Err(input("count: found no preset, expected one with it")),
        None => of_keys(py, &recordings, keys)?,
    };
    let temporary = match out {
        Some(_) => None,
        None => Some(py.import("tempfile")?.getattr("TemporaryDirectory")?.call0()?),
    };
    let folder: PathBuf = match (&out, &temporary) {
        (None, Some(temporary)) => temporary.getattr("name")?.extract()?,
        _ => out.unwrap_or_default(),
    };
    let rows = run(py, progress, |progress| {
        let told = |done: usize, all: usize| {
            progress.report(Some(done as f64 / all.max(1) as f64), &format!("sweep, {done} of {all}"));
        };
        lib::run(&jobs, &material, &folder, &told)
    });
    if let Some(temporary) = temporary {
        temporary.call_method0("cleanup")?;
    }
    let rows = rows?.map_err(other)?;
    python(py, &rows.iter().map(table::values).collect::<Vec<_>>())
}

/// Grid of the keys of a sweep.toml.
fn of_keys(py: Python<'_>, recordings: &Recordings, mut keys: Map<String, Value>) -> PyResult<(Material, Vec<Job>)> {
    // The recordings are given as they are; the key is required.
    let given = keys.insert("recordings".into(), Value::from(vec![HERE]));
    if given.is_some() {
        return Err(input(format!("{HERE}: found the key recordings, expected them as the first argument only")));
    }
    let config: Config = serde_json::from_value(keys.into()).map_err(|error| input(format!("{HERE}: {error}")))?;
    config.check(Path::new(HERE)).map_err(input)?;
    let material = config.material(&recordings.read(py)?).map_err(input)?;
    let mut names: Vec<&str> = material.series.iter().map(|series| series.name.as_str()).collect();
    names.sort_unstable();
    if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(input(format!("recordings: found two of the name {}, expected different ones", pair[0])));
    }
    let jobs = config.jobs(&material);
    Ok((material, jobs))
}

/// Grid of a preset on run-to-failure folders.
fn of_preset(
    py: Python<'_>,
    recordings: &Recordings,
    preset: &str,
    count: Option<usize>,
    mut keys: Map<String, Value>,
) -> PyResult<(Material, Vec<Job>)> {
    let presets = choice::<PresetName>("preset", preset)?.presets();
    if count == Some(0) {
        return Err(input("count: found 0, expected at least 1"));
    }
    let channel = keys.remove("channel").unwrap_or_else(|| CHANNEL.into());
    let channel = channel.as_str().ok_or_else(|| input(format!("channel: found {channel}, expected a name")))?;
    if let Some(key) = keys.keys().next() {
        return Err(input(format!("{HERE}: found the keyword {key} beside a preset, expected channel or none")));
    }
    let folders = recordings.paths().ok_or_else(|| {
        input("recordings: found recordings beside a preset, expected the paths of run-to-failure folders")
    })?;
    let mut lives: Vec<Life> = Vec::new();
    for folder in folders {
        let name = folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy();
        if lives.iter().any(|life| life.bearing.name == name) {
            return Err(input(format!("recordings: found two folders {name}, expected different names")));
        }
        let options = LoadOptions { channels: Some(vec![channel.to_owned()]), ..LoadOptions::default() };
        let life = run(py, None, |_| {
            let loaded = recording::load(std::slice::from_ref(folder), &options).map_err(input)?;
            let wavelet = WAVELET.parse().map_err(other)?;
            Life::new(&name, &loaded.recordings, channel, wavelet).map_err(input)
        })??;
        match life {
            Some(life) => lives.push(life),
            None => {
                let left = format!("{}: channel {channel} shows no aging; left out", folder.display());
                let left = CString::new(left).map_err(other)?;
                PyErr::warn(py, &py.get_type::<PyUserWarning>(), &left, 1)?;
            }
        }
    }
    let (material, jobs) = life::grid(&lives, &presets, count).map_err(input)?;
    Ok((material, jobs.concat()))
}
