//! Removal of terms by what it costs in the residual, theory (16): the optimal brain surgeon of Hassibi and Stork 1993.
//!
//! With encoder and decoder as they are, the data losses are quadratic in Ξ, so at their minimum what the removal of a term costs
//! after the other terms of its equation have taken its place is exact. Of a library with more terms than can be judged so in
//! reasonable time those of least power are removed first. A term's own power says nothing here: two nearly equal terms of
//! opposite sign can each have a hundred times the power of their sum.

use ballrace_core::network::Network;
use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side};

use super::export;
use super::gradient::Lambdas;
use super::layout::Layout;
use super::settings::PruneSettings;
use crate::model::samples::Samples;
use crate::model::stlsq::add_gram;

const SETTINGS: PruneSettings = PruneSettings::DEFAULT;

/// Sets the coefficients of terms to 0 whose removal costs less than `share` of the power of ẋ, one after the other, the
/// cheapest first; the others of the equation change with each.
pub fn prune(layout: &Layout, parameters: &mut [f32], samples: &Samples<f32>, lambdas: Lambdas, share: f64) {
    let rows = Rows::new(layout, parameters, samples, lambdas);
    let xi = layout.xi();
    for equation in 0..layout.latent {
        let place = |term: usize| xi.start + term * layout.latent + equation;
        let mut active: Vec<usize> = (0..layout.terms.count()).filter(|t| parameters[place(*t)] != 0.0).collect();
        if active.len() > SETTINGS.max_terms {
            let power = |t: usize| f64::from(parameters[place(t)].powi(2)) * rows.theta.col(t).squared_norm_l2();
            active.sort_by(|a, b| power(*b).total_cmp(&power(*a)));
            active.drain(SETTINGS.max_terms..).for_each(|t| parameters[place(t)] = 0.0);
            active.sort_unstable();
        }
        let mut coefficients: Vec<f64> = active.iter().map(|t| f64::from(parameters[place(*t)])).collect();
        eliminate(&rows.hessian(&active, equation), &mut coefficients, share);
        active.iter().zip(&coefficients).for_each(|(t, c)| parameters[place(*t)] = *c as f32);
    }
}

/// Library over samples, and the weight of each equation's rate in the losses.
struct Rows {
    /// Rows θ(z): samples × terms.
    theta: Mat<f64>,
    /// Weight of each equation at each sample, in units of the power of ẋ: samples × equations.
    weights: Mat<f64>,
}

impl Rows {
    fn new(layout: &Layout, parameters: &[f32], samples: &Samples<f32>, lambdas: Lambdas) -> Self {
        let (terms, latent, inputs) = (layout.terms.count(), layout.latent, layout.inputs);
        let wanted = (SETTINGS.rows_per_term * terms).clamp(SETTINGS.min_rows, SETTINGS.max_rows);
        let count = samples.len().min(wanted);
        let (encoder, decoder) =
            (export::network(&layout.encoder, parameters), export::network(&layout.decoder, parameters));
        let (encoder, decoder): (Network<'_>, Network<'_>) = (encoder.view(), decoder.view());
        let mut scratch = vec![0.0; encoder.forward_scratch_len().max(decoder.tangent_scratch_len())];
        let (mut z, mut theta) = (vec![0.0; latent], vec![0.0; terms]);
        let (mut unit, mut column) = (vec![0.0; latent], vec![0.0; inputs]);
        let mut rows = Self { theta: Mat::zeros(count, terms), weights: Mat::zeros(count, latent) };
        let scale = if lambdas.derivative > 0.0 { lambdas.derivative } else { lambdas.latent };
        for s in 0..count {
            encoder.forward(samples.row(s * samples.len() / count).0, &mut z, &mut scratch);
            layout.library.row(&z, &mut theta);
            theta.iter().enumerate().for_each(|(t, value)| rows.theta[(s, t)] = f64::from(*value));
            for e in 0..latent {
                unit.fill(0.0);
                unit[e] = 1.0;
                decoder.tangent(&z, &unit, &mut column, &mut scratch);
                let power = column.iter().map(|v| f64::from(v * v)).sum::<f64>() / inputs as f64;
                rows.weights[(s, e)] =
                    (lambdas.derivative * power + lambdas.latent / latent as f64) / scale / count as f64;
            }
        }
        rows
    }

