//! Least squares on filtered, correlated rows, theory (66): estimates, intervals that allow for the correlation, and
//! undetermined combinations.

use crate::stats::significance::Z975;
use faer::{Mat, Side};

use super::settings::BalanceSettings;

const SETTINGS: BalanceSettings = BalanceSettings::DEFAULT;
/// A fitted linear model.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Coefficient of each column.
    pub values: Vec<f64>,
    /// Covariance, row by row.
    pub covariance: Vec<Vec<f64>>,
    /// Residual of each row.
    pub residual: Vec<f64>,
}

impl Fit {
    /// Half the width of each 95 % interval.
    pub fn half_widths(&self) -> Vec<f64> {
        (0..self.values.len()).map(|i| Z975 * self.covariance[i][i].max(0.0).sqrt()).collect()
    }
}

/// An undetermined combination of parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Open {
    /// Index of each column in the combination and its share of the unit vector, in columns of unit length.
    pub parts: Vec<(usize, f64)>,
}

/// Least squares of `target` on `columns`, with the covariance of Newey and West (Econometrica 55 (1987) 703–708) over
/// `lags` rows, theory (66). `groups` are the lengths of the recordings one after the other, over whose ends nothing
/// correlates. `None` if the columns are dependent or outnumber the rows.
pub fn least_squares(columns: &[Vec<f64>], target: &[f64], groups: &[usize], lags: usize) -> Option<Fit> {
    let (n, p) = (target.len(), columns.len());
    if n <= p + 2 {
        return None;
    }
    let scales: Vec<f64> = columns.iter().map(|c| norm(c)).collect();
    if scales.contains(&0.0) {
        return None;
    }
    let x = Mat::from_fn(n, p, |i, j| columns[j][i] / scales[j]);
    let gram = x.transpose() * &x;
    let inverse = invert(&gram)?;
    let y = Mat::from_fn(n, 1, |i, _| target[i]);
    let mut scaled = &inverse * (x.transpose() * &y);
    // One refinement on the residual restores the digits that the normal equations lost.
    let left = &y - &x * &scaled;
    scaled += &inverse * (x.transpose() * &left);
    let left = &y - &x * &scaled;
    let residual: Vec<f64> = (0..n).map(|i| left[(i, 0)]).collect();
    let scores: Vec<Vec<f64>> = (0..p).map(|j| (0..n).map(|i| x[(i, j)] * residual[i]).collect()).collect();
    let meat = long_run(&scores, groups, lags);
    let meat = Mat::from_fn(p, p, |i, j| meat[i][j]);
    let spread = &inverse * meat * &inverse;
    // Correction for the degrees of freedom of the fit.
    let share = n as f64 / (n - p) as f64;
    let covariance =
        (0..p).map(|i| (0..p).map(|j| share * spread[(i, j)] / (scales[i] * scales[j])).collect()).collect();
    let values = (0..p).map(|j| scaled[(j, 0)] / scales[j]).collect();
    Some(Fit { values, covariance, residual })
}

/// Sum of the products of rows at most `lags` apart, with Bartlett's weights.
fn long_run(scores: &[Vec<f64>], groups: &[usize], lags: usize) -> Vec<Vec<f64>> {
    let p = scores.len();
    let mut sum = vec![vec![0.0; p]; p];
    let mut start = 0;
    for &length in groups {
        for lag in 0..=lags.min(length.saturating_sub(1)) {
            let weight = 1.0 - lag as f64 / (lags + 1) as f64;
            for i in 0..p {
                for j in 0..p {
                    let (a, b) = (&scores[i][start + lag..start + length], &scores[j][start..start + length - lag]);
                    let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                    sum[i][j] += weight * product;
                    if lag > 0 {
                        sum[j][i] += weight * product;
                    }
                }
            }
        }
        start += length;
    }
    sum
}

/// Lags after which the residual no longer correlates: twice the first below 2/√n, at most a tenth of the shortest
/// recording but never below 4.
pub fn correlation_length(residual: &[f64], groups: &[usize]) -> usize {
    let shortest = groups.iter().copied().min().unwrap_or(0);
    let most = (shortest / SETTINGS.recording_lags).max(1);
    let variance: f64 = residual.iter().map(|r| r * r).sum();
    let at = |lag: usize| {
        let mut start = 0;
        let mut sum = 0.0;
        for &length in groups {
            let part = &residual[start..start + length];
            sum += part[lag.min(length)..].iter().zip(part).map(|(a, b)| a * b).sum::<f64>();
            start += length;
        }
        sum / variance.max(f64::MIN_POSITIVE)
    };
    let limit = 2.0 / (residual.len().max(1) as f64).sqrt();
    let first = (1..=most).find(|lag| at(*lag).abs() < limit).unwrap_or(most);
    (2 * first).clamp(SETTINGS.min_lags, most.max(SETTINGS.min_lags))
}

