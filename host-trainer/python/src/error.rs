//! Exceptions: the texts of the commands.

use std::fmt::Display;

use clap::ValueEnum;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;

create_exception!(ballrace, Error, PyException, "Failure of ballrace that is no wrong input.");
create_exception!(ballrace, InputError, PyValueError, "Wrong input: where, what was found, and what was expected.");

/// Wrong input, with the text of an error.
pub fn input(error: impl Display) -> PyErr {
    InputError::new_err(error.to_string())
}

/// Any other failure, with the text of an error.
pub fn other(error: impl Display) -> PyErr {
    Error::new_err(error.to_string())
}

/// Value of a command's option, by its name there.
pub fn choice<T: ValueEnum>(name: &str, text: &str) -> PyResult<T> {
    T::from_str(text, false).map_err(|_| {
        let names =
            T::value_variants().iter().filter_map(|value| Some(value.to_possible_value()?.get_name().to_owned()));
        input(format!("{name}: found `{text}`, expected {}", names.collect::<Vec<_>>().join(", ")))
    })
}

/// Python value of what serialises.
pub fn python<'py>(py: Python<'py>, value: &impl serde::Serialize) -> PyResult<Bound<'py, PyAny>> {
    // Through JSON, so that numbers that are not finite are None as in the commands' documents.
    let value = serde_json::to_value(value).map_err(other)?;
    pythonize::pythonize(py, &value).map_err(other)
}
