//! Selection of causes by cross-validation: none, one, two, seldom three.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::blocks;
use super::settings::SdofSettings;
use super::table::{Table, TermModel};
use crate::rig::effect::EffectKind;
use crate::stats::significance::shares;

const SETTINGS: SdofSettings = SdofSettings::DEFAULT;
/// Variants of each term that are tried in pairs.
const PAIRED: usize = 4;

/// Trial of a single cause.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Term of the cause.
    pub term: usize,
    /// Best model; `None` if it is not distinguishable from the rig's unknown parameters, or only the wrong sign fits.
    pub model: Option<TermModel>,
    /// p-value against no cause, by the blocks' gains.
    pub p_value: f64,
}

/// Selected causes with their rivals.
#[derive(Clone, Debug)]
pub struct Selection {
    /// Model of the rig alone.
    pub nothing: TermModel,
    /// Trials of each cause alone.
    pub singles: Vec<Trial>,
    /// Tried models with as many causes as the chosen one, or as it had before some were taken back.
    pub rivals: Vec<TermModel>,
    /// Chosen model; without parts if no cause was found.
    pub chosen: TermModel,
    /// Chosen model with flexible columns in addition.
    pub rich: TermModel,
    /// p-value of the flexible columns against the chosen model.
    pub rich_p_value: f64,
    /// p-value at which a gain is beyond chance, among so many terms.
    pub level: f64,
}

/// p-value of a model against another, by the errors of blocks that neither was fitted to.
pub fn gain_p(before: &TermModel, after: &TermModel) -> f64 {
    blocks::gain_p(&before.left, &after.left)
}

/// Selects causes; `None` if the rig's own parameters cannot be fitted.
pub fn select(table: &Table) -> Option<Selection> {
    let nothing = table.nothing()?;
    let count = table.library.terms.len();
    let level = SETTINGS.significance / count.max(1) as f64;
    let singles: Vec<Trial> = (0..count)
        .into_par_iter()
        .map(|term| {
            let all: Vec<Vec<usize>> = (0..table.library.terms[term].variants.len()).map(|v| vec![v]).collect();
            let model = table.model(&[term], &all);
            let p_value = model.as_ref().map_or(1.0, |m| gain_p(&nothing, m));
            Trial { term, model, p_value }
        })
        .collect();
    let pairs: Vec<(usize, usize)> = (0..count).flat_map(|a| (0..a).map(move |b| (b, a))).collect();
    let ranked: Vec<Vec<usize>> = (0..count).into_par_iter().map(|term| first(table.ranked(term, &[]))).collect();
    let pairs: Vec<TermModel> = pairs
        .into_par_iter()
        .filter_map(|(a, b)| {
            // A term that alone has the wrong sign may have the right one beside another.
            let all = |term: usize, beside: usize| {
                let best = ranked[beside].first().copied().unwrap_or(0);
                let mut variants = ranked[term].clone();
                variants.extend(first(table.ranked(term, &[(beside, best)])));
                variants.sort_unstable();
                variants.dedup();
                variants
            };
            let (of_a, of_b) = (all(a, b), all(b, a));
            let combinations: Vec<Vec<usize>> =
                of_a.iter().flat_map(|x| of_b.iter().map(move |y| vec![*x, *y])).collect();
            (!combinations.is_empty()).then(|| table.model(&[a, b], &combinations)).flatten()
        })
        .collect();
    let alone: Vec<TermModel> = singles.iter().filter_map(|t| t.model.clone()).collect();
    let least = |models: &[TermModel]| models.iter().min_by(|a, b| a.total().total_cmp(&b.total())).cloned();
    let (mut chosen, mut rivals) = (nothing.clone(), Vec::new());
    let single = least(&alone).filter(|m| {
        let share = 1.0 - m.total() / nothing.total();
        share > SETTINGS.worth && gain_p(&nothing, m) < level
    });
    if let Some(single) = single {
        (chosen, rivals) = (single, alone.clone());
    }
    let pair = least(&pairs).filter(|m| {
        let share = 1.0 - m.total() / nothing.total();
        share > SETTINGS.worth && gain_p(&nothing, m) < level && adds(&nothing, &chosen, m, level)
    });
    if let Some(pair) = pair.filter(|pair| each_is_needed(&nothing, pair, &alone, level)) {
        (chosen, rivals) = (pair, pairs.clone());
        let mut beam = pairs;
        while chosen.parts.len() < SETTINGS.max_causes {
            beam.sort_by(|a, b| a.total().total_cmp(&b.total()));
            beam.truncate(SETTINGS.widened);
            let mut wider: Vec<TermModel> = beam
                .par_iter()
                .flat_map_iter(|narrow| (0..count).filter_map(move |term| with_one_more(table, narrow, term)))
                .collect();
            let mut met = BTreeSet::new();
            wider.retain(|model| met.insert(model.terms().into_iter().collect::<BTreeSet<usize>>()));
            let Some(best) = least(&wider).filter(|m| adds(&nothing, &chosen, m, level)) else { break };
            (chosen, rivals) = (best, wider);
            beam = rivals.clone();
        }
    }
    if let Some(constant) = without_step(table, &chosen, level) {
        chosen = constant;
        rivals.retain(|m| m.terms().iter().all(|t| table.library.terms[*t].kind != EffectKind::LoadStep));
    }
    if let Some(powers) = without_saturation(table, &chosen, level) {
        chosen = powers;
    }
    let rich = table.flexible(&chosen);
    let rich_p_value = gain_p(&chosen, &rich);
    Some(Selection { nothing, singles, rivals, chosen, rich, rich_p_value, level })
}

