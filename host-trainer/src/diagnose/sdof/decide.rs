//! Selection of causes by cross-validation: none, one, two, seldom three.

use crate::rig::effect::ParameterKey;
use rayon::prelude::*;

use super::{
    table::{Table, TermModel},
    terms::Meaning,
};
use crate::rig::EffectEntry;
use crate::stats::significance::{discoveries, sign_flip};

/// Rate of false discoveries among single causes.
const SIGNIFICANCE_LEVEL: f64 = 0.02;
/// Share of the held-out error that a cause must take away to be worth a word, for each number that it is free to choose.
const WORTH: f64 = 0.005;
/// What a second cause must do: p-value, share of the error, share of what all causes take away.
const SECOND: (f64, f64, f64) = (0.01, 0.04, 0.004);
/// What a third must do.
const THIRD: (f64, f64, f64) = (0.005, 0.3, 0.01);
/// What each column, and each parameter inside a term, must bring to be preferred, as a share of the error.
const CHOICE: f64 = 0.005;
/// Columns without a name that are tried on top of the named causes.
const NAMELESS: usize = 5;

/// Trial of a single cause.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Term of the cause.
    pub term: usize,
    /// Best model; `None` if it is not distinguishable from the rig's unknown parameters, or only the wrong sign fits.
    pub model: Option<TermModel>,
    /// p-value against no cause, by sign flips of blocks, theory (81).
    pub p_value: f64,
}

/// Selected causes with their rivals and p-values.
pub struct Decision {
    /// Model of the rig alone.
    pub nothing: TermModel,
    /// Trials of each cause alone.
    pub singles: Vec<Trial>,
    /// Tried models with as many causes as the chosen one.
    pub rivals: Vec<TermModel>,
    /// Chosen model; without parts if no cause was found.
    pub chosen: TermModel,
    /// p-value of the chosen model against the rig alone.
    pub p_value: f64,
    /// Chosen model with flexible columns in addition.
    pub rich: TermModel,
    /// p-value of the flexible columns against the chosen model.
    pub rich_p_value: f64,
}

impl Decision {
    /// Best variant of each cause, for a finer grid around it.
    pub fn found(&self, table: &Table) -> Vec<EffectEntry> {
        let alone = self.singles.iter().filter_map(|t| t.model.as_ref()).flat_map(|m| &m.parts);
        let parts = self.chosen.parts.iter().chain(alone);
        let mut entries: Vec<EffectEntry> =
            parts.map(|(term, variant)| table.library.terms[*term].variants[*variant].entry.clone()).collect();
        // A sensor's gain and bias are coefficients that the next columns depend on.
        for model in std::iter::once(&self.chosen).chain(self.singles.iter().filter_map(|t| t.model.as_ref())) {
            for (part, (term, _)) in model.parts.iter().enumerate() {
                let coefficient = table.coefficients(model, part)[0];
                let value = match table.library.terms[*term].meaning {
                    Meaning::Gain => 1.0 / (1.0 + coefficient),
                    Meaning::Bias => -coefficient,
                    _ => continue,
                };
                entries.push(EffectEntry::new(table.library.terms[*term].kind, &[(ParameterKey::Value, value)]));
            }
        }
        entries
    }

    /// Decision without causes, for recordings that are explained otherwise.
    pub fn acquitted(mut self) -> Self {
        self.chosen = self.nothing.clone();
        self.rich = self.nothing.clone();
        (self.p_value, self.rich_p_value) = (1.0, 1.0);
        self
    }

    /// Share of the chosen model's held-out error that flexible columns explain.
    pub fn left_to_explain(&self) -> f64 {
        (1.0 - self.rich.total() / self.chosen.total()).max(0.0)
    }

    /// Share of the explainable error that the chosen causes explain.
    pub fn explained(&self) -> f64 {
        let before = self.nothing.total();
        let least = self.rich.total().min(self.chosen.total());
        if before > least { (before - self.chosen.total()) / (before - least) } else { 1.0 }
    }
}

fn gains(before: &TermModel, after: &TermModel, nothing: &TermModel) -> (f64, f64) {
    let (b, a, n) = (before.total(), after.total(), nothing.total());
    (1.0 - a / b, (b - a) / (n - a).max(f64::MIN_POSITIVE))
}

