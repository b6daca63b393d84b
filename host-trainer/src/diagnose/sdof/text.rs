//! Sentences of a diagnosis of the rig of one degree of freedom.

use super::causes::Cause;
use super::repeating::{Repeating, Repeats};
use super::select::{Selection, Trial};
use super::settings::SdofSettings;
use super::table::{Table, TermModel};
use super::verdict::{Case, Judged};
use crate::diagnose::result::{Rejected, Verdict};
use crate::rig::config::Restoring;
use crate::rig::effect::EffectKind;
use crate::stats::units::in_words;

const SETTINGS: SdofSettings = SdofSettings::DEFAULT;

/// Evidence for a cause, as checkable numbers.
pub fn evidence(table: &Table, selection: &Selection, cause: &Cause, judged: &Judged) -> String {
    let name = cause.entry.kind;
    let share = |model: &TermModel| 100.0 * (1.0 - model.total() / selection.nothing.total());
    let alone = selection.singles.iter().find(|t| t.term == cause.term).and_then(|t| t.model.as_ref());
    let alone = match alone.map(share) {
        Some(alone) if alone > 0.0 => {
            format!("alone it explains {alone:.1} % of the held-out one-step prediction error")
        }
        _ => "alone it explains nothing of the held-out one-step prediction error".into(),
    };
    let others: Vec<&str> = selection
        .chosen
        .terms()
        .into_iter()
        .filter(|t| *t != cause.term)
        .map(|t| table.library.terms[t].kind.name())
        .collect();
    let fit = &judged.comparison;
    let simulated = format!(
        "; simulations of held-out windows err by {:.3} of what they did",
        if fit.before > 0.0 { fit.after / fit.before } else { 1.0 }
    );
    if others.is_empty() {
        return format!("{name}: {alone}, more than any other single cause{simulated}");
    }
    format!("{name}: {alone}, together with {} {:.1} %{simulated}", others.join(" and "), share(&selection.chosen))
}

/// Rejected causes with reasons.
pub fn rejected(table: &Table, judged: &Judged) -> Vec<Rejected> {
    let selection = &judged.selection;
    let (nothing, chosen) = (selection.nothing.total(), selection.chosen.total());
    let stands: Vec<usize> = judged.causes.iter().map(|c| c.term).collect();
    let why = |trial: &Trial| {
        let Some(model) = &trial.model else {
            return "fits only with the wrong sign, or is not distinguishable from the rig's unknown parameters"
                .to_owned();
        };
        let alone = 100.0 * (1.0 - model.total() / nothing);
        if alone <= 0.0 || trial.p_value > SETTINGS.significance {
            return format!("no significant gain on held-out rows (p = {:.3})", trial.p_value);
        }
        let together = 100.0 * (1.0 - chosen / nothing);
        if stands.is_empty() {
            return format!(
                "alone it explains {alone:.1} % of the held-out error of prediction, which the gate of held-out \
                 simulations, or its share of what is explainable, does not bear out"
            );
        }
        format!(
            "alone it explains {alone:.1} % of the held-out error of prediction, the selected causes {together:.1} %"
        )
    };
    let singles = selection.singles.iter().filter(|t| !stands.contains(&t.term));
    singles.map(|t| Rejected { name: table.library.terms[t.term].kind.to_string(), why: why(t) }).collect()
}

/// What repeats, and how often.
pub fn repeating(found: &Repeating, restoring: Restoring) -> String {
    let (what, key) = match found.what {
        Repeats::Force => ("a force in time that is not the input", "frequency_hz"),
        Repeats::Stiffness => ("a stiffness that swings in time", "frequency_hz"),
        Repeats::Damping => ("a damping that swings in time", "frequency_hz"),
        Repeats::AlongPosition if restoring == Restoring::Pendulum => ("a force along the angle", "pitch_rad"),
        Repeats::AlongPosition => ("a force along the position", "pitch_m"),
    };
    format!("{what}, {}", in_words(key, found.often, None))
}

/// Caveats, a sentence each.
pub fn caveats(case: &Case, judged: &Judged) -> Vec<String> {
    let mut out = case.acquired.notes.clone();
    out.extend(case.nominal.notes.clone());
    out.extend(case.nominal.adjustments());
    out.extend(case.acquired.taken_off());
    let explained = judged.selection.explained();
    if judged.verdict == Verdict::Mismatch && !judged.causes.is_empty() && explained < 0.95 {
        out.push(format!(
            "The causes explain {:.0} % of what a model without names explains; the rest is another form of the same force, or \
             outside the vocabulary.",
            100.0 * explained
        ));
    }
    if let Some(found) = judged.repeating {
        let what = repeating(&found, case.nominal.machine.restoring);
        out.push(format!("Of the forces that are left {:.0} % repeat: {what}.", 100.0 * found.share));
    }
    let unknown: Vec<&str> = case.nominal.unknown.iter().map(|p| p.key().name()).collect();
    if !unknown.is_empty() && case.task.baseline.is_none() {
        out.push(format!(
            "Unknown, and so fitted to these recordings: {}. A change of these parameters would show only in comparison with \
             recordings of the healthy machine (--baseline).",
            unknown.join(", ")
        ));
    }
    for fault in judged.faults.iter().filter(|f| !f.lasts()) {
        out.push(format!(
            "{} is a single event: it is not in the corrected rig, and has no replicate to be tested on.",
            fault.entry.kind
        ));
    }
    if judged.faults.iter().any(|f| f.entry.kind == EffectKind::MainsInterference) {
        out.push("The phase of the mains interference was fitted to each held-out recording itself.".into());
    }
    if judged.one_step_ahead {
        out.push("The mass is too small to show; held-out curves are predictions one sample ahead.".into());
    } else if judged.stretches.is_empty() {
        out.push("The rig could not be simulated over these recordings; there are no held-out curves.".into());
    } else {
        out.push(
            "Held-out curves are simulations of windows, each from the start of the smallest residual in it.".into(),
        );
    }
    out
}