    /// Quadratic form of the losses in one equation's coefficients, its lower triangle.
    fn hessian(&self, active: &[usize], equation: usize) -> Mat<f64> {
        let (rows, n) = (self.theta.nrows(), active.len());
        let weighted = Mat::from_fn(rows, n, |s, t| self.theta[(s, active[t])] * self.weights[(s, equation)].sqrt());
        let mut hessian = Mat::zeros(n, n);
        add_gram(&mut hessian, weighted.as_ref());
        for t in 0..n {
            hessian[(t, t)] += SETTINGS.ridge * hessian[(t, t)] + f64::MIN_POSITIVE;
        }
        hessian
    }
}

/// Eliminates coefficients of a quadratic form while one costs less than `least`, the cheapest first; the form's minimum under
/// that condition follows in closed form. A form that is not positive definite loses none.
fn eliminate(form: &Mat<f64>, coefficients: &mut [f64], least: f64) {
    let n = coefficients.len();
    let Ok(factor) = form.llt(Side::Lower) else { return };
    let inverse = factor.inverse();
    let mut rows: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| inverse[(i, j)]).collect()).collect();
    let mut left: Vec<usize> = (0..n).collect();
    loop {
        let cost = |i: usize| coefficients[i] * coefficients[i] / rows[i][i];
        let Some(at) = (0..left.len()).min_by(|a, b| cost(left[*a]).total_cmp(&cost(left[*b]))) else { return };
        let removed = left[at];
        if cost(removed) >= least {
            return;
        }
        left.swap_remove(at);
        let row = std::mem::take(&mut rows[removed]);
        let value = std::mem::take(&mut coefficients[removed]);
        for i in &left {
            let ratio = row[*i] / row[removed];
            coefficients[*i] -= value * ratio;
            rows[*i].iter_mut().zip(&row).for_each(|(p, r)| *p -= ratio * r);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Form of columns whose inner products are given.
    fn form(products: [[f64; 3]; 3]) -> Mat<f64> {
        Mat::from_fn(3, 3, |i, j| products[i][j])
    }

    #[test]
    fn opposed_terms_that_are_nearly_equal_do_not_keep_each_other() {
        // Columns 0 and 1 are equal but for a part of power 1e-4: 50 times one less 49 times the other is one of them and a
        // part of power 0.24.
        let products = form([[1.0001, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let mut coefficients = [50.0, -49.0, 0.5];
        eliminate(&products, &mut coefficients, 0.3);
        assert_eq!(coefficients.iter().filter(|c| **c == 0.0).count(), 2, "{coefficients:?}");
        // By power each of the two is 2,400 or more.
        assert!(coefficients[0].abs().max(coefficients[1].abs()) > 0.9, "{coefficients:?}");
    }

    #[test]
    fn invariant_the_others_take_the_removed_one_s_place_at_least_cost() {
        let products = form([[2.0, 0.6, 0.1], [0.6, 1.0, 0.3], [0.1, 0.3, 1.5]]);
        let start = [1.0, 0.1, -1.0];
        let mut coefficients = start;
        eliminate(&products, &mut coefficients, 0.05);
        assert_eq!(coefficients[1], 0.0);
        // The gradient of the form about its start is 0 in what is left.
        let change: Vec<f64> = coefficients.iter().zip(start).map(|(c, s)| c - s).collect();
        for i in [0, 2] {
            let slope: f64 = (0..3).map(|j| products[(i, j)] * change[j]).sum();
            assert!(slope.abs() < 1e-12, "{slope}");
        }
    }
}
