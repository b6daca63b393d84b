//! Triangular factor R of [Θ | Ẋ], theory (17).
//!
//! R holds every inner product of the library's and the targets' columns, at the accuracy of QR rather than of normal
//! equations: the solution for any subset of terms, its residual and its R² follow from it. Recordings are decomposed
//! in parallel, their factors stacked and decomposed again (tall-skinny QR), so that no more of a library is held than
//! a block of rows for each thread and one factor for each recording.

use ballrace_core::library::Library;
use faer::{Mat, MatRef};
use rayon::prelude::*;

use super::settings::RFactorSettings;
use crate::model::samples::Samples;

const BLOCK_ROWS: usize = RFactorSettings::DEFAULT.block_rows;

/// Factor R of [Θ | Ẋ] over a number of rows.
#[derive(Clone, Debug)]
pub struct RFactor {
    /// Upper triangular matrix, (terms + outputs) square.
    r: Mat<f64>,
    /// Number of rows decomposed.
    pub rows: usize,
    /// Number of terms p; the remaining columns are outputs.
    pub terms: usize,
    /// Sum over the rows of each output.
    sums: Vec<f64>,
}

impl RFactor {
    /// Factor of one recording's standardised rows.
    pub fn from_samples(library: Library, samples: &Samples<f32>) -> Self {
        let (terms, outputs) = (library.len(), samples.inputs);
        let columns = terms + outputs;
        let mut moments = Self { r: Mat::zeros(columns, columns), rows: 0, terms, sums: vec![0.0; outputs] };
        let mut theta = vec![0.0f32; terms];
        for first in (0..samples.len()).step_by(BLOCK_ROWS) {
            let count = BLOCK_ROWS.min(samples.len() - first);
            // The factor so far on top of the new rows.
            let top = if first == 0 { 0 } else { columns };
            let mut block = Mat::<f64>::zeros(top + count, columns);
            block.as_mut().subrows_mut(0, top).copy_from(moments.r.as_ref().subrows(0, top));
            for i in 0..count {
                let (x, dx) = samples.row(first + i);
                library.row(x, &mut theta);
                for (j, value) in theta.iter().chain(dx).enumerate() {
                    block[(top + i, j)] = f64::from(*value);
                }
                moments.sums.iter_mut().zip(dx).for_each(|(sum, v)| *sum += f64::from(*v));
            }
            moments.r = triangle(block.as_ref());
            moments.rows += count;
        }
        moments
    }

    /// Factor of each recording, in parallel.
    pub fn from_each(library: Library, recordings: &[Samples<f32>]) -> Vec<Self> {
        // A decomposition split over threads would round differently with their number.
        faer::set_global_parallelism(faer::Par::Seq);
        recordings.par_iter().map(|samples| Self::from_samples(library, samples)).collect()
    }

    /// Factor of all parts' rows together; `None` for no parts.
    pub fn merge(parts: &[&Self]) -> Option<Self> {
        let first = parts.first()?;
        let columns = first.r.ncols();
        let mut stacked = Mat::<f64>::zeros(columns * parts.len(), columns);
        for (n, part) in parts.iter().enumerate() {
            stacked.as_mut().subrows_mut(n * columns, columns).copy_from(&part.r);
        }
        let sums = (0..first.sums.len()).map(|o| parts.iter().map(|p| p.sums[o]).sum()).collect();
        Some(Self { r: triangle(stacked.as_ref()), rows: parts.iter().map(|p| p.rows).sum(), terms: first.terms, sums })
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.sums.len()
    }

    /// Root mean square of a term's column.
    pub fn term_rms(&self, term: usize) -> f64 {
        self.r.col(term).norm_l2() / (self.rows as f64).sqrt()
    }

    /// Mean product ⟨θ_a θ_b⟩ over the rows.
    pub fn term_product(&self, a: usize, b: usize) -> f64 {
        let (a, b) = (self.r.col(a), self.r.col(b));
        (0..self.terms).map(|i| a[i] * b[i]).sum::<f64>() / self.rows as f64
    }

    /// Columns of R for some terms, each divided by its RMS over these rows.
    pub fn scaled(&self, active: &[usize], scales: &[f64]) -> Mat<f64> {
        let root = (self.rows as f64).sqrt();
        Mat::from_fn(self.terms, active.len(), |i, j| self.r[(i, active[j])] / (scales[active[j]] * root))
    }

    /// Column of R for an output, in the normalisation of [`RFactor::scaled`].
    pub fn target(&self, output: usize) -> Mat<f64> {
        let root = (self.rows as f64).sqrt();
        Mat::from_fn(self.terms, 1, |i, _| self.r[(i, self.terms + output)] / root)
    }

    /// Mean squared error of ẋ_output = Σ ξ_j θ_j over these rows.
    pub fn mean_square_error(&self, output: usize, coefficients: &[f64]) -> f64 {
        let column = self.terms + output;
        let square: f64 = (0..=column)
            .map(|i| {
                let predicted: f64 = (i..self.terms).map(|j| self.r[(i, j)] * coefficients[j]).sum();
                (self.r[(i, column)] - predicted).powi(2)
            })
            .sum();
        square / self.rows as f64
    }

    /// Variance of an output over these rows.
    pub fn variance(&self, output: usize) -> f64 {
        let rows = self.rows as f64;
        let square = self.r.col(self.terms + output).squared_norm_l2() / rows;
        square - (self.sums[output] / rows).powi(2)
    }

    /// Score R² of ẋ_output = Σ ξ_j θ_j over these rows, theory (22).
    pub fn r_squared(&self, output: usize, coefficients: &[f64]) -> f64 {
        1.0 - self.mean_square_error(output, coefficients) / self.variance(output)
    }

    /// Condition number of the columns of some terms, scaled to unit RMS.
    pub fn condition_number(&self, active: &[usize]) -> f64 {
        let scales: Vec<f64> = (0..self.terms).map(|t| self.term_rms(t)).collect();
        let singular = self.scaled(active, &scales).singular_values();
        match singular.as_deref() {
            Ok([largest, .., smallest]) => largest / smallest,
            Ok(_) => 1.0,
            Err(_) => f64::INFINITY,
        }
    }
}

/// Square factor R of a QR decomposition.
fn triangle(a: MatRef<'_, f64>) -> Mat<f64> {
    let n = a.ncols();
    if a.nrows() < n {
        let mut padded = Mat::zeros(n, n);
        padded.as_mut().subrows_mut(0, a.nrows()).copy_from(a);
        return triangle(padded.as_ref());
    }
    let qr = a.qr();
    let r = qr.thin_R();
    Mat::from_fn(n, n, |i, j| if i <= j { r[(i, j)] } else { 0.0 })
}
