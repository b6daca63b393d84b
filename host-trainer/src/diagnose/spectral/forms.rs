//! Other forms of a candidate: with all numbers of its effect's form, and effects with like spectra, at which a search may have ended.

use super::candidate::{Candidate, NullFit, best};
use super::hypotheses::{Hypothesis, ISOTROPIC, MODE_SOURCES, ladder};
use super::lack::lack;
use super::screening::{best_starts, scores, searched_briefly, searched_from_best};
use super::settings::{GateSettings, SearchSettings};
use crate::rig::EffectEntry;
use crate::rig::effect::{EffectKind, ParameterKey};

const SETTINGS: SearchSettings = SearchSettings::DEFAULT;
const GATE: GateSettings = GateSettings::DEFAULT;

/// Null fits on top of which other forms of a candidate are fitted.
#[derive(Clone, Copy)]
pub struct Forms<'n, 'd, 'a> {
    /// To all recordings.
    pub null: &'n NullFit<'d, 'a>,
    /// To brief ones, from which only the best forms go on.
    pub brief: &'n NullFit<'n, 'n>,
}

impl<'d, 'a> Forms<'_, 'd, 'a> {
    /// Better of a candidate and of the same effect with all numbers of its form.
    pub fn extended(&self, candidate: Candidate<'d, 'a>, hypothesis: &Hypothesis) -> Candidate<'d, 'a> {
        use ParameterKey::{DampingNSPerM, DeflectionM, Flank, Gain, GainAcross, StiffnessNPerM};
        let Some((key, effect)) = hypothesis.extended.last().zip(candidate.effect()) else { return candidate };
        let extended = Hypothesis { free: hypothesis.extended, ..hypothesis.clone() };
        let number = |key: ParameterKey| effect.number(key).unwrap_or(1.0);
        let starts = match *key {
            Flank => return self.reshaped(candidate, &extended),
            // A contact of another power that is as stiff under the load is far from one that is as stiff at 1 m.
            DeflectionM => {
                let own = vec![effect.clone().with_number(DeflectionM, number(DeflectionM))];
                let bent = hypothesis.starts.iter().filter(|start| start.number(DeflectionM).is_some()).cloned();
                let tried =
                    [own, bent.collect()].into_iter().filter_map(|starts| self.searched_best(&extended, &starts));
                return tried.fold(candidate, |most, other| if other.merit() > most.merit() { other } else { most });
            }
            // The gain of a mode at the other sensor is over that at its own.
            GainAcross => {
                SETTINGS.extension.map(|share| effect.clone().with_number(GainAcross, share * number(Gain))).to_vec()
            }
            DampingNSPerM if effect.number(DampingNSPerM).is_some() => return candidate,
            DampingNSPerM => {
                let damped = |delay_s: f64| effect.clone().with_number(DampingNSPerM, delay_s * number(StiffnessNPerM));
                SETTINGS.stop_delays_s.map(damped).to_vec()
            }
            // Of the waviness of a race only the best is fitted with its neighbours.
            _ => return candidate,
        };
        let searched = self.searched_best(&extended, &starts);
        searched.filter(|searched| searched.merit() > candidate.merit()).unwrap_or(candidate)
    }

    /// Search from the best of some starts of a hypothesis.
    fn searched_best(&self, hypothesis: &Hypothesis, starts: &[EffectEntry]) -> Option<Candidate<'d, 'a>> {
        best(self.null.started(hypothesis, starts)).map(|candidate| candidate.searched(SETTINGS.steps[1]))
    }

    /// Better of a candidate of a hypothesis and of effects with like spectra, at which a search may have ended.
    pub fn restarted(&self, candidate: Candidate<'d, 'a>, hypothesis: &Hypothesis) -> Candidate<'d, 'a> {
        let Some(effect) = candidate.effect() else { return candidate };
        let has_symmetry = hypothesis.starts.iter().any(|start| start.text(ParameterKey::Symmetry).is_some());
        let starts = if candidate.kind == EffectKind::StructuralResonance {
            other_modes(&effect)
        } else if has_symmetry {
            other_symmetry(&effect, hypothesis.free[0])
        } else if let Some(width) = effect.number(ParameterKey::WidthRad) {
            of_widths(&effect, &SETTINGS.other_widths.map(|share| share * width))
        } else {
            return candidate;
        };
        let searched = self.searched(hypothesis, starts);
        searched.filter(|best| best.gain > candidate.gain).unwrap_or(candidate)
    }

    /// Better of a defect's candidate and of the same with another shape, where a half sine leaves much.
    fn reshaped(&self, candidate: Candidate<'d, 'a>, extended: &Hypothesis) -> Candidate<'d, 'a> {
        let is_far = lack(candidate.model.data, &candidate.point).total() > GATE.little_lack;
        let Some(effect) = candidate.effect().filter(|_| is_far) else { return candidate };
        let Some(width) = effect.number(ParameterKey::WidthRad) else { return candidate };
        let shaped = SETTINGS.flanks.map(|flank| effect.clone().with_number(ParameterKey::Flank, flank));
        let ([least, greatest], steps) = SETTINGS.flank_widths;
        let widths = ladder(least * width, greatest * width, steps);
        let starts = shaped.iter().flat_map(|effect| of_widths(effect, &widths)).collect();
        let searched = self.searched(extended, starts);
        searched.filter(|searched| searched.merit() > candidate.merit()).unwrap_or(candidate)
    }

    /// Best of the searches from the best of some starts of a hypothesis: of many short ones on brief recordings, a few go on with all.
    fn searched(&self, hypothesis: &Hypothesis, starts: Vec<EffectEntry>) -> Option<Candidate<'d, 'a>> {
        let starts = starts.into_iter().map(|start| (hypothesis, start)).collect();
        let [many, few] = SETTINGS.restarts;
        let kept = best_starts(scores(self.brief, starts, &SETTINGS.other_depths), many, many);
        searched_from_best(hypothesis, searched_briefly(self.brief, kept), few, self.null)
    }
}

