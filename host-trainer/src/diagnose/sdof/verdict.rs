//! The gate that every cause passes, and the verdict.

use super::acquire::Acquired;
use super::causes::{self, Cause};
use super::faults::Fault;
use super::nominal::Nominal;
use super::repeating::{self, Repeating};
use super::select::{Selection, gain_p};
use super::settings::SdofSettings;
use super::table::{Table, TermModel};
use super::validate::{self, Comparison, SimulatedFit, Windows};
use crate::diagnose::Task;
use crate::diagnose::result::Verdict;
use crate::rig::Rig;
use crate::rig::config::RigKey;
use crate::rig::effect::EffectKind;

const SETTINGS: SdofSettings = SdofSettings::DEFAULT;

/// Effects with a number that places them, of which the regression has a grid only.
const PLACED: [EffectKind; 3] = [EffectKind::EndStopContact, EffectKind::Backlash, EffectKind::StructuralResonance];

/// Inputs of a verdict.
pub struct Case<'a> {
    /// Rig and recordings.
    pub task: &'a Task<'a>,
    /// The rig with its unknown parameters.
    pub nominal: &'a Nominal,
    /// Recordings, faults marked or taken off.
    pub acquired: &'a Acquired,
    /// Recordings before that.
    pub original: &'a Acquired,
    /// Columns.
    pub table: &'a Table,
}

/// What stands.
pub struct Judged {
    /// Verdict.
    pub verdict: Verdict,
    /// Selection behind it.
    pub selection: Selection,
    /// What repeats in what the selection leaves.
    pub repeating: Option<Repeating>,
    /// Causes that stand, as fitted by the regression.
    pub causes: Vec<Cause>,
    /// Faults that stand.
    pub faults: Vec<Fault>,
    /// The rig without causes, by simulation; `None` if it diverges.
    pub before: Option<SimulatedFit>,
    /// The rig with causes, by simulation.
    pub after: Option<SimulatedFit>,
    /// Held-out errors.
    pub comparison: Comparison,
    /// Windows of the simulation.
    pub windows: Windows,
    /// Held-out stretches: measured, before, after.
    pub stretches: Vec<Stretch>,
    /// Whether they are predictions one sample ahead, not simulations.
    pub one_step_ahead: bool,
}

/// A window as measured and as simulated.
#[derive(Clone, Debug)]
pub struct Stretch {
    /// Recording, as the caller counts them.
    pub origin: usize,
    /// Measured samples.
    pub measured: Vec<f64>,
    /// Simulated without the causes.
    pub before: Vec<f64>,
    /// Simulated with them.
    pub after: Vec<f64>,
}

