//! Triangular factor R of [Θ | Ẋ], theory (17).
//!
//! R holds every inner product of the library's columns with each other and with the targets': the solution for any subset of terms, its
//! residual and its R² follow from it. It is the Cholesky factor of the Gram matrix where that is well conditioned, and
//! that of a QR decomposition elsewhere. Recordings are decomposed in parallel, their factors stacked and decomposed
//! again (tall-skinny QR), so that no more of a library is held than a block of rows for each thread and one factor for
//! each recording.

use ballrace_core::library::Library;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, MatRef, Par, Side};
use rayon::prelude::*;

use super::settings::RFactorSettings;
use crate::model::samples::Samples;

const SETTINGS: RFactorSettings = RFactorSettings::DEFAULT;

/// Factor R of [Θ | Ẋ] over a number of rows.
#[derive(Clone, Debug)]
pub struct RFactor {
    /// Upper trapezoidal matrix: terms + outputs columns, as many rows or, of a short recording, fewer.
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
        let mut sums = vec![0.0; outputs];
        for row in samples.dx.chunks_exact(outputs.max(1)) {
            sums.iter_mut().zip(row).for_each(|(sum, v)| *sum += f64::from(*v));
        }
        let by_gram = Self::enough(samples.len(), columns).then(|| cholesky(&gram(library, samples), terms)).flatten();
        let r = by_gram.unwrap_or_else(|| {
            // The factor so far on top of the new rows.
            let step = SETTINGS.block_rows.max(columns);
            (0..samples.len()).step_by(step).fold(Mat::zeros(0, columns), |r, first| {
                triangle(block(library, samples, first, step, r.as_ref()).as_ref())
            })
        });
        Self { r, rows: samples.len(), terms, sums }
    }

    /// Factor of rows of Θ (rows × terms) and Ẋ (rows × outputs), for functions that are not core's.
    pub fn from_matrices(theta: MatRef<'_, f64>, targets: MatRef<'_, f64>) -> Self {
        let (rows, terms, columns) = (theta.nrows(), theta.ncols(), theta.ncols() + targets.ncols());
        let part = |first: usize, count: usize| {
            let mut part = Mat::zeros(count, columns);
            part.as_mut().subcols_mut(0, terms).copy_from(theta.subrows(first, count));
            part.as_mut().subcols_mut(terms, columns - terms).copy_from(targets.subrows(first, count));
            part
        };
        let by_gram = || {
            let firsts: Vec<usize> = (0..rows).step_by(SETTINGS.block_rows * SETTINGS.blocks_per_thread).collect();
            let grams = firsts.into_par_iter().map(|begin| {
                let mut gram = Mat::zeros(columns, columns);
                let end = rows.min(begin + SETTINGS.block_rows * SETTINGS.blocks_per_thread);
                for first in (begin..end).step_by(SETTINGS.block_rows) {
                    add_gram(&mut gram, part(first, SETTINGS.block_rows.min(end - first)).as_ref());
                }
                gram
            });
            // Added up in order, so that every run rounds alike.
            let grams: Vec<Mat<f64>> = grams.collect();
            cholesky(&grams.iter().fold(Mat::zeros(columns, columns), |sum, gram| sum + gram), terms)
        };
        faer::set_global_parallelism(Par::Seq);
        let r = Self::enough(rows, columns).then(by_gram).flatten().unwrap_or_else(|| triangle(part(0, rows).as_ref()));
        let sums = (0..targets.ncols()).map(|output| targets.col(output).iter().sum()).collect();
        Self { r, rows, terms, sums }
    }

    /// Whether there are enough rows to try the Gram matrix.
    fn enough(rows: usize, columns: usize) -> bool {
        rows >= SETTINGS.min_rows_per_column * columns
    }

    /// Factor of each recording, in parallel.
    pub fn from_each(library: Library, recordings: &[Samples<f32>]) -> Vec<Self> {
        // A decomposition split over threads would round differently with their number.
        faer::set_global_parallelism(Par::Seq);
        recordings.par_iter().map(|samples| Self::from_samples(library, samples)).collect()
    }

    /// Factor of all parts' rows together; `None` for no parts.
    pub fn merge(parts: &[&Self]) -> Option<Self> {
        let first = parts.first()?;
        if parts.len() == 1 {
            return Some((*first).clone());
        }
        let mut stacked = Mat::<f64>::zeros(parts.iter().map(|part| part.r.nrows()).sum(), first.r.ncols());
        let mut at = 0;
        for part in parts {
            stacked.as_mut().subrows_mut(at, part.r.nrows()).copy_from(&part.r);
            at += part.r.nrows();
        }
        let sums = (0..first.sums.len()).map(|o| parts.iter().map(|p| p.sums[o]).sum()).collect();
        Some(Self { r: triangle(stacked.as_ref()), rows: parts.iter().map(|p| p.rows).sum(), terms: first.terms, sums })
    }

    /// Rows of R in which terms have entries.
    fn term_rows(&self) -> usize {
        self.terms.min(self.r.nrows())
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
        (0..self.term_rows()).map(|i| a[i] * b[i]).sum::<f64>() / self.rows as f64
    }

    /// Columns of R for some terms, each divided by its RMS over these rows.
    pub fn scaled(&self, active: &[usize], scales: &[f64]) -> Mat<f64> {
        let root = (self.rows as f64).sqrt();
        Mat::from_fn(self.term_rows(), active.len(), |i, j| self.r[(i, active[j])] / (scales[active[j]] * root))
    }

    /// Column of R for an output, in the normalisation of [`RFactor::scaled`].
    pub fn target(&self, output: usize) -> Mat<f64> {
        let root = (self.rows as f64).sqrt();
        Mat::from_fn(self.term_rows(), 1, |i, _| self.r[(i, self.terms + output)] / root)
    }

    /// Mean squared error of ẋ_output = Σ ξ_j θ_j over these rows.
    pub fn mean_square_error(&self, output: usize, coefficients: &[f64]) -> f64 {
        let column = self.terms + output;
        let square: f64 = (0..self.r.nrows().min(column + 1))
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

/// Up to `count` rows of [Θ | Ẋ] from row `first` on, below the rows of `top`.
fn block(library: Library, samples: &Samples<f32>, first: usize, count: usize, top: MatRef<'_, f64>) -> Mat<f64> {
    let count = count.min(samples.len() - first);
    let mut block = Mat::<f64>::zeros(top.nrows() + count, library.len() + samples.inputs);
    block.as_mut().subrows_mut(0, top.nrows()).copy_from(top);
    let mut theta = vec![0.0f32; library.len()];
    for i in 0..count {
        let (x, dx) = samples.row(first + i);
        library.row(x, &mut theta);
        for (j, value) in theta.iter().chain(dx).enumerate() {
            block[(top.nrows() + i, j)] = f64::from(*value);
        }
    }
    block
}

/// Gram matrix of [Θ | Ẋ], its lower triangle.
fn gram(library: Library, samples: &Samples<f32>) -> Mat<f64> {
    let columns = library.len() + samples.inputs;
    let mut gram = Mat::zeros(columns, columns);
    for first in (0..samples.len()).step_by(SETTINGS.block_rows) {
        let rows = block(library, samples, first, SETTINGS.block_rows, MatRef::from_row_major_slice(&[], 0, columns));
        add_gram(&mut gram, rows.as_ref());
    }
    gram
}

/// Adds the inner products of the columns to the lower triangle of `gram`.
pub(in crate::model) fn add_gram(gram: &mut Mat<f64>, rows: MatRef<'_, f64>) {
    use BlockStructure::{Rectangular, TriangularLower};
    let (left, right) = (rows.transpose(), rows);
    triangular::matmul(gram, TriangularLower, Accum::Add, left, Rectangular, right, Rectangular, 1.0, Par::Seq);
}

/// Upper triangular R whose columns have the inner products of a Gram matrix, given by its lower triangle, but for those of two
/// targets; `None` where a term's pivot is too small a share of its column's power. Targets may be as near to the terms' space
/// as they like: their pivots are their residuals.
fn cholesky(gram: &Mat<f64>, terms: usize) -> Option<Mat<f64>> {
    let factor = gram.as_ref().submatrix(0, 0, terms, terms).llt(Side::Lower).ok()?;
    let lower = factor.L();
    let is_sound = |j: usize| lower[(j, j)] * lower[(j, j)] > SETTINGS.min_pivot_share * gram[(j, j)];
    if !(0..terms).all(is_sound) {
        return None;
    }
    let columns = gram.ncols();
    let mut across = Mat::from_fn(terms, columns - terms, |i, o| gram[(terms + o, i)]);
    lower.solve_lower_triangular_in_place(across.as_mut());
    let residual = |o: usize| (gram[(terms + o, terms + o)] - across.col(o).squared_norm_l2()).max(0.0).sqrt();
    Some(Mat::from_fn(columns, columns, |i, j| match (i < terms, j < terms) {
        (true, true) if i <= j => lower[(j, i)],
        (true, false) => across[(i, j - terms)],
        (false, false) if i == j => residual(j - terms),
        _ => 0.0,
    }))
}

/// Upper trapezoidal factor R of a QR decomposition.
fn triangle(a: MatRef<'_, f64>) -> Mat<f64> {
    let qr = a.qr();
    let r = qr.thin_R();
    Mat::from_fn(a.nrows().min(a.ncols()), a.ncols(), |i, j| if i <= j { r[(i, j)] } else { 0.0 })
}
