//! Null model of a bearing rig, and the one or two causes that explain its lack of fit.

use super::DiagnoseError;
use super::data_split::DataSplit;
use super::hypothesis::{self, Hypothesis};
use super::initial_guesses;
use super::model_selection::{Candidate, Dropped, ModelSelection, Part, Ranking, half_bic};
use super::residual::{LackOfFit, Whitened, cosine_similarity, lack_of_fit, whitened};
use super::validation::replicate;
use crate::identify::likelihood::coordinate::Coordinate;
use crate::identify::likelihood::problem::{Point, Problem};
use crate::identify::likelihood::search::{Limits, Optimum, search};
use crate::rig::config::RigKey;
use crate::rig::effect::EffectKind;
use crate::rig::random_part::depends_on_velocity_noise;
use crate::rig::{Rig, RigError};

/// Gain in ln L that a cause must have beyond the BIC penalty of its parameters: some ninety explanations, each from many starts, were
/// tried on the same recordings.
pub const LEAST_BIC_GAIN: f64 = 12.0;
/// Share of the lack of fit that causes must explain.
pub const EXPLAINED: f64 = 0.93;
/// Share of the first cause's gain that another must have to be tried as the first of a pair in its place, and how like the two
/// may be in what they change.
const ANOTHER_GAINS: f64 = 0.3;
const ALIKE: f64 = 0.9;
/// Share of what the first cause leaves that a second must take away.
const SECOND_EXPLAINS: f64 = 0.6;
/// Share of the first cause's gain that a second must have: the strongest effects show the limits of the method itself.
/// Where the first leaves nothing that shows it must have more, and yet more where what the first leaves is not exact.
const SECOND_GAINS: f64 = 1e-4;
const HIDDEN_GAINS: f64 = 1e-3;
const INEXACT_GAINS: f64 = 5e-3;
/// ln L that a second cause must promise at the first look, and then gain, where the first leaves nothing that shows, and
/// how many times what it gains on replicates of the first alone.
const LEAST_SECOND_GAIN: f64 = 40.0;
const BEYOND: f64 = 3.0;
/// Share of the excess from which what explains it is worth more work. Times that a pair's causes are sought anew beside each
/// other, and the share of a cause's gain that others must promise to be tried in its place.
const WORTH_MORE: f64 = 0.5;
const EXCHANGES: usize = 2;
const RIVALS_SHARE_OF_GAIN: f64 = 0.3;
/// Share of the excess from which a first cause that leaves more than chance is not sought anew: of wrong ones the nearest left
/// 4 % in the proofs of two seeds.
const RIGHT: f64 = 0.99;
/// The same of a pair: of wrong ones that left more than chance the nearest left 0.18 %, of right ones the furthest 0.06 %.
const EXACT: f64 = 0.999;
/// Replicates of a rig with friction that tell what it leaves: it holds and lets go in bursts, so that one leaves far more than
/// another. Of any other rig one does.
const REPLICATES: u64 = 4;
/// Share of the excess that the first cause must take away for a second to be sought: of two that take all of it away
/// together the greater takes half, or, where they overlap, somewhat less.
const WORTH_A_SECOND: f64 = 0.2;

/// Null model: the fitted rig without causes, with its residual.
pub struct NullFit<'o> {
    /// Recordings by their use.
    pub split: &'o DataSplit,
    /// Model selection on the fitted recordings.
    pub selection: ModelSelection<'o>,
    /// Likelihood problem of the fit.
    pub problem: Problem<'o>,
    /// Optimum of the fit.
    pub found: Optimum,
    /// Whitened residuals.
    pub residuals: Vec<Whitened>,
    /// Lack of fit beyond that of replicates of the rig.
    pub lack_of_fit: LackOfFit,
    /// Seed of replicates.
    pub seed: u64,
}

