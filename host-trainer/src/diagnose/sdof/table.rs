//! Inner products of all columns, and cross-validated models of them.

use super::library::Library;
use super::nominal::Nominal;
use super::settings::SdofSettings;
use super::terms::{Meaning, Term};
use crate::identify::force_balance::equation::Parameter;
use crate::identify::force_balance::gram::{Gram, Rows};
use crate::rig::config::SdofRig;

const SETTINGS: SdofSettings = SdofSettings::DEFAULT;

/// Columns of all hypotheses with their cross-validation.
pub struct Table {
    /// Columns with their meaning.
    pub library: Library,
    /// Inner products, block by block.
    pub gram: Gram,
    /// Blocks of the recordings under test.
    pub under_test: Vec<usize>,
    /// First row, end and recording of each block.
    pub blocks: Vec<(usize, usize, usize)>,
    fold: Vec<usize>,
}

/// Model of one or more terms with their best nonlinear parameters.
#[derive(Clone, Debug)]
pub struct TermModel {
    /// Term and variant of each part.
    pub parts: Vec<(usize, usize)>,
    /// Columns: the rig's own first, then one of each part, then flexible ones.
    pub columns: Vec<usize>,
    /// Coefficients of the columns, from all rows.
    pub values: Vec<f64>,
    /// Squared residual of each block under test, everything chosen and fitted on the other folds.
    pub left: Vec<f64>,
}

impl TermModel {
    /// Sum of the squared residuals over the blocks.
    pub fn total(&self) -> f64 {
        self.left.iter().sum()
    }

    /// Terms of the model.
    pub fn terms(&self) -> Vec<usize> {
        self.parts.iter().map(|(term, _)| *term).collect()
    }
}

impl Table {
    /// Table of a library; `healthy` recordings are fitted to and never tested.
    pub fn new(library: Library, healthy: &[bool]) -> Self {
        let tested: usize = library.rows.iter().zip(healthy).filter(|(_, h)| !**h).map(|(r, _)| r).sum();
        let questioned = healthy.iter().filter(|h| !**h).count().max(1);
        let length = (tested / SETTINGS.blocks).max(SETTINGS.min_block).max(1);
        let (mut blocks, mut fold, mut under_test) = (Vec::new(), Vec::new(), Vec::new());
        let (mut start, mut number, mut seen) = (0, 0, 0);
        for (track, (rows, healthy)) in library.rows.iter().zip(healthy).enumerate() {
            let count = (rows / length).max(usize::from(*rows > 0));
            for block in 0..count {
                blocks.push((start + block * rows / count, start + (block + 1) * rows / count, track));
                let place = (seen + block * rows / count) as f64 / tested.max(1) as f64;
                let in_turn = in_turn(questioned, number, place);
                if !*healthy {
                    under_test.push(fold.len());
                }
                fold.push(if *healthy { SETTINGS.folds } else { in_turn });
            }
            if !*healthy {
                number += 1;
                seen += rows;
            }
            start += rows;
        }
        let ends: Vec<usize> = blocks.iter().map(|(_, end, _)| *end).collect();
        let gram = Gram::new(&library.columns, &ends, &fold, SETTINGS.folds);
        Self { library, gram, under_test, blocks, fold }
    }

    /// Machine with the rig's own parameters as a model has them.
    pub fn machine(&self, nominal: &Nominal, model: &TermModel) -> SdofRig {
        let mut nominal = nominal.clone();
        for ((parameter, ..), value) in self.library.own.iter().zip(&model.values) {
            nominal.add(*parameter, *value);
        }
        nominal.machine
    }

    /// Model of the rig alone, its unknown parameters fitted.
    pub fn nothing(&self) -> Option<TermModel> {
        self.model(&[], &[vec![]])
    }

