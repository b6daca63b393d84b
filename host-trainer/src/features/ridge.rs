//! Ridge regression on moments of the rows, theory (121).

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// Weighted moments of rows of features and targets.
#[derive(Clone, Debug)]
pub struct Moments {
    weight: f64,
    sums: Vec<f64>,
    products: Mat<f64>,
}

impl Moments {
    /// Moments of nothing, of rows with this many columns.
    pub fn zero(columns: usize) -> Self {
        Self { weight: 0.0, sums: vec![0.0; columns], products: Mat::zeros(columns, columns) }
    }

    /// Mean moments of rows, which have the weight 1 together.
    pub fn of_rows<'r>(rows: impl ExactSizeIterator<Item = &'r [f64]>, columns: usize) -> Self {
        let mut moments = Self::zero(columns);
        let weight = 1.0 / rows.len() as f64;
        for row in rows {
            for (j, right) in row.iter().enumerate() {
                moments.sums[j] += weight * right;
                row[..=j].iter().enumerate().for_each(|(i, left)| moments.products[(i, j)] += weight * left * right);
            }
        }
        moments.weight = 1.0;
        moments
    }

    /// Moments with targets that are the same in all rows as further columns.
    pub fn with_targets(&self, targets: &[f64]) -> Self {
        let (own, all) = (self.sums.len(), self.sums.len() + targets.len());
        let mut more = Self::zero(all);
        more.weight = self.weight;
        more.sums[..own].copy_from_slice(&self.sums);
        more.products.as_mut().submatrix_mut(0, 0, own, own).copy_from(&self.products);
        for (place, target) in (own..).zip(targets) {
            more.sums[place] = target * self.weight;
            (0..place).for_each(|i| more.products[(i, place)] = target * more.sums[i]);
            more.products[(place, place)] = target * target * self.weight;
        }
        more
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.sums.len()
    }

    /// Adds other rows with a weight.
    pub fn add(&mut self, other: &Self, weight: f64) {
        self.weight += weight * other.weight;
        self.sums.iter_mut().zip(&other.sums).for_each(|(sum, other)| *sum += weight * other);
        self.products += faer::Scale(weight) * &other.products;
    }

    /// Weighted covariance of two columns, `i` not after `j`.
    fn covariance(&self, i: usize, j: usize) -> f64 {
        (self.products[(i, j)] - self.sums[i] * self.sums[j] / self.weight) / self.weight
    }
}

/// Linear predictor of targets.
#[derive(Clone, Debug, PartialEq)]
pub struct Ridge {
    /// For each target, its constant and a weight of each feature.
    weights: Vec<(f64, Vec<f64>)>,
}

impl Ridge {
    /// One regression for each penalty: features come first among the columns, then as many targets.
    pub fn fit(moments: &Moments, targets: usize, penalties: &[f64]) -> Vec<Self> {
        let features = moments.sums.len() - targets;
        let mean = |column: usize| moments.sums[column] / moments.weight;
        let spread = |column: usize| {
            let variance = moments.covariance(column, column);
            // Below this a variance is rounding error.
            if variance > 1e-12 * mean(column).powi(2) { variance.sqrt() } else { f64::INFINITY }
        };
        let spreads: Vec<f64> = (0..features).map(spread).collect();
        let correlation =
            Mat::from_fn(features, features, |i, j| moments.covariance(i.min(j), i.max(j)) / (spreads[i] * spreads[j]));
        let products = Mat::from_fn(features, targets, |i, k| moments.covariance(i, features + k) / spreads[i]);
        let one = |penalty: &f64| {
            let mut normal = correlation.clone();
            (0..features).for_each(|i| normal[(i, i)] += penalty);
            let solution = normal.llt(Side::Lower).expect("positive definite with a penalty").solve(&products);
            let of_target = |k: usize| {
                let weights: Vec<f64> = (0..features).map(|i| solution[(i, k)] / spreads[i]).collect();
                let shift: f64 = weights.iter().enumerate().map(|(i, weight)| weight * mean(i)).sum();
                (mean(features + k) - shift, weights)
            };
            Self { weights: (0..targets).map(of_target).collect() }
        };
        penalties.iter().map(one).collect()
    }

    /// Prediction of each target.
    pub fn predict(&self, row: &[f64]) -> Vec<f64> {
        let one = |(constant, weights): &(f64, Vec<f64>)| {
            constant + weights.iter().zip(row).map(|(weight, value)| weight * value).sum::<f64>()
        };
        self.weights.iter().map(one).collect()
    }
}
