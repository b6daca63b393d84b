//! Sparse equations of a fit with their terms' shares, theory (21).

use ballrace_core::library::Term;
use ballrace_core::model::Input;

use super::report::{EquationReport, TermReport};
use super::score;
use super::settings::DescribeSettings;
use super::single_fit::{SingleFit, Split};
use crate::model::samples::Samples;
use crate::model::states::{Scales, concatenate};
use crate::model::stlsq::{Diagnosis, Equation, RFactor, diagnose};

const SETTINGS: DescribeSettings = DescribeSettings::DEFAULT;

/// Equations and conditioning of a fit.
pub struct Described {
    pub equations: Vec<EquationReport>,
    pub diagnosis: Diagnosis,
}

/// Describes the dynamics of a fit.
pub fn describe(once: &SingleFit, split: &Split) -> Described {
    let (layout, library) = (&once.layout, once.layout.library);
    let is_latent = !layout.encoder.widths().is_empty();
    let moments = RFactor::from_samples(library, &latent_rows(once, split));
    let xi = &once.parts.xi;
    let column = |e: usize| -> Vec<f64> { xi.iter().skip(e).step_by(layout.latent).map(|v| f64::from(*v)).collect() };
    let held_out = score::score_model(&once.model.view(), &split.held_out);
    let mut reports = Vec::new();
    let mut equations = Vec::new();
    for e in 0..layout.latent {
        let coefficients = column(e);
        let used: Vec<usize> = (0..coefficients.len()).filter(|t| coefficients[*t] != 0.0).collect();
        let shares = error_reduction_ratios(&moments, &used, &coefficients);
        let mut terms: Vec<TermReport> = used
            .iter()
            .zip(&shares)
            .filter_map(|(t, share)| {
                let term = library.term(*t)?;
                Some(TermReport {
                    name: term.to_string(),
                    index: *t,
                    coefficient: coefficients[*t],
                    physical: (!is_latent).then(|| physical(term, coefficients[*t], &once.parts.scales, e)),
                    share: *share,
                })
            })
            .collect();
        terms.sort_by(|a, b| b.share.total_cmp(&a.share));
        let threshold = match (&once.trained, once.equations.get(e)) {
            (Some(trained), _) => trained.threshold,
            (None, equation) => equation.map_or(0.0, |equation| equation.threshold),
        };
        reports.push(EquationReport {
            name: if is_latent { format!("dz{e}/dt") } else { left_side(once, e) },
            r_squared_held_out: (!is_latent).then(|| held_out.derivatives.get(e).copied()).flatten(),
            threshold,
            terms,
        });
        equations.push(Equation { coefficients, threshold });
    }
    Described { diagnosis: diagnose(&moments, &equations), equations: reports }
}

/// Rows of z for the inner products of the library's columns; z takes the targets' place too, which are not used.
fn latent_rows(once: &SingleFit, split: &Split) -> Samples<f32> {
    let all = concatenate(&once.standardised(&split.train));
    let encoder = once.parts.encoder.view();
    let latent = once.layout.latent;
    let mut hidden = vec![0.0; encoder.forward_scratch_len()];
    let mut z = vec![0.0; latent];
    let mut rows = Samples { inputs: latent, ..Samples::default() };
    let count = all.len().min(SETTINGS.max_rows);
    for i in 0..count {
        let (x, _) = all.row(i * all.len() / count);
        encoder.forward(x, &mut z, &mut hidden);
        rows.x.extend_from_slice(&z);
        rows.dx.extend_from_slice(&z);
    }
    rows
}

/// Share of an equation's explained power that each used term brings, theory (21), by orthogonal least squares (error
/// reduction ratios: Chen, Billings, Luo 1989): the term that explains most comes first, the next explains most of the
/// rest, and so on. Plain products ξ⟨θ ŷ⟩ need uncorrelated terms; the differences of one signal are correlated, and
/// their products then run to thousands of per cent of either sign.
fn error_reduction_ratios(moments: &RFactor, used: &[usize], coefficients: &[f64]) -> Vec<f64> {
    let n = used.len();
    let mut gram: Vec<Vec<f64>> =
        used.iter().map(|a| used.iter().map(|b| moments.term_product(*a, *b)).collect()).collect();
    let weighted = |row: &Vec<f64>| row.iter().zip(used).map(|(g, t)| g * coefficients[*t]).sum::<f64>();
    // ⟨θ ŷ⟩ of the residual of ŷ.
    let mut left: Vec<f64> = gram.iter().map(weighted).collect();
    let total: f64 = left.iter().zip(used).map(|(l, t)| l * coefficients[*t]).sum();
    let floor: Vec<f64> = (0..n).map(|i| SETTINGS.min_pivot_share * gram[i][i]).collect();
    let mut shares = vec![0.0; n];
    let mut open: Vec<usize> = (0..n).collect();
    if total <= 0.0 {
        return shares;
    }
    loop {
        let gain = |i: usize| if gram[i][i] > floor[i] { left[i] * left[i] / gram[i][i] } else { 0.0 };
        let Some(best) = open.iter().copied().max_by(|a, b| gain(*a).total_cmp(&gain(*b))) else { break };
        let gained = gain(best);
        if gained <= 0.0 {
            break;
        }
        shares[best] = gained / total;
        open.retain(|i| *i != best);
        let (column, pivot) = (gram[best].clone(), gram[best][best]);
        let explained = left[best] / pivot;
        for i in &open {
            left[*i] -= column[*i] * explained;
            for j in &open {
                gram[*i][*j] -= column[*i] * column[*j] / pivot;
            }
        }
    }
    shares
}

/// Name of the left side of equation `e`, such as a^(1).
fn left_side(once: &SingleFit, e: usize) -> String {
    match once.parts.input {
        Input::VirtualStates(spec) => format!("a^({})", spec.orders.state(e) + 1),
        Input::Direct(_) => format!("dx{e}/dt"),
    }
}

/// Coefficient of the centred variables' product in physical units, from that of the scaled variables.
fn physical(term: Term, coefficient: f64, scales: &Scales, equation: usize) -> f64 {
    let (mean, scale) = scales.derivatives[equation];
    let in_units = coefficient * f64::from(scale);
    match term {
        Term::Monomial(m) if m.factors().is_empty() => in_units + f64::from(mean),
        Term::Monomial(m) => {
            in_units / m.factors().iter().map(|i| f64::from(scales.states[usize::from(*i)].1)).product::<f64>()
        }
        // Functions of the scaled state itself.
        Term::Sin { .. } | Term::Cos { .. } | Term::Power { .. } | Term::OddPower { .. } => in_units,
    }
}
