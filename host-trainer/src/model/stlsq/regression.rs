//! Ridge regressions for one output after the other and fewer and fewer terms, theory (18) and (19).

use faer::linalg::solvers::{DenseSolveCore, Solve, SolveLstsqCore};
use faer::{Mat, Side};

use super::r_factor::{RFactor, add_gram};
use super::settings::SolveSettings;

const SETTINGS: SolveSettings = SolveSettings::DEFAULT;

/// Ridge regressions on columns of unit RMS.
pub struct Regression<'a> {
    train: &'a RFactor,
    /// RMS of each term's column.
    scales: Vec<f64>,
    ridge: f64,
    /// Normal equations; `None` where the ridge is too small for them.
    normal: Option<Normal>,
}

/// Normal equations of columns with unit RMS.
struct Normal {
    /// Inner products of the terms with each other and the ridge, the lower triangle.
    gram: Mat<f64>,
    /// Inner products of the terms with the targets.
    products: Mat<f64>,
    /// Inverse of the Gram matrix of the terms whose column is not zero.
    inverse: Mat<f64>,
}

/// Terms in use for an output.
struct Active {
    terms: Vec<usize>,
    /// Coefficients of columns with unit RMS.
    coefficients: Vec<f64>,
    /// Inverse of the terms' Gram matrix; `None` without normal equations.
    inverse: Option<Mat<f64>>,
}

impl<'a> Regression<'a> {
    /// Regressions on the rows of a factor with the penalty `ridge`.
    pub fn new(train: &'a RFactor, ridge: f64) -> Self {
        let scales: Vec<f64> = (0..train.terms).map(|t| train.term_rms(t)).collect();
        let mut regression = Self { train, scales, ridge, normal: None };
        if ridge >= SETTINGS.min_normal_ridge {
            regression.normal = regression.normal();
        }
        regression
    }

    /// Normal equations; `None` if they are not positive definite.
    fn normal(&self) -> Option<Normal> {
        let train = self.train;
        // A column of zeros is never active.
        let divisors: Vec<f64> = self.scales.iter().map(|scale| if *scale > 0.0 { *scale } else { 1.0 }).collect();
        let every: Vec<usize> = (0..train.terms).collect();
        let columns = train.scaled(&every, &divisors);
        let mut gram = Mat::zeros(train.terms, train.terms);
        add_gram(&mut gram, columns.as_ref());
        (0..train.terms).for_each(|t| gram[(t, t)] += self.ridge);
        let targets: Vec<Mat<f64>> = (0..train.outputs()).map(|output| train.target(output)).collect();
        let targets = Mat::from_fn(columns.nrows(), targets.len(), |i, j| targets[j][(i, 0)]);
        let products = columns.transpose() * targets;
        let inverse = inverse(&gram, &self.all())?;
        Some(Normal { gram, products, inverse })
    }

    /// Terms whose column is not zero.
    fn all(&self) -> Vec<usize> {
        (0..self.train.terms).filter(|t| self.scales[*t] > 0.0).collect()
    }

    /// Coefficients of one output for growing thresholds, theory (19), each from the terms that the last one kept.
    pub fn threshold_path(&self, output: usize, thresholds: &[f64], rounds: usize) -> Vec<Vec<f64>> {
        let target_power = self.train.variance(output).max(f64::MIN_POSITIVE);
        let mut active = self.dense(output);
        let mut at = |threshold: &f64| {
            for _ in 0..rounds {
                let is_kept = |i: &usize| active.coefficients[*i].powi(2) >= threshold * target_power;
                let (kept, dropped): (Vec<usize>, Vec<usize>) = (0..active.terms.len()).partition(is_kept);
                if dropped.is_empty() {
                    break;
                }
                active = self.without(&active, &kept, &dropped, output);
            }
            self.unscaled(&active.terms, &active.coefficients)
        };
        thresholds.iter().map(&mut at).collect()
    }

    /// Coefficients of one output for the terms that are not 0 in `path`, solved for at once: those of a path have the rounding
    /// errors of its steps.
    pub fn refined(&self, output: usize, path: &[f64]) -> Vec<f64> {
        let terms: Vec<usize> = (0..path.len()).filter(|t| path[*t] != 0.0).collect();
        let by_normal = self.normal.as_ref().and_then(|normal| {
            let factor = submatrix(&normal.gram, &terms).llt(Side::Lower).ok()?;
            let solution = factor.solve(Mat::from_fn(terms.len(), 1, |i, _| normal.products[(terms[i], output)]));
            Some((0..terms.len()).map(|i| solution[(i, 0)]).collect::<Vec<f64>>())
        });
        self.unscaled(&terms, &by_normal.unwrap_or_else(|| self.solve_by_rows(&terms, output)))
    }

    /// Coefficients of all terms of the library from those of columns with unit RMS.
    fn unscaled(&self, terms: &[usize], scaled: &[f64]) -> Vec<f64> {
        let mut coefficients = vec![0.0; self.train.terms];
        terms.iter().zip(scaled).for_each(|(term, c)| coefficients[*term] = c / self.scales[*term]);
        coefficients
    }

    /// All terms.
    fn dense(&self, output: usize) -> Active {
        let terms = self.all();
        match &self.normal {
            Some(normal) => Active {
                coefficients: product(&normal.inverse, |i| normal.products[(terms[i], output)]),
                inverse: Some(normal.inverse.clone()),
                terms,
            },
            None => Active { coefficients: self.solve_by_rows(&terms, output), inverse: None, terms },
        }
    }

