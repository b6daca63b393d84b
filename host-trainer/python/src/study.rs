//! Studies: grids of fits.

use std::path::{Path, PathBuf};

use ballrace::sweep::config::Config;
use ballrace::sweep::{self as lib, table};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;

use crate::error::{input, other, python};
use crate::recording::Recordings;
use crate::run::run;

/// Name that errors give to the keywords, in place of a file sweep.toml.
const HERE: &str = "sweep";

/// Fits a grid of models: all combinations of the keywords, each a value or a list.
///
/// Keywords are the keys of a sweep.toml: the sizes `nd` (degree), `nmd` (dimension), `nf` (harmonics) or `model`, a list of
/// dicts of the three; `powers`, `solver` ("sindy-nn", "stlsq"), `alignment`, `estimator`, `filter` ("none" or a wavelet),
/// `lambda` (triples; as `**{"lambda": ...}`), `sparsity`, `null_kind`, `seed`; and `channel`, `range` (first recording and one
/// past the last), `one_by_one` (whether each recording is a fit of its own, by default True), `null` (surrogate fits),
/// `causal`, `epochs`. Docs: formats, sweep.toml.
///
/// Returns a list of rows, dicts with the columns of the command's sweep.csv, for pandas.DataFrame: R² in sample, validation,
/// held out, causal and on surrogates; `error` says why a fit failed. out: folder whose rows.jsonl keeps what is done, so that
/// the same call goes on after a stop. progress: True for a bar of tqdm, or a callable of (done, text). Raises InputError for a
/// key or value that there is not.
#[pyfunction]
#[pyo3(signature = (recordings, *, out=None, progress=None, **grid))]
pub fn sweep<'py>(
    recordings: Recordings,
    out: Option<PathBuf>,
    progress: Option<Bound<'py, PyAny>>,
    grid: Option<Bound<'py, PyDict>>,
    py: Python<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let mut keys = match grid {
        Some(grid) => pythonize::depythonize(&grid).map_err(|error| input(format!("{HERE}: {error}")))?,
        None => serde_json::Map::new(),
    };
    // The recordings are given as they are; the key is required.
    let given = keys.insert("recordings".into(), Value::from(vec![HERE]));
    if given.is_some() {
        return Err(input(format!("{HERE}: found the key recordings, expected them as the first argument only")));
    }
    let config: Config = serde_json::from_value(keys.into()).map_err(|error| input(format!("{HERE}: {error}")))?;
    config.check(Path::new(HERE)).map_err(input)?;
    let recordings = recordings.read(py)?;
    let material = config.material(&recordings).map_err(input)?;
    let mut names: Vec<&str> = material.series.iter().map(|series| series.name.as_str()).collect();
    names.sort_unstable();
    if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(input(format!("recordings: found two of the name {}, expected different ones", pair[0])));
    }
    let jobs = config.jobs(&material);
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