fn first(mut variants: Vec<usize>) -> Vec<usize> {
    variants.truncate(PAIRED);
    variants
}

/// The model with a constant force in place of a load's step that is not better beyond chance: dry friction holds either until the
/// machine moves.
fn without_step(table: &Table, chosen: &TermModel, level: f64) -> Option<TermModel> {
    let term = |kind: EffectKind| table.library.terms.iter().position(|t| t.kind == kind);
    let (step, constant) = (term(EffectKind::LoadStep)?, term(EffectKind::ConstantForce)?);
    let terms = chosen.terms();
    if !terms.contains(&step) || terms.contains(&constant) {
        return None;
    }
    let parts = chosen.parts.iter().map(|(t, v)| if *t == step { (constant, 0) } else { (*t, *v) });
    let (terms, variants): (Vec<usize>, Vec<usize>) = parts.unzip();
    table.model(&terms, &[variants]).filter(|model| gain_p(model, chosen) > level)
}

/// The model with springs of a power law in place of those that saturate, if that is not worse beyond chance.
fn without_saturation(table: &Table, chosen: &TermModel, level: f64) -> Option<TermModel> {
    let is_saturating = |(term, variant): &(usize, usize)| table.library.terms[*term].variants[*variant].saturates();
    if !chosen.parts.iter().any(is_saturating) {
        return None;
    }
    // The first variant of a spring is of a power law.
    let parts = chosen.parts.iter().map(|part| if is_saturating(part) { (part.0, 0) } else { *part });
    let (terms, variants): (Vec<usize>, Vec<usize>) = parts.unzip();
    table.model(&terms, &[variants]).filter(|model| gain_p(model, chosen) > level)
}

/// Whether a wider model is better beyond chance and by enough.
fn adds(nothing: &TermModel, narrow: &TermModel, wide: &TermModel, level: f64) -> bool {
    let gain = narrow.total() - wide.total();
    let explained = nothing.total() - wide.total();
    gain > SETTINGS.worth_further * explained && gain > SETTINGS.worth * narrow.total() && gain_p(narrow, wide) < level
}

/// Whether neither part of a pair does all that the pair does.
fn each_is_needed(nothing: &TermModel, pair: &TermModel, alone: &[TermModel], level: f64) -> bool {
    alone.iter().filter(|m| pair.terms().contains(&m.parts[0].0)).all(|m| adds(nothing, m, pair, level))
}

fn with_one_more(table: &Table, chosen: &TermModel, term: usize) -> Option<TermModel> {
    if chosen.terms().contains(&term) {
        return None;
    }
    let mut terms = chosen.terms();
    terms.push(term);
    let before: Vec<usize> = chosen.parts.iter().map(|(_, v)| *v).collect();
    let variants = first(table.ranked(term, &chosen.parts));
    let combinations: Vec<Vec<usize>> =
        variants.into_iter().map(|v| before.iter().copied().chain([v]).collect()).collect();
    (!combinations.is_empty()).then(|| table.model(&terms, &combinations)).flatten()
}

impl Selection {
    /// Least held-out error of any model.
    pub fn attainable(&self) -> f64 {
        self.rich.total().min(self.chosen.total())
    }

    /// Share of what any model explains that the chosen one explains.
    pub fn explained(&self) -> f64 {
        let (most, own) = (self.nothing.total() - self.attainable(), self.nothing.total() - self.chosen.total());
        if most > 0.0 { (own / most).clamp(0.0, 1.0) } else { 1.0 }
    }

    /// Probability of a term: how often a model with it is the best of its rivals when blocks are drawn again.
    pub fn probability(&self, table: &Table, term: usize, seed: u64) -> f64 {
        let models: Vec<&[f64]> = self.rivals.iter().map(|m| m.left.as_slice()).collect();
        let kind = table.library.terms[term].kind;
        let has = |m: &TermModel| m.parts.iter().any(|(t, _)| table.library.terms[*t].kind == kind);
        let share: f64 =
            self.rivals.iter().zip(shares(&models, seed)).filter(|(m, _)| has(m)).map(|(_, share)| share).sum();
        // With few blocks a bootstrap is too sure of itself; what no name explains could be a rival too.
        let blocks = self.nothing.left.len() as f64;
        let few = blocks / (blocks + 2.0);
        (share * few * self.explained().sqrt()).min(SETTINGS.most_probability)
    }
}
