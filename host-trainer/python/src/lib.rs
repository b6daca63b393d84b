//! Python module `ballrace._ballrace`: the library's calls with numpy arrays, dictionaries and exceptions.
//!
//! | module | holds |
//! |---|---|
//! | `error` | exceptions |
//! | `run` | long work: the interpreter is free, progress, Ctrl-C |
//! | `recording` | `Recording`, `load` |
//! | `model` | `Model`, `fit`, `monitor` |
//! | `rig` | `Rig`, `calibrate`, `diagnose` |
//! | `look` | `spectra`, `Page` |
//! | `life` | `phases` |
//! | `study` | `sweep` |
//! | `regression` | `stlsq` |

use pyo3::prelude::*;

mod error;
mod life;
mod look;
mod model;
mod recording;
mod regression;
mod rig;
mod run;
mod study;

/// The native half of the package `ballrace`.
#[pymodule]
mod _ballrace {
    #[pymodule_export]
    use super::error::{Error, InputError};
    #[pymodule_export]
    use super::life::phases;
    #[pymodule_export]
    use super::look::{Page, spectra};
    #[pymodule_export]
    use super::model::{Model, fit, monitor};
    #[pymodule_export]
    use super::recording::{Recording, load};
    #[pymodule_export]
    use super::regression::stlsq;
    #[pymodule_export]
    use super::rig::{Diagnosis, Rig, calibrate, diagnose};
    #[pymodule_export]
    use super::study::sweep;

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
