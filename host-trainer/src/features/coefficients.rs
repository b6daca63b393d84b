//! Coefficients of a fit to one recording, theory (120).

use ballrace_core::library::Library;
use ballrace_core::states::{Alignment, Estimator, Orders, StateSpec};

use super::settings::FeatureSettings;
use crate::model::states::{Scales, rows};
use crate::model::stlsq::{RFactor, StlsqConfig, fit};

const SETTINGS: FeatureSettings = FeatureSettings::DEFAULT;

/// States and targets of both libraries: the paper's.
const SPEC: StateSpec = StateSpec {
    dimension: SETTINGS.dimension,
    orders: Orders::Even,
    alignment: Alignment::Half,
    estimator: Estimator::Differences,
};

/// Coefficients Ξ of a polynomial library of degree n_D by least squares on standardised states and targets, equation after
/// equation, without the constants: these follow from the others, as targets have no mean. They do not change with the
/// recording's scale or offset. `None` for a recording that is too short.
///
/// # Panics
/// If the degree is beyond the library's.
pub fn coefficients(samples: &[f32], degree: usize) -> Option<Vec<f64>> {
    let library = Library::new(SPEC.dimension, degree, 0).expect("a degree that the library has");
    let mut rows = rows(samples, SPEC);
    if rows.len() < SETTINGS.rows_per_term * library.len() {
        return None;
    }
    Scales::from_rows(std::slice::from_ref(&rows)).apply(&mut rows);
    // Without a validation part nothing is thresholded.
    let equations = fit(&RFactor::from_samples(library, &rows), &[], &StlsqConfig::default());
    Some(equations.into_iter().flat_map(|equation| equation.coefficients.into_iter().skip(1)).collect())
}
