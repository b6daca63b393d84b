//! Inner products of whitened columns, block by block: every hypothesis is then a small linear system, and every
//! held-out error a difference of sums.

use faer::Mat;

use super::filter::{Kernel, levinson};
use super::settings::BalanceSettings;
use super::states::States;

const SETTINGS: BalanceSettings = BalanceSettings::DEFAULT;

/// Whitening of the balance's disturbances, theory (69): sensor noise behind the filter's derivatives, and force noise.
/// A model of the disturbances is used rather than a fit's residual, whose lack of fit would be whitened away too.
#[derive(Clone, Debug)]
pub struct Whitening {
    filter: Vec<f64>,
    /// Variance of a whitened row that the sensor's noise alone accounts for, N².
    pub sensor_variance: f64,
}

impl Whitening {
    /// Whitening of sensor noise through `noise_kernel` of m q̈ + c q̇ + k q, and of white force noise of a variance, N²,
    /// behind the filter.
    pub fn new(states: &States, noise_kernel: &[f64], force_variance: f64) -> Self {
        let variance = states.band.noise_std * states.band.noise_std;
        let bell = Kernel::gaussian(states.deviation, 0, states.step_s()).taps;
        let force = force_variance / overlap(&bell, 0).max(f64::MIN_POSITIVE);
        let at = |lag: usize| {
            variance * overlap(noise_kernel, lag * states.stride) + force * overlap(&bell, lag * states.stride)
        };
        let order = SETTINGS.whitening_order;
        let (filter, left) = levinson(&(0..=order).map(at).collect::<Vec<_>>());
        // One sensor sample reaches rows through kernel and whitening alike.
        let mut joint = vec![0.0; noise_kernel.len() + order * states.stride];
        for (row, weight) in filter.iter().enumerate() {
            for (j, tap) in noise_kernel.iter().enumerate() {
                joint[row * states.stride + j] += weight * tap;
            }
        }
        // Rows at unit variance of the whole: values are then comparable from case to case.
        let scale = 1.0 / left.max(f64::MIN_POSITIVE).sqrt();
        let sensor_variance = variance * overlap(&joint, 0) * scale * scale;
        Self { filter: filter.into_iter().map(|a| a * scale).collect(), sensor_variance }
    }

    /// Whitens a column of [`States::rows`] rows. The first rows of each recording, and those that bad samples reach, are
    /// left out, the same rows for every column.
    pub fn apply(&self, states: &States, column: &[f64]) -> Vec<f64> {
        let mut out = Vec::with_capacity(column.len());
        self.each(states, |start, row| {
            out.push(self.filter.iter().enumerate().map(|(j, a)| a * column[start + row - j]).sum());
        });
        out
    }

    /// Recording and row of each whitened row.
    pub fn places(&self, states: &States) -> Vec<(usize, usize)> {
        let mut starts = vec![0];
        states.tracks.iter().for_each(|t| starts.push(starts[starts.len() - 1] + t.rows.len()));
        let mut out = Vec::new();
        self.each(states, |start, row| {
            out.push((starts.partition_point(|s| *s <= start) - 1, row));
        });
        out
    }

    fn each(&self, states: &States, mut take: impl FnMut(usize, usize)) {
        let order = self.filter.len() - 1;
        let mut start = 0;
        for track in &states.tracks {
            for row in order..track.rows.len() {
                if track.valid[row - order..=row].iter().all(|v| *v) {
                    take(start, row);
                }
            }
            start += track.rows.len();
        }
    }
}

/// Autocorrelation Σ_j k_j k_(j+lag) of a kernel.
fn overlap(kernel: &[f64], lag: usize) -> f64 {
    kernel.iter().zip(kernel.get(lag..).unwrap_or_default()).map(|(a, b)| a * b).sum()
}

/// Inner products of all columns in each block of consecutive rows.
pub struct Gram {
    blocks: Vec<Mat<f64>>,
    total: Mat<f64>,
    /// Rows of each block.
    pub counts: Vec<usize>,
    scales: Vec<f64>,
}

impl Gram {
    /// Inner products of columns of equal length, in blocks that end at the rows `ends`.
    pub fn new(columns: &[Vec<f64>], ends: &[usize]) -> Self {
        let p = columns.len();
        let scales: Vec<f64> = columns.iter().map(|c| super::regression::norm(c)).collect();
        let safe = |j: usize| if scales[j] > 0.0 { 1.0 / scales[j] } else { 0.0 };
        let (mut blocks, mut counts, mut start) = (Vec::new(), Vec::new(), 0);
        let mut total = Mat::zeros(p, p);
        for &end in ends {
            let x = Mat::from_fn(end - start, p, |i, j| columns[j][start + i] * safe(j));
            let product = x.transpose() * &x;
            total += &product;
            blocks.push(product);
            counts.push(end - start);
            start = end;
        }
        Self { blocks, total, counts, scales }
    }

    /// Least squares of column 0 on the columns `active` over all blocks but `without`. `None` if they are dependent.
    pub fn solve(&self, active: &[usize], without: &[usize]) -> Option<Vec<f64>> {
        let sums = |i: usize, j: usize| {
            let left: f64 = without.iter().map(|b| self.blocks[*b][(i, j)]).sum();
            self.total[(i, j)] - left
        };
        let mut normal: Vec<Vec<f64>> =
            active.iter().enumerate().map(|(n, i)| active[..=n].iter().map(|j| sums(*i, *j)).collect()).collect();
        let right: Vec<f64> = active.iter().map(|i| sums(*i, 0)).collect();
        let scaled = cholesky_solve(&mut normal, &right, 0.0)?;
        Some(scaled.iter().zip(active).map(|(b, j)| b * self.scales[0] / self.scales[*j]).collect())
    }

    /// Residual sum of squares of given coefficients in a block.
    pub fn left(&self, active: &[usize], values: &[f64], block: usize) -> f64 {
        self.form(&self.blocks[block], active, values)
    }

    /// Residual sum of squares of given coefficients in all blocks.
    pub fn left_total(&self, active: &[usize], values: &[f64]) -> f64 {
        self.form(&self.total, active, values)
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

    /// Residual sum of squares of each block, predicted from the blocks of other folds; `fold` holds the fold of each block.
    /// Blocks of fold `folds` and beyond are always fitted to, and have 0.
    pub fn held_out(&self, active: &[usize], fold: &[usize], folds: usize) -> Option<Vec<f64>> {
        let mut left = vec![0.0; self.blocks.len()];
        for number in 0..folds {
            let out: Vec<usize> = (0..fold.len()).filter(|b| fold[*b] == number).collect();
            let values = self.solve(active, &out)?;
            out.iter().for_each(|b| left[*b] = self.left(active, &values, *b));
        }
        Some(left)
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