/// Effect with the other symmetry, at sizes around the one found.
fn other_symmetry(effect: &EffectEntry, key: ParameterKey) -> Vec<EffectEntry> {
    let is_isotropic = effect.text(ParameterKey::Symmetry) == Some(ISOTROPIC);
    let other = effect.clone().with_text(ParameterKey::Symmetry, if is_isotropic { "axes" } else { ISOTROPIC });
    let size = effect.number(key).unwrap_or_default();
    SETTINGS.other_sizes.map(|share| other.clone().with_number(key, share * size)).to_vec()
}

/// Modes of the same frequency with other sources, and gains of either sign.
fn other_modes(effect: &EffectEntry) -> Vec<EffectEntry> {
    use ParameterKey::{DampingRatio, Gain};
    let number = |key: ParameterKey| effect.number(key).unwrap_or_default();
    let of = |(source, sign): (&str, f64)| {
        let source = effect.clone().with_text(ParameterKey::Source, source);
        let (dampings, gains) = SETTINGS.other_modes;
        let resized = dampings.into_iter().flat_map(|damping| {
            let damped = source.clone().with_number(DampingRatio, damping * number(DampingRatio));
            gains.map(|gain| damped.clone().with_number(Gain, sign * gain * number(Gain).abs()))
        });
        resized.collect::<Vec<_>>()
    };
    MODE_SOURCES.into_iter().flat_map(of).collect()
}

/// Defect with other widths, rad: the zeros in the lines' envelope are elsewhere.
fn of_widths(effect: &EffectEntry, widths: &[f64]) -> Vec<EffectEntry> {
    widths.iter().map(|width| effect.clone().with_number(ParameterKey::WidthRad, *width)).collect()
}