/// The model that leaves least; of near equals the one with less to choose from.
fn least<'a>(table: &Table, models: &'a [TermModel]) -> Option<&'a TermModel> {
    let searched = |m: &TermModel| m.parts.iter().filter(|(t, _)| table.library.terms[*t].variants.len() > 1).count();
    let weighed = |m: &TermModel| m.total() * (1.0 + CHOICE * (m.columns.len() + searched(m)) as f64);
    models.iter().min_by(|a, b| weighed(a).total_cmp(&weighed(b)))
}

/// Selects the causes; `None` if the rig's own parameters cannot be fitted.
pub fn decide(table: &Table, seed: u64) -> Option<Decision> {
    let nothing = table.nothing()?;
    let count = table.library.terms.len();
    let mut singles: Vec<Trial> = (0..count)
        .into_par_iter()
        .map(|term| {
            let model = table.best(&[term], &[]);
            let p_value = model.as_ref().map_or(1.0, |m| sign_flip(&nothing.left, &m.left, seed));
            Trial { term, model, p_value }
        })
        .collect();
    let p_values: Vec<f64> = singles.iter().map(|t| t.p_value).collect();
    let found = discoveries(&p_values, SIGNIFICANCE_LEVEL);
    let worth = |m: &TermModel| {
        let inside = m.parts.iter().filter(|(t, _)| table.library.terms[*t].variants.len() > 1).count();
        let chosen_from = m.columns.len() - nothing.columns.len();
        gains(&nothing, m, &nothing).0 > WORTH * (chosen_from * (1 + inside)) as f64
    };
    let standing: Vec<usize> =
        (0..count).filter(|t| found[*t] && singles[*t].model.as_ref().is_some_and(worth)).collect();
    let ones: Vec<TermModel> = standing.iter().filter_map(|t| singles[*t].model.clone()).collect();
    let mut chosen = least(table, &ones).cloned().unwrap_or_else(|| nothing.clone());
    let mut rivals = ones;
    if !chosen.parts.is_empty() {
        let pairs: Vec<(usize, usize)> = (0..count)
            .flat_map(|a| (a + 1..count).map(move |b| (a, b)))
            .filter(|(a, b)| standing.contains(a) || standing.contains(b))
            .collect();
        let twos: Vec<TermModel> = pairs.par_iter().filter_map(|(a, b)| table.best(&[*a, *b], &[])).collect();
        if let Some(two) = least(table, &twos).filter(|two| passes(&chosen, two, &nothing, SECOND, seed)).cloned() {
            (chosen, rivals) = (two, twos);
            let threes: Vec<TermModel> = (0..count)
                .into_par_iter()
                .filter(|t| chosen.parts.iter().all(|(part, _)| part != t))
                .filter_map(|t| table.best(&[t], &chosen.parts))
                .collect();
            if let Some(three) = least(table, &threes).filter(|m| passes(&chosen, m, &nothing, THIRD, seed)).cloned() {
                (chosen, rivals) = (three, threes);
            }
        }
    }
    let p_value = sign_flip(&nothing.left, &chosen.left, seed);
    let rich = rich(table, &chosen);
    let rich_p_value = sign_flip(&chosen.left, &rich.left, seed);
    // A cause tried alone and beaten is judged by what it is worth beside the chosen ones, too.
    singles.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    Some(Decision { nothing, singles, rivals, chosen, p_value, rich, rich_p_value })
}

fn passes(before: &TermModel, after: &TermModel, nothing: &TermModel, need: (f64, f64, f64), seed: u64) -> bool {
    let (relative, share) = gains(before, after, nothing);
    relative > need.1 && share > need.2 && sign_flip(&before.left, &after.left, seed) < need.0
}

/// The model with columns that have no name on top, as many as improve what is held out.
fn rich(table: &Table, chosen: &TermModel) -> TermModel {
    let mut candidates = table.library.flexible.clone();
    for term in &table.library.terms {
        candidates.extend(term.variants.iter().flat_map(|v| &v.columns));
    }
    let all = table.greedy(&chosen.columns, &candidates, NAMELESS);
    let mut best = chosen.clone();
    for length in chosen.columns.len() + 1..=all.len() {
        let columns = all[..length].to_vec();
        let (Some(values), Some(left)) = (table.gram.solve(&columns, &[]), table.held_out(&columns)) else { continue };
        let model = TermModel { parts: chosen.parts.clone(), columns, values, left };
        if model.total() < best.total() {
            best = model;
        }
    }
    best
}