    /// Model of terms with the best of some combinations of variants; each fold chooses its own. `None` if none has the
    /// right signs, or the columns are linearly dependent.
    pub fn model(&self, terms: &[usize], combinations: &[Vec<usize>]) -> Option<TermModel> {
        let parts = |variants: &Vec<usize>| -> Vec<(usize, usize)> {
            terms.iter().copied().zip(variants.iter().copied()).collect()
        };
        let best = |rows: Rows| {
            let fits = combinations.iter().filter_map(|c| {
                let parts = parts(c);
                let (columns, values) = self.fit(&parts, rows)?;
                Some((self.gram.left_in(&columns, &values, rows), parts, columns, values))
            });
            fits.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let (_, parts, columns, values) = best(Rows::All)?;
        let mut left = vec![0.0; self.fold.len()];
        for number in 0..SETTINGS.folds {
            let test: Vec<usize> = (0..self.fold.len()).filter(|b| self.fold[*b] == number).collect();
            if test.is_empty() {
                continue;
            }
            let (_, _, columns, values) = best(Rows::Without(number))?;
            test.iter().for_each(|b| left[*b] = self.gram.left(&columns, &values, *b));
        }
        let left = self.under_test.iter().map(|b| left[*b]).collect();
        Some(TermModel { parts, columns, values, left })
    }

    /// Coefficients of a model fitted without each fold.
    pub fn without_folds(&self, model: &TermModel) -> Vec<TermModel> {
        let one = |number: usize| match self.fit(&model.parts, Rows::Without(number)) {
            Some((columns, values)) => TermModel { columns, values, ..model.clone() },
            None => model.clone(),
        };
        (0..SETTINGS.folds).map(one).collect()
    }

    /// Error of the one-step prediction of each row, in the sensor's unit, by the model fitted without the row's fold.
    pub fn step_errors(&self, model: &TermModel) -> Vec<f64> {
        let mut errors = vec![0.0; self.library.deviations.len()];
        for (number, fitted) in self.without_folds(model).iter().enumerate() {
            let residual = self.residual(fitted);
            for ((start, end, _), fold) in self.blocks.iter().zip(&self.fold) {
                if *fold == number {
                    (*start..*end).for_each(|row| errors[row] = residual[row] * self.library.deviations[row]);
                }
            }
        }
        errors
    }

    /// Half the width of each coefficient's 95 % interval, by the scatter of the blocks' scores.
    pub fn half_widths(&self, model: &TermModel) -> Option<Vec<f64>> {
        let all: Vec<usize> = (0..model.columns.len()).collect();
        let covariance = self.deviations(&model.columns, &model.values, &all)?;
        let t = crate::stats::significance::t975(self.blocks.len().saturating_sub(1));
        Some(all.iter().map(|i| t * covariance[*i][*i].max(0.0).sqrt()).collect())
    }

    /// Least squares with the rig's parameters within their domain; `None` where a term has the wrong sign.
    fn fit(&self, parts: &[(usize, usize)], rows: Rows) -> Option<(Vec<usize>, Vec<f64>)> {
        let own: Vec<usize> = self.library.own.iter().map(|(_, column, _)| *column).collect();
        let named: Vec<usize> = parts.iter().map(|(t, v)| self.library.terms[*t].variants[*v].column).collect();
        let mut fixed: Vec<(usize, f64)> = Vec::new();
        loop {
            let free: Vec<usize> =
                own.iter().chain(&named).copied().filter(|c| fixed.iter().all(|(f, _)| f != c)).collect();
            let values = self.gram.solve(&free, &fixed, rows, 0.0)?;
            let below = |(_, column, least): &&(_, usize, f64)| {
                free.iter().position(|c| c == column).is_some_and(|i| values[i] < *least)
            };
            if let Some((_, column, least)) = self.library.own.iter().find(below) {
                fixed.push((*column, *least));
                continue;
            }
            let at = |column: &usize| {
                let free = free.iter().position(|c| c == column).map(|i| values[i]);
                free.or_else(|| fixed.iter().find(|(f, _)| f == column).map(|(_, v)| *v)).unwrap_or_default()
            };
            let fitted = parts.iter().zip(&named).map(|((t, _), column)| (&self.library.terms[*t], at(column)));
            if !signs_hold(&fitted.collect::<Vec<_>>()) {
                return None;
            }
            let columns: Vec<usize> = own.iter().chain(&named).copied().collect();
            let values = columns.iter().map(at).collect();
            return Some((columns, values));
        }
    }

    /// Model with flexible columns on top of another, chosen greedily by each fold for itself.
    pub fn flexible(&self, base: &TermModel) -> TermModel {
        self.flexible_of(base, SETTINGS.flexible_columns)
    }

    /// The same with at most so many columns.
    pub fn flexible_of(&self, base: &TermModel, most: usize) -> TermModel {
        let (columns, values) = self.greedy(base, most, Rows::All);
        let mut left = vec![0.0; self.fold.len()];
        for number in 0..SETTINGS.folds {
            let (columns, values) = self.greedy(base, most, Rows::Without(number));
            let test = (0..self.fold.len()).filter(|b| self.fold[*b] == number);
            test.for_each(|b| left[b] = self.gram.left(&columns, &values, b));
        }
        let left = self.under_test.iter().map(|b| left[*b]).collect();
        TermModel { parts: base.parts.clone(), columns, values, left }
    }

    fn greedy(&self, base: &TermModel, most: usize, rows: Rows) -> (Vec<usize>, Vec<f64>) {
        let mut columns = base.columns.clone();
        let mut values = self.gram.solve(&columns, &[], rows, RIDGE).unwrap_or_else(|| vec![0.0; columns.len()]);
        let mut left = self.gram.left_in(&columns, &values, rows);
        for _ in 0..most {
            let mut best: Option<(f64, usize, Vec<f64>)> = None;
            for candidate in self.library.flexible.iter().filter(|c| !columns.contains(c)) {
                let mut wider = columns.clone();
                wider.push(*candidate);
                let Some(found) = self.gram.solve(&wider, &[], rows, RIDGE) else { continue };
                let now = self.gram.left_in(&wider, &found, rows);
                if best.as_ref().is_none_or(|(least, ..)| now < *least) {
                    best = Some((now, *candidate, found));
                }
            }
            let worth = (1.0 - SETTINGS.flexible_worth) * left;
            let Some((now, candidate, found)) = best.filter(|(now, ..)| *now < worth) else { break };
            columns.push(candidate);
            (left, values) = (now, found);
        }
        (columns, values)
    }

    /// Variants of a term in the order of their residual beside some parts; those with the wrong sign are left out.
    pub fn ranked(&self, term: usize, beside: &[(usize, usize)]) -> Vec<usize> {
        let fits = (0..self.library.terms[term].variants.len()).filter_map(|variant| {
            let parts: Vec<(usize, usize)> = beside.iter().copied().chain([(term, variant)]).collect();
            let (columns, values) = self.fit(&parts, Rows::All)?;
            Some((self.gram.left_in(&columns, &values, Rows::All), variant))
        });
        let mut fits: Vec<(f64, usize)> = fits.collect();
        fits.sort_by(|a, b| a.0.total_cmp(&b.0));
        fits.into_iter().map(|(_, variant)| variant).collect()
    }

    /// Residual of each row.
    pub fn residual(&self, model: &TermModel) -> Vec<f64> {
        let mut left = self.library.columns[0].clone();
        for (column, value) in model.columns.iter().zip(&model.values) {
            left.iter_mut().zip(&self.library.columns[*column]).for_each(|(r, x)| *r -= value * x);
        }
        left
    }

    /// Standard deviation of each coefficient of a model by the scatter of the blocks' scores (H. White, Econometrica 48
    /// (1980) 817–838; L. P. Hansen, Econometrica 50 (1982) 1029–1054), which holds for a model that is not quite true.
    pub fn deviations(&self, columns: &[usize], values: &[f64], target: &[usize]) -> Option<Vec<Vec<f64>>> {
        let p = columns.len();
        let normal: Vec<Vec<f64>> =
            (0..p).map(|i| (0..=i).map(|j| self.gram.product(columns[i], columns[j])).collect()).collect();
        let inverse: Option<Vec<Vec<f64>>> = (0..p)
            .map(|i| {
                let unit: Vec<f64> = (0..p).map(|j| f64::from(u8::from(i == j))).collect();
                crate::identify::force_balance::gram::cholesky_solve(&mut normal.clone(), &unit, RIDGE)
            })
            .collect();
        let inverse = inverse?;
        let mut covariance = vec![vec![0.0; p]; p];
        let count = self.blocks.len() as f64;
        for block in 0..self.blocks.len() {
            let score = self.gram.score(columns, values, block);
            let step: Vec<f64> = (0..p).map(|i| (0..p).map(|j| inverse[i][j] * score[j]).sum()).collect();
            (0..p).for_each(|i| {
                (0..p).for_each(|j| covariance[i][j] += step[i] * step[j] * count / (count - 1.0).max(1.0))
            });
        }
        Some(target.iter().map(|i| target.iter().map(|j| covariance[*i][*j]).collect()).collect())
    }
}

/// Whether the coefficients of terms are in their ranges. A play is of the spring as it is, with a change of its stiffness.
fn signs_hold(fitted: &[(&Term, f64)]) -> bool {
    let is_of_spring = |(term, _): &&(&Term, f64)| term.meaning == Meaning::Change(Parameter::Stiffness);
    let stiffer = fitted.iter().find(is_of_spring).map_or(0.0, |(_, change)| *change);
    fitted.iter().all(|(term, value)| match term.meaning {
        Meaning::Spring(stated) => term.sign.holds(value * stated / (stated + stiffer)),
        _ => term.sign.holds(*value),
    })
}

/// Fold of a place: of the recording, where there are as many as folds, else of the block of time, whose place is a share of
/// all recordings one after the other.
pub fn in_turn(recordings: usize, recording: usize, place: f64) -> usize {
    let number = if recordings >= SETTINGS.folds { recording } else { (place * (2 * SETTINGS.folds) as f64) as usize };
    number % SETTINGS.folds
}

/// Relative ridge for flexible columns, which are nearly dependent.
pub const RIDGE: f64 = 1e-8;
