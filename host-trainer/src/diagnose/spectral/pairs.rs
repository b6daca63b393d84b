//! Two effects at once: where two are in a machine, a third that is none of them may explain more than either, and the search for
//! one after the other starts with it.

use std::fmt;

use rayon::prelude::*;

use super::candidate::{Candidate, NullFit, best};
use super::causes;
use super::cross::set_phases;
use super::hypotheses::Hypothesis;
use super::settings::SearchSettings;
use super::text::named;
use crate::rig::EffectEntry;
use crate::rig::effect::EffectKind;

const SETTINGS: SearchSettings = SearchSettings::DEFAULT;

/// Two effects fitted together.
#[derive(Clone)]
pub struct Pair<'d, 'a> {
    /// Fit of the one that gains more by itself.
    pub first: Candidate<'d, 'a>,
    /// Fit of both, on top of the first one's.
    pub second: Candidate<'d, 'a>,
}

impl<'d, 'a> Pair<'d, 'a> {
    /// Gain of both.
    pub fn gain(&self) -> f64 {
        self.first.gain + self.second.gain
    }

    /// Gain of both less the price of their numbers.
    pub fn merit(&self) -> f64 {
        self.first.gain + self.second.merit()
    }

    /// Fits of the first and of both.
    pub fn each(&self) -> [&Candidate<'d, 'a>; 2] {
        [&self.first, &self.second]
    }

    /// Effects.
    pub fn kinds(&self) -> [EffectKind; 2] {
        self.each().map(|c| c.kind)
    }

    /// Whether the phase between the channels speaks against both.
    pub fn is_contradicted(&self, asked: f64) -> bool {
        let mut second = [self.second.clone()];
        set_phases(&self.first.as_null(), &mut second, asked);
        second[0].is_contradicted()
    }

    /// Probability of the first or the second of them among other causes, given by their effects and merit.
    pub fn probability(&self, n: usize, others: &[(Vec<EffectKind>, f64)]) -> f64 {
        let Candidate { kind, gain, .. } = self.each()[n];
        let without = others.iter().filter(|(kinds, _)| !kinds.contains(kind));
        causes::probability_of(*gain, without.map(|(_, merit)| merit - self.merit()), self.gain(), n > 0)
    }
}

impl fmt::Display for Pair<'_, '_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, second] = self.each().map(|c| named(c.kind.name(), &c.place));
        write!(f, "{first} with {second}")
    }
}

/// Pairs of the best fits of single effects of different kinds on top of a null fit, and of all but the first with the effect that
/// explains most beside the first; the pair of greatest merit first.
pub fn pairs<'d, 'a>(
    null: &NullFit<'d, 'a>,
    singles: &[Candidate<'d, 'a>],
    beside_first: Option<&Candidate>,
) -> Vec<Pair<'d, 'a>> {
    let hypotheses = null.hypotheses();
    let of_kinds = best_of_kinds(singles);
    let among = of_kinds.iter().enumerate().flat_map(|(n, first)| {
        let others = of_kinds[n + 1..].iter();
        others.filter_map(|second| Some((*first, Second::as_fitted(second, null, &hypotheses)?)))
    });
    let beside_first = beside_first.filter(|c| c.kind.in_vocabulary() && of_kinds.iter().all(|of| of.kind != c.kind));
    let beside_first = beside_first.and_then(|second| Second::anew(second, &hypotheses));
    let others = of_kinds.iter().filter(|c| singles.first().is_none_or(|first| c.kind != first.kind));
    let with_second = others.filter_map(|other| Some((*other, beside_first.clone()?)));
    let each: Vec<(&Candidate, Second)> = among.chain(with_second).collect();
    let started = each.into_par_iter().filter_map(|(first, second)| {
        let started = best(first.as_null().started(&second.hypothesis, &second.starts))?;
        Some(Pair { first: first.clone(), second: started.searched(SETTINGS.steps[0]) })
    });
    let mut pairs: Vec<Pair> = started.collect();
    rank(&mut pairs);
    let followed = pairs.len().min(SETTINGS.pairs_followed);
    pairs[..followed].par_iter_mut().for_each(|pair| {
        pair.second = pair.second.clone().searched(SETTINGS.steps[1]);
    });
    rank(&mut pairs);
    pairs
}

/// Sorts pairs, the one of greatest merit first.
fn rank(pairs: &mut [Pair]) {
    pairs.sort_by(|a, b| b.merit().total_cmp(&a.merit()));
}

/// The best candidates of different kinds, of which pairs are made.
fn best_of_kinds<'c, 'd, 'a>(singles: &'c [Candidate<'d, 'a>]) -> Vec<&'c Candidate<'d, 'a>> {
    let mut ranked: Vec<&Candidate> = singles.iter().filter(|c| c.kind.in_vocabulary()).collect();
    ranked.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let most = ranked.first().map_or(0.0, |c| c.gain);
    let mut of_kinds: Vec<&Candidate> = Vec::new();
    for candidate in ranked.into_iter().filter(|c| c.gain > SETTINGS.pair_share * most) {
        if of_kinds.iter().all(|c| c.kind != candidate.kind) {
            of_kinds.push(candidate);
        }
    }
    of_kinds.truncate(SETTINGS.paired);
    of_kinds
}

/// Effect that is fitted beside another one.
#[derive(Clone)]
struct Second {
    hypothesis: Hypothesis,
    starts: Vec<EffectEntry>,
}