impl<'o> NullFit<'o> {
    /// Fits the null model.
    ///
    /// # Errors
    /// Errors of the simulation.
    pub fn new(rig: &Rig, split: &'o DataSplit, seed: u64) -> Result<Self, DiagnoseError> {
        let unknown = rig.unknown_keys().into_iter().filter_map(|key| Coordinate::for_key(rig, key)).collect();
        let mut selection = ModelSelection {
            all: &split.fitted,
            beginnings: &split.beginnings,
            subset: &split.subset,
            which: &split.which,
            rig: rig.clone(),
            unknown,
            angles: None,
        };
        let (problem, found) = selection.null(Part::All)?;
        selection.angles = Some(found.point.angles.clone());
        let residuals = residuals(&problem, &found)?;
        let lack_of_fit = lack_of_fit(&residuals).beyond(replicated(&problem, &found, seed)?);
        Ok(Self { split, selection, problem, found, residuals, lack_of_fit, seed })
    }

    /// Fitted rig.
    ///
    /// # Errors
    /// Errors of the rig, none that the search has not met.
    pub fn rig(&self) -> Result<Rig, DiagnoseError> {
        Ok(self.problem.rig_at(&self.found.point.coordinates)?)
    }

    /// All hypotheses; those in time or frequency start where the residual of a few recordings points.
    fn hypotheses(&self) -> Result<Vec<Hypothesis>, DiagnoseError> {
        let (problem, found) = self.selection.null(Part::Subset)?;
        let guesses =
            initial_guesses::initial_guesses(&self.selection.rig, &self.split.subset, &problem.predict(&found.point)?);
        Ok(hypothesis::all(&self.selection.rig, self.split.load_n, &guesses))
    }