    /// Terms that are kept, by their places among the active ones.
    fn without(&self, active: &Active, kept: &[usize], dropped: &[usize], output: usize) -> Active {
        let terms: Vec<usize> = kept.iter().map(|i| active.terms[*i]).collect();
        let (Some(normal), Some(inverse)) = (&self.normal, &active.inverse) else {
            return Active { coefficients: self.solve_by_rows(&terms, output), inverse: None, terms };
        };
        if dropped.len() * SETTINGS.downdate_divisor > active.terms.len() {
            return match self::inverse(&normal.gram, &terms) {
                Some(inverse) => Active {
                    coefficients: product(&inverse, |i| normal.products[(terms[i], output)]),
                    inverse: Some(inverse),
                    terms,
                },
                None => Active { coefficients: self.solve_by_rows(&terms, output), inverse: None, terms },
            };
        }
        // With P the inverse: P_KK − P_KD P_DD⁻¹ P_DK, and likewise the coefficients.
        let across = Mat::from_fn(dropped.len(), kept.len(), |i, j| inverse[(dropped[i], kept[j])]);
        let corner = Mat::from_fn(dropped.len(), dropped.len(), |i, j| inverse[(dropped[i], dropped[j])]);
        let Ok(corner) = corner.llt(Side::Lower) else {
            return Active { coefficients: self.solve_by_rows(&terms, output), inverse: None, terms };
        };
        let weights = corner.solve(&across);
        let change = across.transpose() * &weights;
        let coefficient = |(j, i): (usize, &usize)| {
            let share = dropped.iter().enumerate().map(|(d, at)| weights[(d, j)] * active.coefficients[*at]);
            active.coefficients[*i] - share.sum::<f64>()
        };
        Active {
            coefficients: kept.iter().enumerate().map(coefficient).collect(),
            inverse: Some(Mat::from_fn(kept.len(), kept.len(), |i, j| inverse[(kept[i], kept[j])] - change[(i, j)])),
            terms,
        }
    }

    /// Ridge least squares for some terms by QR of the stacked [R_A ; √μ I], in coefficients of columns with unit RMS.
    fn solve_by_rows(&self, terms: &[usize], output: usize) -> Vec<f64> {
        let n = terms.len();
        if n == 0 {
            return Vec::new();
        }
        let a = self.train.scaled(terms, &self.scales);
        let rows = a.nrows();
        let mut tall = Mat::zeros(rows + n, n);
        tall.as_mut().subrows_mut(0, rows).copy_from(&a);
        let mut rhs = Mat::zeros(rows + n, 1);
        rhs.as_mut().subrows_mut(0, rows).copy_from(&self.train.target(output));
        for i in 0..n {
            tall[(rows + i, i)] = self.ridge.sqrt();
        }
        tall.qr().solve_lstsq_in_place_with_conj(faer::Conj::No, rhs.as_mut());
        (0..n).map(|i| rhs[(i, 0)]).collect()
    }
}

/// Lower triangle of a symmetric matrix for some of its rows and columns, in order.
fn submatrix(lower: &Mat<f64>, places: &[usize]) -> Mat<f64> {
    Mat::from_fn(places.len(), places.len(), |i, j| lower[(places[i.max(j)], places[i.min(j)])])
}

/// Inverse for some rows and columns; `None` if they are not positive definite.
fn inverse(lower: &Mat<f64>, places: &[usize]) -> Option<Mat<f64>> {
    Some(submatrix(lower, places).llt(Side::Lower).ok()?.inverse())
}

fn product(matrix: &Mat<f64>, vector: impl Fn(usize) -> f64) -> Vec<f64> {
    let product = matrix * Mat::from_fn(matrix.ncols(), 1, |i, _| vector(i));
    (0..matrix.nrows()).map(|i| product[(i, 0)]).collect()
}

#[cfg(test)]
mod tests {
    use ballrace_core::library::Library;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::model::samples::Samples;

    #[test]
    fn invariant_steps_of_a_path_end_where_one_solution_does() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut noise = |count: usize| (0..count).map(|_| rng.random_range(-1.0..1.0f32)).collect::<Vec<_>>();
        let samples = Samples { inputs: 3, x: noise(3000), dx: noise(3000) };
        let train = RFactor::from_samples(Library::new(3, 3, 2).unwrap(), &samples);
        let by_normal = Regression::new(&train, 1e-6);
        let by_rows = Regression { normal: None, ..Regression::new(&train, 1e-6) };
        let thresholds = [0.0, 1e-5, 1e-4, 3e-4, 1e-3, 3e-3];
        for output in 0..3 {
            let (path, reference) =
                (by_normal.threshold_path(output, &thresholds, 20), by_rows.threshold_path(output, &thresholds, 20));
            for (step, reference) in path.iter().zip(&reference) {
                let refined = by_normal.refined(output, step);
                for t in 0..train.terms {
                    assert!((step[t] - reference[t]).abs() < 1e-7 && (refined[t] - reference[t]).abs() < 1e-7);
                }
            }
            let terms = |step: &Vec<f64>| step.iter().filter(|c| **c != 0.0).count();
            assert!(terms(&path[0]) == train.terms && terms(&path[5]) < terms(&path[2]));
        }
    }
}
