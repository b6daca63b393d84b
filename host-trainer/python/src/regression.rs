//! Sparse regression of targets on columns of any functions.

use ballrace::model::stlsq::{RFactor, StlsqConfig, fit};
use faer::MatRef;
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::error::input;

/// Sequentially thresholded least squares: coefficients (terms, targets) of theta (rows, terms) for targets (rows, targets).
///
/// A term whose share of its target's variance is below `threshold` is dropped; ridge is the penalty on coefficients of
/// columns scaled by their RMS.
#[pyfunction]
#[pyo3(signature = (theta, targets, *, threshold=1e-6, ridge=0.0, rounds=20))]
pub fn stlsq<'py>(
    theta: PyReadonlyArray2<'py, f64>,
    targets: PyReadonlyArray2<'py, f64>,
    threshold: f64,
    ridge: f64,
    rounds: usize,
    py: Python<'py>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    if theta.shape()[0] != targets.shape()[0] || theta.shape()[0] == 0 {
        let (found, expected) = (targets.shape()[0], theta.shape()[0]);
        return Err(input(format!("targets: found {found} rows, expected the {expected} of theta, above 0")));
    }
    if !(threshold >= 0.0 && ridge >= 0.0) {
        return Err(input(format!("found threshold {threshold} and ridge {ridge}, expected numbers not below 0")));
    }
    let (theta, targets) = (theta.as_array(), targets.as_array());
    let config = StlsqConfig { threshold: Some(threshold), ridge, rounds };
    let equations = py.detach(|| {
        let view = |array: numpy::ndarray::ArrayView2<'_, f64>| {
            let (rows, columns) = array.dim();
            faer::Mat::from_fn(rows, columns, |i, j| array[[i, j]])
        };
        let (theta, targets) = (view(theta), view(targets));
        let (theta, targets): (MatRef<'_, f64>, MatRef<'_, f64>) = (theta.as_ref(), targets.as_ref());
        fit(&RFactor::from_matrices(theta, targets), &[], &config)
    });
    let (terms, count) = (theta.ncols(), equations.len());
    let flat: Vec<f64> = (0..terms).flat_map(|t| equations.iter().map(move |e| e.coefficients[t])).collect();
    flat.into_pyarray(py).reshape([terms, count])
}