    /// Causes that explain the lack of fit, two at most.
    ///
    /// # Errors
    /// Errors of the simulation of the null model.
    pub fn explain(&self, progress: &dyn Fn(&str)) -> Result<Explanation<'o>, DiagnoseError> {
        let hypotheses = self.hypotheses()?;
        let Ranking { candidates, dropped } = self.selection.run(&hypotheses, f64::NEG_INFINITY, progress)?;
        let Some(best) = self.best(candidates.clone()) else {
            return Ok(Explanation { candidates, dropped, ..Explanation::nothing(self.lack_of_fit) });
        };
        let single = self.refined(best, progress);
        let mut pair = self.second(&single, &hypotheses, progress)?;
        let left = pair.as_ref().map_or(&single, |pair| &pair.last).left;
        // Beside friction every look takes long.
        if left.is_more_than_chance()
            && self.lack_of_fit.explained(&left) < EXPLAINED
            && !depends_on_velocity_noise(&single.cause.rig()?)
            && let Some(other) = self.another(&single)?
        {
            let beside_other = self.second(&self.refined(other, progress), &hypotheses, progress)?;
            pair = pair.into_iter().chain(beside_other).min_by(|a, b| a.last.left.nats.total_cmp(&b.last.left.nats));
        }
        let pair = pair.map(|pair| self.exchange(pair, &single.left, &hypotheses, progress)).transpose()?;
        let kept = pair.and_then(|pair| self.backward_eliminate(pair, &single)).unwrap_or_else(|| vec![single.clone()]);
        let last = kept.last().unwrap_or(&single);
        let log_likelihood_gain =
            self.found.expansion.neg_log_likelihood() - last.cause.found.expansion.neg_log_likelihood();
        Ok(Explanation { candidates, dropped, left: last.left, log_likelihood_gain, kept })
    }

    /// The best candidate that gains enough and can be run everywhere: a rig that stands only as long as nothing shakes it is
    /// none.
    fn best(&self, rivals: Vec<Candidate<'o>>) -> Option<Selected<'o>> {
        let leaves = |c: &Candidate| {
            let all = lack_of_fit(&residuals(&c.problem, &c.found)?);
            Ok::<_, DiagnoseError>(all.beyond(replicated(&c.problem, &c.found, self.seed)?))
        };
        let enough = rivals.iter().filter(|c| c.bic_gain > LEAST_BIC_GAIN);
        let (cause, left) = enough.cloned().find_map(|c| {
            let left = leaves(&c).ok()?;
            Some((c, left))
        })?;
        Some(Selected { cause, rivals, left })
    }

    /// Whether what leaves this explains much and yet not all.
    fn is_worth_more(&self, left: &LackOfFit) -> bool {
        left.is_more_than_chance() && (WORTH_MORE..EXACT).contains(&self.lack_of_fit.explained(left))
    }

    /// The same, brought nearer where the search for it has stopped short of what it can explain.
    fn refined(&self, choice: Selected<'o>, progress: &dyn Fn(&str)) -> Selected<'o> {
        if !self.is_worth_more(&choice.left) {
            return choice;
        }
        progress(&format!("refitting {} {} from low to high frequencies", choice.cause.kind, choice.cause.place));
        let nearer = choice.cause.refined(LEAST_BIC_GAIN).and_then(|cause| self.best(vec![cause]));
        match nearer {
            Some(nearer) => Selected { rivals: choice.rivals, ..nearer },
            None => choice,
        }
    }

    /// A rival that gains much by changing something else: of two causes a third may stand for the greater part of both, which
    /// then hides either.
    fn another(&self, first: &Selected<'o>) -> Result<Option<Selected<'o>>, DiagnoseError> {
        let of_first = residuals(&first.cause.problem, &first.cause.found)?;
        let like =
            |c: &Candidate| Some(cosine_similarity(&self.residuals, &of_first, &residuals(&c.problem, &c.found).ok()?));
        let rivals =
            first.rivals.iter().filter(|c| c.log_likelihood_gain > ANOTHER_GAINS * first.cause.log_likelihood_gain);
        let rivals = rivals.filter_map(|c| Some((like(c)?, c))).filter(|(like, _)| *like < ALIKE);
        let other = rivals.min_by(|a, b| a.0.total_cmp(&b.0)).and_then(|(_, c)| self.best(vec![c.clone()]));
        // Those that gain more alone lose where both causes are there.
        let below =
            |other: &Selected| first.rivals.iter().filter(|c| c.bic_gain <= other.cause.bic_gain).cloned().collect();
        Ok(other.map(|other| Selected { rivals: below(&other), ..other }))
    }

    /// A second cause beside the first; nothing where none is worth its parameters.
    fn second(
        &self,
        first: &Selected<'o>,
        hypotheses: &[Hypothesis],
        progress: &dyn Fn(&str),
    ) -> Result<Option<Pair<'o>>, DiagnoseError> {
        let (cause, left) = (&first.cause, &first.left);
        let explained = self.lack_of_fit.explained(left);
        // The random part of friction is not exact, least of all where it holds a mass: beside what stands by itself nothing is told.
        let stands_alone =
            (explained > EXPLAINED || !left.is_more_than_chance()) && depends_on_velocity_noise(&cause.rig()?);
        if explained < WORTH_A_SECOND || stands_alone {
            return Ok(None);
        }
        let least = least_of_a_second(cause, left);
        progress("searching for a second cause");
        let mut rivals = self.search_given(&cause.problem, &cause.found.point, hypotheses, cause, least, progress)?;
        rivals.retain(|c| c.log_likelihood_gain > least);
        let Some(best) = self.best(rivals) else { return Ok(None) };
        let last = self.refined(best, progress);
        // What does not show by itself may be what the first cause's own linearisation leaves out.
        if !left.is_more_than_chance() && !self.beyond_replicates(cause, &last.cause)? {
            return Ok(None);
        }
        Ok(Some(Pair { first: first.clone(), last }))
    }

    /// The pair with each of its causes sought anew beside the other, as long as that gains and something is left: the first
    /// was found where the second was missing, and may have stood in for both, unless it left next to nothing.
    fn exchange(
        &self,
        mut pair: Pair<'o>,
        left_by_first: &LackOfFit,
        hypotheses: &[Hypothesis],
        progress: &dyn Fn(&str),
    ) -> Result<Pair<'o>, DiagnoseError> {
        if self.lack_of_fit.explained(left_by_first) > RIGHT {
            return Ok(pair);
        }
        for _ in 0..EXCHANGES {
            if !self.is_worth_more(&pair.last.left) {
                break;
            }
            progress("searching for the first cause given the second");
            let both = &pair.last.cause;
            let Some((problem, found)) = self.refit_without(both) else { break };
            let had = found.expansion.neg_log_likelihood() - both.found.expansion.neg_log_likelihood();
            let mut rivals =
                self.search_given(&problem, &found.point, hypotheses, both, RIVALS_SHARE_OF_GAIN * had, progress)?;
            rivals.retain(|c| c.half_bic() + LEAST_BIC_GAIN < both.half_bic());
            let Some(best) = self.best(rivals) else { break };
            pair = Pair { first: pair.last, last: self.refined(best, progress) };
        }
        Ok(pair)
    }

    /// The selection for another cause beside that of a problem, which is part of the rig, its parameters fitted along.
    fn search_given(
        &self,
        problem: &Problem<'o>,
        point: &Point,
        hypotheses: &[Hypothesis],
        cause: &Candidate,
        least: f64,
        progress: &dyn Fn(&str),
    ) -> Result<Vec<Candidate<'o>>, DiagnoseError> {
        let rig = problem.rig_at(&point.coordinates)?;
        let angles = Some(point.angles.clone());
        let selection = ModelSelection { rig, unknown: problem.coordinates.clone(), angles, ..self.selection.clone() };
        let is_the_same = |h: &Hypothesis| h.kind == cause.kind && h.place == cause.place;
        let others: Vec<_> = hypotheses.iter().filter(|h| !is_the_same(h)).cloned().collect();
        // With a cause that is not the right one the rig may not stand in every recording: then there is no other.
        Ok(selection.run(&others, least, progress).unwrap_or_default().candidates)
    }

    /// A pair that takes away enough of what the first alone left; nothing where it does not. Where one has but stood in for
    /// the other, that one alone.
    fn backward_eliminate(&self, pair: Pair<'o>, single: &Selected<'o>) -> Option<Vec<Selected<'o>>> {
        let left = pair.last.left;
        if left.is_more_than_chance() && single.left.nats - left.nats < SECOND_EXPLAINS * single.left.nats {
            return None;
        }
        let both = &pair.last.cause;
        let alone = self
            .refit_without(both)
            .filter(|(problem, found)| half_bic(problem, found) <= both.half_bic() + LEAST_BIC_GAIN);
        let Some((problem, found)) = alone else { return Some(vec![pair.first, pair.last]) };
        let log_likelihood_gain = self.found.expansion.neg_log_likelihood() - found.expansion.neg_log_likelihood();
        let bic_gain = half_bic(&self.problem, &self.found) - half_bic(&problem, &found);
        let cause = Candidate { problem, found, bic_gain, log_likelihood_gain, ..both.clone() };
        Some(vec![Selected { cause, rivals: single.rivals.clone(), left }])
    }

    /// Whether a second cause gains more than it does on recordings that the first alone has made.
    fn beyond_replicates(&self, first: &Candidate, both: &Candidate) -> Result<bool, DiagnoseError> {
        let made = replicate(&first.rig()?, first.problem.observed, &first.found.point.angles, self.seed)?;
        let neg_log_likelihood = |of: &Candidate| {
            let problem = Problem { observed: &made, ..of.problem.clone() };
            Ok::<_, RigError>(
                search(&problem, of.found.point.clone(), &Limits::default())?.expansion.neg_log_likelihood(),
            )
        };
        let by_chance = neg_log_likelihood(first)? - neg_log_likelihood(both)?;
        Ok(both.log_likelihood_gain > BEYOND * by_chance.max(0.0) + LEAST_BIC_GAIN)
    }

    /// The last of two causes without the first, fitted; nothing where the rig does not stand so.
    fn refit_without(&self, both: &Candidate<'o>) -> Option<(Problem<'o>, Optimum)> {
        let mut rig = both.rig().ok()?;
        let number = self.selection.rig.effects.len();
        rig.effects.remove(number);
        // Those of the rig, of the first and of the last; these are free still, under the number that it now has.
        let before = self.selection.unknown.len();
        let of_last = |c: &Coordinate| c.key.of_effect(number + 1).is_some();
        let own = both.problem.coordinates.iter().position(of_last).unwrap_or(both.problem.coordinates.len());
        let renumbered = both.problem.coordinates[own..].iter().filter_map(|c| {
            let key = c.key.of_effect(number + 1)?;
            Coordinate::for_key(&rig, RigKey::Effect { index: number, key })
        });
        let coordinates = self.selection.unknown.iter().cloned().chain(renumbered).collect();
        let problem = Problem::new(both.problem.observed, rig, coordinates);
        let mut point = both.found.point.clone();
        point.coordinates.drain(before..own);
        let found = search(&problem, point, &Limits::default()).ok()?;
        Some((problem, found))
    }
}

