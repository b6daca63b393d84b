//! Whitened columns of all hypotheses in blocks, and cross-validated residuals of models of them.

use super::flexible;
use super::terms::{Library, Meaning, Sign};
use crate::identify::force_balance::{
    BalanceError,
    equation::{Equation, Parameter},
    gram::{Gram, Whitening},
    regression,
    states::States,
};
use crate::rig::{EffectEntry, Rig};

/// Blocks into which the recordings in question are cut, about.
const BLOCKS: usize = 32;
/// Folds of the cross-validation.
const FOLDS: usize = 4;
/// Most columns that the richest model takes, and the least that each must bring.
const RICHEST: usize = 8;
const BRINGS: f64 = 0.005;
/// By how much a play's spring may differ from the rig's.
const SPRING: (f64, f64) = (0.6, 1.6);

/// Columns of all hypotheses with their cross-validation.
pub struct Table {
    /// Candidate library, filtered and not whitened.
    pub library: Library,
    /// Gram matrix of the whitened columns by block.
    pub gram: Gram,
    /// Recording and row of each whitened row.
    pub places: Vec<(usize, usize)>,
    /// Whitened columns.
    pub white: Vec<Vec<f64>>,
    /// Fold of each block; blocks of healthy recordings have the last number, which is never left out.
    pub fold: Vec<usize>,
    /// Blocks of the recordings under test.
    pub under_test: Vec<usize>,
    /// Variance of a whitened row by the sensor's noise alone.
    pub floor: f64,
}

/// Model of one or more terms with their best nonlinear parameters.
#[derive(Clone, Debug)]
pub struct TermModel {
    /// Term and variant of each part.
    pub parts: Vec<(usize, usize)>,
    /// Columns, the rig's own first.
    pub columns: Vec<usize>,
    /// Coefficients of the columns, from all rows.
    pub values: Vec<f64>,
    /// Squared residual of each block under test, with coefficients from the other folds.
    pub left: Vec<f64>,
}

impl TermModel {
    /// Sum of the squared residuals over the blocks.
    pub fn total(&self) -> f64 {
        self.left.iter().sum()
    }
}

impl Table {
    /// Table of a rig and recordings, some of them healthy; `unknown` is fitted with every hypothesis, the
    /// grid is finer around `focus`.
    ///
    /// # Errors
    ///
    /// A rig of another kind.
    pub fn new(
        rig: &Rig,
        states: &States,
        healthy: &[bool],
        unknown: &[Parameter],
        focus: &[EffectEntry],
    ) -> Result<Self, BalanceError> {
        let equation = Equation::new(rig, states)?;
        let mut library = Library::new(rig, &equation, states, healthy, unknown, focus);
        flexible::add(states, healthy, &mut library);
        let machine = &equation.rig;
        let kernel = states.noise_kernel(machine.mass_kg, machine.damping_n_s_per_m, machine.stiffness_n_per_m);
        let rows = states.rows().max(1) as f64;
        let power = |x: &[f64]| regression::norm(x).powi(2) / rows;
        // As a start, a hundredth of the force is taken for disturbance.
        let mut disturbance = 1e-4 * power(equation.column(Parameter::Gain)) * machine.input_gain_n_per_unit.powi(2);
        let sensor = states.band.noise_std.powi(2) * power(&kernel) * rows;
        let mut table = Self::whitened(library, states, healthy, &kernel, disturbance);
        for _ in 0..2 {
            let rich = table.richest(&table.library.own_columns(), RICHEST);
            let values = table.gram.solve(&rich, &[]).unwrap_or_default();
            let mut left = table.library.columns[0].clone();
            for (column, value) in rich.iter().zip(&values) {
                left.iter_mut().zip(&table.library.columns[*column]).for_each(|(r, x)| *r -= value * x);
            }
            disturbance = (power(&left) - sensor).max(0.01 * sensor).max(1e-8 * power(&table.library.columns[0]));
            let library = std::mem::take(&mut table.library);
            table = Self::whitened(library, states, healthy, &kernel, disturbance);
        }
        Ok(table)
    }

    fn whitened(library: Library, states: &States, healthy: &[bool], kernel: &[f64], disturbance: f64) -> Self {
        let whitening = Whitening::new(states, kernel, disturbance);
        let white: Vec<Vec<f64>> = library.columns.iter().map(|c| whitening.apply(states, c)).collect();
        let places = whitening.places(states);
        let questioned = healthy.iter().filter(|h| !**h).count().max(1);
        let each = (BLOCKS / questioned).max(2);
        let (mut ends, mut fold, mut under_test) = (Vec::new(), Vec::new(), Vec::new());
        let (mut start, mut number) = (0, 0);
        for (track, healthy) in healthy.iter().enumerate() {
            let length = places[start..].iter().take_while(|(t, _)| *t == track).count();
            let blocks = if length < 4 * each { usize::from(length > 0) } else { each };
            for block in 0..blocks {
                ends.push(start + (block + 1) * length / blocks);
                let in_turn = if questioned >= FOLDS { number } else { under_test.len() };
                if !*healthy {
                    under_test.push(fold.len());
                }
                fold.push(if *healthy { FOLDS } else { in_turn % FOLDS });
            }
            number += usize::from(!*healthy);
            start += length;
        }
        let gram = Gram::new(&white, &ends);
        Self { library, gram, places, white, fold, under_test, floor: whitening.sensor_variance }
    }

