//! Sentences of a diagnosis of the rig of one degree of freedom.

use super::{
    causes::Cause,
    decide::Decision,
    finding::{Rejected, ResidualTest},
    table::{Table, TermModel},
};
use crate::identify::force_balance::states::States;
use crate::rig::Rig;
use crate::rig::config::RigKind;
use crate::rig::effect::EffectKind;
use crate::stats::significance::{paired_z, sign_flip};

/// Equation of an effect of a rig.
pub fn equation(rig: &Rig, index: usize) -> String {
    rig.effects.get(index).map_or_else(String::new, |effect| effect.equation(RigKind::Sdof))
}

/// Evidence for the cause of this index in the selected model, as checkable numbers.
pub fn evidence(table: &Table, decision: &Decision, index: usize, name: EffectKind, states: &States) -> String {
    let (chosen, nothing) = (&decision.chosen, &decision.nothing);
    let (term, _) = chosen.parts[index];
    let share = |after: f64, before: f64| 100.0 * (1.0 - after / before);
    let alone = decision.singles.iter().find(|t| t.term == term);
    let alone = alone.and_then(|t| t.model.as_ref().map(|m| (share(m.total(), nothing.total()), t.p_value)));
    let others: Vec<usize> = chosen.parts.iter().map(|(t, _)| *t).filter(|t| *t != term).collect();
    let cutoff = states.cutoff_hz();
    let together = share(chosen.total(), nothing.total());
    let alone = match alone {
        Some((alone, p)) if alone > 0.0 => {
            format!(
                "alone it explains {alone:.1} % of the held-out force-balance residual below {cutoff:.0} Hz (p = {p:.4})"
            )
        }
        _ => format!("alone it explains nothing of the held-out force-balance residual below {cutoff:.0} Hz"),
    };
    if others.is_empty() {
        return format!("{name}: {alone}, more than any other single cause");
    }
    let names: Vec<&str> = others.iter().map(|t| table.library.terms[*t].kind.name()).collect();
    format!("{name}: {alone}, together with {} {together:.1} %", names.join(" and "))
}

/// Rejected causes with reasons.
pub fn rejected(table: &Table, decision: &Decision, causes: &[Cause]) -> Vec<Rejected> {
    let (nothing, chosen) = (decision.nothing.total(), &decision.chosen);
    let stands = |term: usize| causes.iter().any(|c| c.term == term);
    let why = |trial: &super::decide::Trial| {
        let Some(model) = &trial.model else {
            return "fits only with the wrong sign, or is not distinguishable from the rig's unknown parameters"
                .to_owned();
        };
        let alone = 100.0 * (1.0 - model.total() / nothing);
        if alone <= 0.0 || trial.p_value > 0.02 {
            return format!("no significant gain on held-out rows (p = {:.3})", trial.p_value);
        }
        let together = 100.0 * (1.0 - chosen.total() / nothing);
        format!("alone it explains {alone:.1} % of the held-out residual, the selected causes {together:.1} %")
    };
    let singles = decision.singles.iter().filter(|t| !stands(t.term));
    singles.map(|t| Rejected { name: table.library.terms[t.term].kind.to_string(), why: why(t) }).collect()
}

/// Tests of the residual of the rig without causes, the most significant first.
pub fn tests(table: &Table, decision: &Decision, seed: u64) -> Vec<ResidualTest> {
    let nothing = &decision.nothing.left;
    let test = |what: String, model: &TermModel| {
        let p_value = sign_flip(nothing, &model.left, seed);
        ResidualTest { what, z: paired_z(nothing, &model.left), p_value }
    };
    let singles = decision.singles.iter().filter_map(|trial| {
        let name = table.library.terms[trial.term].kind;
        Some(test(format!("force of {name}"), trial.model.as_ref()?))
    });
    let any = test("any force of position, speed and time".into(), &decision.rich);
    let mut tests: Vec<ResidualTest> = std::iter::once(any).chain(singles).collect();
    tests.sort_by(|a, b| a.p_value.total_cmp(&b.p_value).then(b.z.total_cmp(&a.z)));
    tests
}

/// Scheme of cross-validation in words.
pub fn held_out(states: &States) -> String {
    let names: Vec<&str> = states.tracks.iter().map(|t| t.name.as_str()).collect();
    if names.len() >= 4 {
        format!("recordings in turn, four folds: {}", names.join(", "))
    } else {
        format!("blocks in turn, four folds: {}", names.join(", "))
    }
}