/// Selected cause with its rivals and the remaining lack of fit.
#[derive(Clone, Debug)]
pub struct Selected<'o> {
    /// Selected cause.
    pub cause: Candidate<'o>,
    /// Cause and its rivals, the best first.
    pub rivals: Vec<Candidate<'o>>,
    /// Remaining lack of fit beyond that of replicates.
    pub left: LackOfFit,
}

impl Selected<'_> {
    /// Posterior probability of the cause among its rivals of other names.
    pub fn probability(&self) -> f64 {
        let others = self.rivals.iter().filter(|c| c.kind != self.cause.kind);
        (1.0 / (1.0 + others.map(|c| (c.bic_gain - self.cause.bic_gain).exp()).sum::<f64>())).min(0.999)
    }
}

/// Two causes; the rig of the last has both.
struct Pair<'o> {
    first: Selected<'o>,
    last: Selected<'o>,
}

/// Result of the search for causes.
#[derive(Clone, Debug)]
pub struct Explanation<'o> {
    /// Candidates for a first cause, the best first.
    pub candidates: Vec<Candidate<'o>>,
    /// Hypotheses dropped before.
    pub dropped: Vec<Dropped>,
    /// Kept causes in the order of their selection; the rig of the last has all.
    pub kept: Vec<Selected<'o>>,
    /// Remaining lack of fit of the last, beyond that of replicates.
    pub left: LackOfFit,
    /// Joint gain in ln L of the kept causes.
    pub log_likelihood_gain: f64,
}

