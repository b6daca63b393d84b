//! Missing forces as curves of the state, with their bands.

use super::table::{RIDGE, Table, TermModel};
use super::terms::State;
use crate::diagnose::result::Term;
use crate::identify::force_balance::gram::Rows;
use crate::stats::significance::t975;

/// Curves of the terms of a model, free of their names: splines of the state that each depends on, beside the model's other
/// terms. `equations` are those of the named terms.
pub fn terms(table: &Table, model: &TermModel, equations: &[String]) -> Vec<Term> {
    let mut out = Vec::new();
    for (part, (term, _)) in model.parts.iter().enumerate() {
        let term = &table.library.terms[*term];
        let spline = match term.state {
            State::Position => 0,
            State::Velocity => 1,
            State::Acceleration | State::Time | State::Sensor => continue,
        };
        let equation = equations.get(part).cloned().unwrap_or_default();
        if let Some(curve) = curve(table, model, part, spline) {
            let depends_on = term.state.symbol().to_owned();
            out.push(Term { force_on: "q".into(), depends_on, equation, curve, unit: "N".into() });
        }
    }
    out
}

/// Value and 95 % band at each knot; the rig's own parameters and the other terms keep the model's coefficients.
fn curve(table: &Table, model: &TermModel, part: usize, spline: usize) -> Option<Vec<[f64; 4]>> {
    let own = table.library.own.len();
    let kept = |n: &usize| *n != own + part;
    let fixed: Vec<(usize, f64)> =
        (0..own + model.parts.len()).filter(kept).map(|n| (model.columns[n], model.values[n])).collect();
    let knots = &table.library.splines[spline];
    let free: Vec<usize> = knots.iter().map(|(_, column)| *column).collect();
    let values = table.gram.solve(&free, &fixed, Rows::All, RIDGE)?;
    let columns: Vec<usize> = free.iter().copied().chain(fixed.iter().map(|(c, _)| *c)).collect();
    let coefficients: Vec<f64> = values.iter().copied().chain(fixed.iter().map(|(_, v)| *v)).collect();
    let target: Vec<usize> = (0..free.len()).collect();
    let covariance = table.deviations(&columns, &coefficients, &target)?;
    let t = t975(table.blocks.len().saturating_sub(1));
    let point = |(n, (x, _)): (usize, &(f64, usize))| {
        let half = t * covariance[n][n].max(0.0).sqrt();
        [*x, values[n], values[n] - half, values[n] + half]
    };
    Some(knots.iter().enumerate().map(point).collect())
}

/// Curve of the state that explains most of what no name explains, for an unexplained mismatch.
pub fn nameless(table: &Table, model: &TermModel) -> Option<Term> {
    let own = table.library.own.len();
    let bare = TermModel {
        parts: Vec::new(),
        columns: model.columns[..own].to_vec(),
        values: model.values[..own].to_vec(),
        left: Vec::new(),
    };
    let left = |spline: usize| {
        let mut columns: Vec<usize> = table.library.splines[spline].iter().map(|(_, c)| *c).collect();
        columns.extend(&bare.columns);
        let values = table.gram.solve(&columns, &[], Rows::All, RIDGE)?;
        Some(table.gram.left_in(&columns, &values, Rows::All))
    };
    let spline = usize::from(left(1)? < left(0)?);
    let depends_on = [State::Position, State::Velocity][spline].symbol().to_owned();
    let curve = curve(table, &bare, usize::MAX - own, spline)?;
    Some(Term { force_on: "q".into(), depends_on, equation: String::new(), curve, unit: "N".into() })
}