impl Second {
    /// From where a candidate on top of a null fit was fitted, with as many numbers free.
    fn as_fitted(candidate: &Candidate, null: &NullFit, hypotheses: &[Hypothesis]) -> Option<Self> {
        let of = hypotheses.iter().find(|h| candidate.is_of(h))?;
        let own = candidate.model.coordinates.len() - null.model.coordinates.len();
        let free = if own > of.free.len() { of.extended } else { of.free };
        Some(Self { hypothesis: Hypothesis { free, ..of.clone() }, starts: vec![candidate.effect()?] })
    }

    /// From all starts of a candidate's hypothesis as well: beside another effect its size can be another one.
    fn anew(candidate: &Candidate, hypotheses: &[Hypothesis]) -> Option<Self> {
        let of = hypotheses.iter().find(|h| candidate.is_of(h))?;
        let starts = of.starts.iter().cloned().chain(candidate.effect()).collect();
        Some(Self { hypothesis: of.clone(), starts })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::spectral::data::{Data, Point};
    use crate::diagnose::spectral::fit::Model;
    use crate::diagnose::spectral::imperfect::testing::observed;
    use crate::diagnose::spectral::unevenness::UnevenMachines;
    use crate::rig::effect::ParameterKey::{Component, ForceN, Value};
    use crate::rig::test_support::nominal;
    use crate::rig::{EffectEntry, Rig};

    /// Of a softer housing, a greater load and a mass that is not changed, the first two are found in a machine that has both; in one
    /// with a softer housing alone no pair explains more than that.
    #[test]
    fn invariant_two_effects_are_found_at_once() {
        let soft = EffectEntry::new(EffectKind::StiffnessChange, &[(Value, 1.2e7)]).with_text(Component, "outer");
        let pulled = EffectEntry::new(EffectKind::ConstantForce, &[(ForceN, 250.0)]).with_text(Component, "inner-y");
        let found = |rig: &Rig| {
            let orders = rig.bearing().unwrap().bearing.geometry().orders();
            let observations =
                [400.0, 700.0].map(|load_n| observed(rig, load_n, &Point::default().in_recordings(1, 0)));
            let data = Data::new(&observations, orders, UnevenMachines::default());
            let model = Model::fixed(&data, nominal());
            let null = NullFit::new(&model, &model.search(model.start().unwrap(), 4).unwrap());
            let hypotheses = null.hypotheses();
            let tried = [
                (EffectKind::StiffnessChange, "outer"),
                (EffectKind::ConstantForce, "inner-y"),
                (EffectKind::MassChange, "inner"),
            ];
            let single = |(kind, place): (EffectKind, &str)| {
                let of = hypotheses.iter().find(|h| h.kind == kind && h.place == place).unwrap();
                best(null.started(of, &of.starts)).unwrap().searched(SETTINGS.steps[1])
            };
            let singles = tried.map(single);
            // All of them are tried, whatever each gains by itself.
            let most = singles.iter().map(|c| c.gain).fold(1.0, f64::max);
            let tried = singles.clone().map(|c| Candidate { gain: c.gain.max(0.3 * most), ..c });
            let gain_beyond = |pair: &Pair| {
                let of_first = singles.iter().find(|c| c.kind == pair.first.kind).unwrap().gain;
                of_first + pair.second.gain - most
            };
            let pair = pairs(&null, &tried, None).swap_remove(0);
            // Of the softer housing beside the force, which was found beside another effect.
            let [soft, pulled, heavy] = tried;
            let beside = pairs(&null, &[heavy, soft], Some(&pulled));
            let beside = beside.iter().find(|pair| pair.first.kind == EffectKind::StiffnessChange);
            (pair.kinds(), gain_beyond(&pair), beside.map(gain_beyond))
        };
        let (kinds, gain, beside) = found(&nominal().with_effect(soft.clone()).with_effect(pulled));
        assert!(
            kinds.contains(&EffectKind::StiffnessChange) && kinds.contains(&EffectKind::ConstantForce),
            "{kinds:?}"
        );
        assert!(gain > 40.0, "{gain}");
        assert!(beside.unwrap() > gain - 1.0, "{beside:?} {gain}");
        let (_, gain, _) = found(&nominal().with_effect(soft));
        assert!(gain < 12.0, "{gain}");
    }

    /// Beside another pair of its merit, an effect that both have is as probable as before, one that the other has not half as much.
    #[test]
    fn invariant_a_pair_is_as_probable_as_its_rivals_let_it_be() {
        let observations = [observed(&nominal(), 500.0, &Point::default().in_recordings(1, 0))];
        let orders = nominal().bearing().unwrap().bearing.geometry().orders();
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let of = |kind, gain| {
            let (model, place) = (Model::fixed(&data, nominal()), String::new());
            Candidate { kind, place, model, point: Point::default(), gain, phase: 0.0 }
        };
        let pair = Pair { first: of(EffectKind::ContactExponent, 400.0), second: of(EffectKind::ConstantForce, 300.0) };
        let alone = [0, 1].map(|n| pair.probability(n, &[]));
        let rival = (vec![EffectKind::ContactExponent, EffectKind::MassChange], pair.merit());
        let [first, second] = [0, 1].map(|n| pair.probability(n, std::slice::from_ref(&rival)));
        assert!(first == alone[0] && (second / alone[1] - 0.5).abs() < 1e-12, "{first} {second} {alone:?}");
    }
}