    /// Count of rows under test.
    pub fn rows(&self) -> usize {
        self.under_test.iter().map(|b| self.gram.counts[*b]).sum()
    }

    /// Squared residual of each block under test, predicted from the other folds.
    pub fn held_out(&self, columns: &[usize]) -> Option<Vec<f64>> {
        let left = self.gram.held_out(columns, &self.fold, FOLDS)?;
        Some(self.under_test.iter().map(|b| left[*b]).collect())
    }

    /// Model of the rig alone, its unknown parameters fitted.
    pub fn nothing(&self) -> Option<TermModel> {
        let columns = self.library.own_columns();
        let values = self.gram.solve(&columns, &[])?;
        let left = self.held_out(&columns)?;
        Some(TermModel { parts: Vec::new(), columns, values, left })
    }

    /// Model of the best variants of some terms, some possibly given; `None` if no variant has the right signs or the columns
    /// are linearly dependent.
    pub fn best(&self, terms: &[usize], given: &[(usize, usize)]) -> Option<TermModel> {
        let own = self.library.own_columns();
        let mut best: Option<(f64, TermModel)> = None;
        let sizes: Vec<usize> = terms.iter().map(|t| self.library.terms[*t].variants.len()).collect();
        let count: usize = sizes.iter().product();
        for index in 0..count {
            let mut rest = index;
            let mut parts = given.to_vec();
            for (term, size) in terms.iter().zip(&sizes) {
                parts.push((*term, rest % size));
                rest /= size;
            }
            let mut columns = own.clone();
            parts.iter().for_each(|(t, v)| columns.extend(&self.library.terms[*t].variants[*v].columns));
            let Some(values) = self.gram.solve(&columns, &[]) else { continue };
            if !self.signs_fit(&parts, &columns, &values) {
                continue;
            }
            let left = self.gram.left_total(&columns, &values);
            if best.as_ref().is_none_or(|(least, _)| left < *least) {
                best = Some((left, TermModel { parts, columns, values, left: Vec::new() }));
            }
        }
        let (_, model) = best?;
        let left = self.held_out(&model.columns)?;
        Some(TermModel { left, ..model })
    }

    /// Coefficients of a part of a model.
    pub fn coefficients<'a>(&self, model: &'a TermModel, part: usize) -> &'a [f64] {
        let (term, variant) = model.parts[part];
        let columns = &self.library.terms[term].variants[variant].columns;
        let first = model.columns.iter().position(|c| *c == columns[0]).unwrap_or(0);
        &model.values[first..first + columns.len()]
    }

    fn signs_fit(&self, parts: &[(usize, usize)], columns: &[usize], values: &[f64]) -> bool {
        parts.iter().all(|(term, variant)| {
            let term = &self.library.terms[*term];
            let column = term.variants[*variant].columns[0];
            let value = columns.iter().position(|c| *c == column).map_or(0.0, |i| values[i]);
            let sign = term.sign == Sign::Any || value > 0.0;
            let spring = match term.meaning {
                Meaning::Spring => {
                    let k = self.stiffness(columns, values);
                    (SPRING.0 * k..SPRING.1 * k).contains(&value)
                }
                // No sensor measures a tenth or ten times of what there is, or with the wrong sign.
                Meaning::Gain => (-0.9..9.0).contains(&value),
                _ => true,
            };
            sign && spring
        })
    }

    fn stiffness(&self, columns: &[usize], values: &[f64]) -> f64 {
        let own = self.library.own.iter().find(|(p, _)| *p == Parameter::Stiffness);
        let fitted = own.and_then(|(_, column)| columns.iter().position(|c| c == column)).map(|i| values[i]);
        fitted.unwrap_or(self.library.stiffness)
    }

    /// Columns of the richest model that starts with some, added greedily by the smallest residual.
    pub fn richest(&self, start: &[usize], most: usize) -> Vec<usize> {
        let all: Vec<usize> = (1..self.white.len()).collect();
        self.greedy(start, &all, most)
    }

    /// Columns with up to `most` candidates added greedily by the smallest residual, while they improve it.
    pub fn greedy(&self, start: &[usize], candidates: &[usize], most: usize) -> Vec<usize> {
        let mut columns = start.to_vec();
        let Some(mut left) = self.gram.solve(&columns, &[]).map(|v| self.gram.left_total(&columns, &v)) else {
            return columns;
        };
        for _ in 0..most {
            let mut best: Option<(f64, usize)> = None;
            for candidate in candidates.iter().filter(|c| !start.contains(c)) {
                if columns.contains(candidate) {
                    continue;
                }
                columns.push(*candidate);
                if let Some(values) = self.gram.solve(&columns, &[]) {
                    let now = self.gram.left_total(&columns, &values);
                    if best.is_none_or(|(least, _)| now < least) {
                        best = Some((now, *candidate));
                    }
                }
                columns.pop();
            }
            let Some((now, candidate)) = best.filter(|(now, _)| *now < (1.0 - BRINGS) * left) else { break };
            columns.push(candidate);
            left = now;
        }
        columns
    }

    /// Residual of each whitened row.
    pub fn residual(&self, model: &TermModel) -> Vec<f64> {
        let mut left = self.white[0].clone();
        for (column, value) in model.columns.iter().zip(&model.values) {
            left.iter_mut().zip(&self.white[*column]).for_each(|(r, x)| *r -= value * x);
        }
        left
    }
}