impl<'o> Explanation<'o> {
    /// Explanation without a cause.
    pub fn nothing(left: LackOfFit) -> Self {
        Self { candidates: Vec::new(), dropped: Vec::new(), kept: Vec::new(), left, log_likelihood_gain: 0.0 }
    }

    /// Candidate whose rig has all causes; `None` if there are none.
    pub fn last(&self) -> Option<&Candidate<'o>> {
        self.kept.last().map(|choice| &choice.cause)
    }

    /// Whether a cause of this name was kept.
    pub fn keeps(&self, kind: EffectKind) -> bool {
        self.kept.iter().any(|choice| choice.cause.kind == kind)
    }
}

/// ln L that a second cause must promise at the first look, and then gain. Where the first leaves nothing that shows by
/// itself, a second may yet show beside it, as far as what the first leaves is exact: of an effect on small motions the
/// rig's linearisation is not.
fn least_of_a_second(first: &Candidate, left: &LackOfFit) -> f64 {
    let exact = first.kind.definition().is_deterministic;
    match (left.is_more_than_chance(), exact) {
        (true, _) => SECOND_GAINS * first.log_likelihood_gain,
        (false, true) => (HIDDEN_GAINS * first.log_likelihood_gain).max(LEAST_SECOND_GAIN),
        (false, false) => (INEXACT_GAINS * first.log_likelihood_gain).max(LEAST_SECOND_GAIN),
    }
}

fn residuals(problem: &Problem, found: &Optimum) -> Result<Vec<Whitened>, DiagnoseError> {
    Ok(whitened(problem.observed, &problem.predict(&found.point)?))
}

/// The excess that recordings of this very rig would show: what the linearisation of its random part leaves out.
fn replicated(problem: &Problem, found: &Optimum, seed: u64) -> Result<LackOfFit, DiagnoseError> {
    let rig = problem.rig_at(&found.point.coordinates)?;
    let expected = problem.predict(&found.point)?;
    let count = if depends_on_velocity_noise(&rig) { REPLICATES } else { 1 };
    let of = |n: u64| {
        let observed = replicate(&rig, problem.observed, &found.point.angles, seed.wrapping_add(n))?;
        Ok::<_, DiagnoseError>(lack_of_fit(&whitened(&observed, &expected)))
    };
    Ok(LackOfFit::mean(&(0..count).map(of).collect::<Result<Vec<_>, _>>()?))
}
