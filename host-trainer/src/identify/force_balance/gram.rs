//! Inner products of whitened columns, block by block: every hypothesis is then a small linear system, and every
//! held-out error a difference of sums.

use faer::Mat;
use rayon::prelude::*;

use super::settings::BalanceSettings;

const SETTINGS: BalanceSettings = BalanceSettings::DEFAULT;

/// Inner products of all columns in blocks of consecutive rows, each block in a fold.
pub struct Gram {
    blocks: Vec<Mat<f64>>,
    total: Mat<f64>,
    /// Products of all blocks but those of each fold.
    without: Vec<Mat<f64>>,
    scales: Vec<f64>,
}

/// Rows that a model is fitted to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// All.
    All,
    /// All but those of a fold.
    Without(usize),
}

impl Gram {
    /// Inner products of columns of equal length, in blocks that end at the rows `ends`; `fold` holds the fold of each block,
    /// `folds` and beyond in none.
    pub fn new(columns: &[Vec<f64>], ends: &[usize], fold: &[usize], folds: usize) -> Self {
        let p = columns.len();
        let scales: Vec<f64> = columns.iter().map(|c| super::regression::norm(c)).collect();
        let safe = |j: usize| if scales[j] > 0.0 { 1.0 / scales[j] } else { 0.0 };
        let starts = std::iter::once(0).chain(ends.iter().copied());
        let blocks: Vec<Mat<f64>> = starts
            .zip(ends)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|(start, end)| {
                let x = Mat::from_fn(end - start, p, |i, j| columns[j][start + i] * safe(j));
                x.transpose() * &x
            })
            .collect();
        let mut total = Mat::zeros(p, p);
        blocks.iter().for_each(|b| total += b);
        let without = (0..folds).map(|number| {
            let mut rest = total.clone();
            blocks.iter().zip(fold).filter(|(_, f)| **f == number).for_each(|(b, _)| rest -= b);
            rest
        });
        let without = without.collect();
        Self { blocks, total, without, scales }
    }

    fn matrix(&self, rows: Rows) -> &Mat<f64> {
        match rows {
            Rows::All => &self.total,
            Rows::Without(fold) => &self.without[fold],
        }
    }

    /// Least squares of column 0 on the columns `active`, with some coefficients `fixed`. `None` if they are dependent.
    pub fn solve(&self, active: &[usize], fixed: &[(usize, f64)], rows: Rows, ridge: f64) -> Option<Vec<f64>> {
        let gram = self.matrix(rows);
        let mut normal: Vec<Vec<f64>> =
            active.iter().enumerate().map(|(n, i)| active[..=n].iter().map(|j| gram[(*i, *j)]).collect()).collect();
        let weight = |(j, value): &(usize, f64)| value * self.scales[*j] / self.scales[0];
        let right: Vec<f64> = active
            .iter()
            .map(|i| gram[(*i, 0)] - fixed.iter().map(|f| weight(f) * gram[(*i, f.0)]).sum::<f64>())
            .collect();
        let scaled = cholesky_solve(&mut normal, &right, ridge)?;
        Some(scaled.iter().zip(active).map(|(b, j)| b * self.scales[0] / self.scales[*j]).collect())
    }

    /// Residual sum of squares of given coefficients in a block.
    pub fn left(&self, active: &[usize], values: &[f64], block: usize) -> f64 {
        self.form(&self.blocks[block], active, values)
    }

    /// Residual sum of squares of given coefficients in some rows.
    pub fn left_in(&self, active: &[usize], values: &[f64], rows: Rows) -> f64 {
        self.form(self.matrix(rows), active, values)
    }

    fn form(&self, gram: &Mat<f64>, active: &[usize], values: &[f64]) -> f64 {
        let weight: Vec<f64> = active.iter().zip(values).map(|(j, b)| b * self.scales[*j] / self.scales[0]).collect();
        let mut sum = gram[(0, 0)];
        for (i, a) in active.iter().zip(&weight) {
            sum -= 2.0 * a * gram[(*i, 0)];
            sum += active.iter().zip(&weight).map(|(j, b)| a * b * gram[(*i, *j)]).sum::<f64>();
        }
        sum.max(0.0) * self.scales[0] * self.scales[0]
    }

    /// Slope of a block's residual along each active column, for covariances that allow for misfit.
    pub fn score(&self, active: &[usize], values: &[f64], block: usize) -> Vec<f64> {
        let gram = &self.blocks[block];
        let of = |i: &usize| {
            let fitted: f64 = active.iter().zip(values).map(|(j, b)| b * self.scales[*j] * gram[(*i, *j)]).sum();
            self.scales[*i] * (self.scales[0] * gram[(*i, 0)] - fitted)
        };
        active.iter().map(of).collect()
    }

    /// Inner product of two columns over all rows.
    pub fn product(&self, i: usize, j: usize) -> f64 {
        self.total[(i, j)] * self.scales[i] * self.scales[j]
    }
}

/// Solves a symmetric system by Cholesky's factorisation after scaling its diagonal to 1; the lower triangle is given,
/// and overwritten. `damping` is added to the scaled diagonal (Levenberg and Marquardt). `None` where the system is
/// singular.
pub fn cholesky_solve(normal: &mut [Vec<f64>], right: &[f64], damping: f64) -> Option<Vec<f64>> {
    let n = right.len();
    let scales: Vec<f64> = (0..n).map(|i| normal[i][i].sqrt()).collect();
    if scales.iter().any(|s| !(s.is_finite() && *s > 0.0)) {
        return None;
    }
    for i in 0..n {
        for j in 0..=i {
            let mut sum = normal[i][j] / (scales[i] * scales[j]) + if i == j { damping } else { 0.0 };
            sum -= (0..j).map(|k| normal[i][k] * normal[j][k]).sum::<f64>();
            normal[i][j] = if i == j {
                if sum.is_nan() || sum < SETTINGS.min_pivot {
                    return None;
                }
                sum.sqrt()
            } else {
                sum / normal[j][j]
            };
        }
    }
    let mut x: Vec<f64> = right.iter().zip(&scales).map(|(r, s)| r / s).collect();
    for i in 0..n {
        x[i] = (x[i] - (0..i).map(|k| normal[i][k] * x[k]).sum::<f64>()) / normal[i][i];
    }
    for i in (0..n).rev() {
        x[i] = (x[i] - (i + 1..n).map(|k| normal[k][i] * x[k]).sum::<f64>()) / normal[i][i];
    }
    Some(x.iter().zip(&scales).map(|(x, s)| x / s).collect())
}