impl Case<'_> {
    /// Judges a selection.
    pub fn judge(&self, mut selection: Selection, faults: Vec<Fault>) -> Judged {
        let (plain, plain_keys) = validate::with_causes(&self.rig(&selection.nothing), &[], self.free());
        loop {
            let causes = causes::causes(self.table, &selection.chosen, &self.machine(&selection.chosen), self.acquired);
            let (rig, keys) = validate::with_causes(&self.rig(&selection.chosen), &causes, self.free());
            // A place within a term is fitted by simulation only.
            let placed = causes.iter().any(|c| PLACED.contains(&c.entry.kind));
            let overdamped = self.nominal.is_overdamped(self.acquired);
            let (disturbed, shortest) = if overdamped {
                (true, Windows::new(self.acquired, 1))
            } else {
                validate::is_disturbed(&rig, self.acquired)
            };
            let regressed = overdamped || (disturbed && !placed);
            let (windows, before, after) = if regressed {
                let by = |model: &TermModel| self.by_regression(model, &shortest);
                let (before, after) = (by(&selection.nothing), by(&selection.chosen));
                (shortest, before, after)
            } else {
                let (windows, rig) = validate::longest_windows(&rig, &keys, self.acquired);
                let before = validate::fit(&plain, &plain_keys, self.acquired, &windows);
                let after = validate::fit(&rig, &keys, self.acquired, &windows);
                (windows, before, after)
            };
            let compared = if overdamped {
                Some(self.one_step_ahead(&selection, faults.clone()))
            } else {
                self.compare(before.as_ref(), after.as_ref().or(before.as_ref()), &windows, &faults)
            };
            let Some((comparison, faults, stretches)) = compared else {
                if causes.is_empty() {
                    return self.unsimulated(selection, faults, windows);
                }
                selection = self.narrower(selection);
                continue;
            };
            let taken = 1.0 - (comparison.after / comparison.before).powi(2);
            let (all, mode) = SETTINGS.takes_away;
            let is_mode = |c: &Cause| c.entry.kind == EffectKind::StructuralResonance;
            let least = if causes.iter().any(is_mode) { mode } else { all };
            // A mode shapes itself to whatever little is left.
            let little = SETTINGS.tolerance * self.acquired.spread();
            let idle_mode = causes.iter().any(is_mode) && before.as_ref().is_some_and(|b| b.rms < little);
            let improved = comparison.p_value < SETTINGS.significance && taken > least && !idle_mode;
            if !causes.is_empty() && !improved {
                selection = self.narrower(selection);
                continue;
            }
            if causes.len() > 1
                && let (Some(before), Some(after)) = (&before, &after)
                && let Some(fewer) = self.without_idle(&selection, [before.rms, after.rms], &windows, regressed)
            {
                selection = fewer;
                continue;
            }
            let repeating = repeating::find(self.table, self.acquired, &selection.rich);
            let verdict = self.verdict(&selection, &causes, &faults, before.as_ref(), repeating.is_some());
            let stand = verdict == Verdict::Mismatch;
            return Judged {
                verdict,
                causes: if stand { causes } else { Vec::new() },
                faults,
                before,
                after,
                comparison,
                windows,
                stretches,
                selection,
                repeating,
                one_step_ahead: overdamped,
            };
        }
    }

    fn verdict(
        &self,
        selection: &Selection,
        causes: &[Cause],
        faults: &[Fault],
        before: Option<&SimulatedFit>,
        repeats: bool,
    ) -> Verdict {
        // What a simulation of the rig leaves is numerical, or the sensor's noise.
        let spread = self.acquired.spread();
        let clean = before.map_or(f64::INFINITY, |b| b.rms) < SETTINGS.numerical * spread;
        let nothing = selection.nothing.total();
        let share = (selection.chosen.total() - selection.rich.total()) / nothing;
        let structured = selection.rich_p_value < selection.level && share > SETTINGS.unexplained && !clean;
        let is_beyond_tolerance = !self.is_within_tolerance(before);
        if self.has_simpler(selection) && !clean && is_beyond_tolerance {
            return Verdict::Unexplained;
        }
        match (causes.is_empty(), (structured || repeats && !clean) && is_beyond_tolerance) {
            (false, true) if structured && selection.explained() < SETTINGS.explains => Verdict::Unexplained,
            (false, _) if !clean => Verdict::Mismatch,
            (true, true) if faults.is_empty() => Verdict::Unexplained,
            (true, false) if faults.is_empty() && self.explains_nothing(before) => Verdict::Unexplained,
            _ if !faults.is_empty() => Verdict::Mismatch,
            _ => Verdict::NoMismatch,
        }
    }

    /// Whether fewer forces without a name leave less than the causes do, beyond chance.
    fn has_simpler(&self, selection: &Selection) -> bool {
        let fewer = selection.chosen.parts.len().saturating_sub(1);
        fewer > 0 && gain_p(&selection.chosen, &self.table.flexible_of(&selection.nothing, fewer)) < selection.level
    }

    /// Whether the rig's simulation leaves no more than the sensor's noise, or than parameters do that are right within their tolerance.
    fn is_within_tolerance(&self, before: Option<&SimulatedFit>) -> bool {
        let most = (SETTINGS.at_noise * self.acquired.noise_std).max(SETTINGS.tolerance * self.acquired.spread());
        before.is_some_and(|b| b.rms < most)
    }

    /// Whether the rig's simulation leaves most of a motion that the recordings' own past predicts.
    fn explains_nothing(&self, before: Option<&SimulatedFit>) -> bool {
        let [left, innovations] = SETTINGS.explains_nothing;
        let spread = self.acquired.spread();
        before.is_none_or(|b| b.rms > left * spread) && self.acquired.innovations() < innovations * spread
    }

    /// The selection without the cause that improves the simulation least, if that is too little.
    fn without_idle(
        &self,
        selection: &Selection,
        [before, after]: [f64; 2],
        windows: &Windows,
        by_regression: bool,
    ) -> Option<Selection> {
        let explained = before.powi(2) - after.powi(2);
        let one = |part: usize| {
            let mut parts = selection.chosen.parts.clone();
            parts.remove(part);
            let fewer = self.of_parts(selection.clone(), parts);
            let fit = if by_regression {
                self.by_regression(&fewer.chosen, windows)
            } else {
                let machine = self.machine(&fewer.chosen);
                let causes = causes::causes(self.table, &fewer.chosen, &machine, self.acquired);
                let (rig, keys) = validate::with_causes(&self.rig(&fewer.chosen), &causes, self.free());
                validate::fit(&rig, &keys, self.acquired, windows)
            };
            let rms = fit.map_or(f64::INFINITY, |fit| fit.rms);
            (rms, fewer)
        };
        let least = (0..selection.chosen.parts.len()).map(one).min_by(|a, b| a.0.total_cmp(&b.0))?;
        let lost = least.0.powi(2) - after.powi(2);
        (lost < SETTINGS.worth_simulated * explained && lost < SETTINGS.worth_left * after.powi(2)).then_some(least.1)
    }

    /// A selection with one cause less.
    fn narrower(&self, selection: Selection) -> Selection {
        let mut parts = selection.chosen.parts.clone();
        parts.pop();
        self.of_parts(selection, parts)
    }

    /// A selection with these parts.
    fn of_parts(&self, selection: Selection, parts: Vec<(usize, usize)>) -> Selection {
        if parts.is_empty() {
            let mut bare = selection;
            bare.chosen = bare.nothing.clone();
            bare.rich = self.table.flexible(&bare.nothing);
            bare.rich_p_value = gain_p(&bare.nothing, &bare.rich);
            return bare;
        }
        let terms: Vec<usize> = parts.iter().map(|(t, _)| *t).collect();
        let variants = vec![parts.iter().map(|(_, v)| *v).collect()];
        let chosen = self.table.model(&terms, &variants).unwrap_or_else(|| selection.nothing.clone());
        let rich = self.table.flexible(&chosen);
        let rich_p_value = gain_p(&chosen, &rich);
        Selection { chosen, rich, rich_p_value, ..selection }
    }

    fn unsimulated(&self, selection: Selection, faults: Vec<Fault>, windows: Windows) -> Judged {
        let share = (selection.nothing.total() - selection.rich.total()) / selection.nothing.total();
        let structured = selection.rich_p_value < selection.level && share > SETTINGS.unexplained;
        let repeating = repeating::find(self.table, self.acquired, &selection.rich);
        Judged {
            verdict: if structured || repeating.is_some() { Verdict::Unexplained } else { Verdict::NoMismatch },
            causes: Vec::new(),
            faults,
            before: None,
            after: None,
            comparison: Comparison { before: 0.0, after: 0.0, p_value: 1.0 },
            windows,
            stretches: Vec::new(),
            selection,
            repeating,
            one_step_ahead: false,
        }
    }

    /// Fit of the regression.
    fn by_regression(&self, model: &TermModel, windows: &Windows) -> Option<SimulatedFit> {
        let rig_of = |model: &TermModel| {
            let causes = causes::causes(self.table, model, &self.machine(model), self.acquired);
            validate::with_causes(&self.rig(model), &causes, &self.nominal.unknown)
        };
        let (rig, keys) = rig_of(model);
        let folds = self.table.without_folds(model).iter().map(|m| rig_of(m).0).collect();
        let widths = self.table.half_widths(model);
        let own = self.table.library.own.len();
        let mut seen = Vec::new();
        let width = |key: &RigKey| {
            // The first number of a cause is its strength.
            let column = match key {
                RigKey::Model(_) => self.table.library.own.iter().position(|(p, ..)| RigKey::from(p.key()) == *key)?,
                RigKey::Effect { index, .. } if seen.contains(index) => return None,
                RigKey::Effect { index, .. } => {
                    seen.push(*index);
                    own + index - self.task.rig.effects.len()
                }
            };
            widths.as_ref()?.get(column).copied()
        };
        let widths: Vec<Option<f64>> = keys.iter().map(width).collect();
        let rms = if self.nominal.is_overdamped(self.acquired) {
            let errors = self.table.step_errors(model);
            (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt()
        } else {
            validate::simulated_rms(&rig, self.acquired, windows)?
        };
        Some(validate::by_regression(&rig, &keys, folds, &widths, rms))
    }

    /// Parameters that the simulation fits; with a healthy baseline the regression's values stand.
    fn free(&self) -> &[crate::identify::force_balance::equation::Parameter] {
        if self.task.baseline.is_some() { &[] } else { &self.nominal.unknown }
    }

    fn machine(&self, model: &TermModel) -> crate::rig::config::SdofRig {
        self.table.machine(self.nominal, model)
    }

    fn rig(&self, model: &TermModel) -> Rig {
        let machine = self.machine(model);
        Nominal { machine, ..self.nominal.clone() }.rig(self.task.rig)
    }
}