/// Undetermined combinations of the columns: singular values below 1e-6 of the largest.
pub fn undetermined(columns: &[Vec<f64>]) -> Vec<Open> {
    let scales: Vec<f64> = columns.iter().map(|c| norm(c).max(f64::MIN_POSITIVE)).collect();
    let (n, p) = (columns.first().map_or(0, Vec::len), columns.len());
    if n == 0 || p == 0 {
        return Vec::new();
    }
    let zero: Vec<usize> = (0..p).filter(|j| norm(&columns[*j]) == 0.0).collect();
    let mut open: Vec<Open> = zero.iter().map(|j| Open { parts: vec![(*j, 1.0)] }).collect();
    let live: Vec<usize> = (0..p).filter(|j| !zero.contains(j)).collect();
    let x = Mat::from_fn(n, live.len(), |i, j| columns[live[j]][i] / scales[live[j]]);
    let Ok(svd) = x.thin_svd() else { return open };
    let singular: Vec<f64> = (0..live.len().min(n)).map(|i| svd.S().column_vector()[i]).collect();
    let largest = singular.iter().copied().fold(0.0, f64::max);
    for (i, s) in singular.iter().enumerate() {
        if *s < SETTINGS.min_singular_ratio * largest {
            let parts = live.iter().enumerate().map(|(j, column)| (*column, svd.V()[(j, i)]));
            let parts = parts.filter(|(_, share)| share.abs() > SETTINGS.min_direction_share).collect();
            open.push(Open { parts });
        }
    }
    open
}

/// Root of the sum of squares.
pub fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn invert(gram: &Mat<f64>) -> Option<Mat<f64>> {
    use faer::linalg::solvers::SolveCore;
    let factor = gram.llt(Side::Lower).ok()?;
    let p = gram.nrows();
    let smallest = (0..p).map(|i| factor.L()[(i, i)]).fold(f64::INFINITY, f64::min);
    if smallest < SETTINGS.min_singular_ratio {
        return None;
    }
    let mut inverse = Mat::identity(p, p);
    factor.solve_in_place_with_conj(faer::Conj::No, inverse.as_mut());
    Some(inverse)
}

#[cfg(test)]
mod tests {
    use super::{super::testing::white, *};

    #[test]
    fn invariant_exact_data_give_exact_values_and_no_width() {
        let columns = vec![white(1, 1.0, 200), white(2, 3.0, 200)];
        let target: Vec<f64> = (0..200).map(|i| 2.0 * columns[0][i] - 0.5 * columns[1][i]).collect();
        let fit = least_squares(&columns, &target, &[200], 4).unwrap();
        assert!((fit.values[0] - 2.0).abs() < 1e-12 && (fit.values[1] + 0.5).abs() < 1e-12);
        assert!(fit.half_widths().iter().all(|w| *w < 1e-12));
    }

    /// Rows that correlate over 10: the interval of a mean is √(1 + 2 Σ ρ) wider than if they did not.
    #[test]
    fn invariant_intervals_allow_for_correlation() {
        let noise = white(3, 1.0, 20_010);
        let target: Vec<f64> = noise.windows(10).take(20_000).map(|w| w.iter().sum()).collect();
        let ones = vec![vec![1.0; 20_000]];
        let lags = correlation_length(&target, &[20_000]);
        let width = least_squares(&ones, &target, &[20_000], lags).unwrap().half_widths()[0];
        let expected = Z975 * 10.0 / 20_000f64.sqrt();
        assert!((width / expected - 1.0).abs() < 0.25, "{width} {expected} {lags}");
    }

    #[test]
    fn invariant_dependent_columns_are_named() {
        let (a, b) = (white(4, 1.0, 100), white(5, 1.0, 100));
        let sum: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a + b).collect();
        let open = undetermined(&[a, b, sum]);
        assert_eq!(open.len(), 1);
        assert_eq!(open[0].parts.len(), 3);
        assert!(undetermined(&[white(4, 1.0, 100), white(5, 1.0, 100)]).is_empty());
    }
}
