//! What a bearing rig leaves of its recordings, and the one or two causes that explain it.

use super::DiagnoseError;
use super::compete::{Contender, Contest, Dropped, Part, Ranking, cost};
use super::hypothesis::{self, Hypothesis};
use super::pointers;
use super::prove::replicate;
use super::residual::{Excess, Whitened, excess, likeness, whitened};
use super::sets::Sets;
use crate::rig::random_part::heeds_scatter;
use crate::rig::{Rig, RigError, effect};
use crate::whittle::coordinate::Coordinate;
use crate::whittle::problem::{Point, Problem};
use crate::whittle::search::{Found, Limits, search};

/// ln L that a cause must gain beyond what its parameters are worth: some ninety explanations, each from many starts, were
/// tried on the same recordings.
pub const LEAST_MERIT: f64 = 12.0;
/// Share of the excess that causes must take away to be an explanation.
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
const LEAST_PROMISE: f64 = 40.0;
const BEYOND: f64 = 3.0;
/// Share of the excess from which what explains it is worth more work. Times that a pair's causes are sought anew beside each
/// other, and the share of a cause's gain that others must promise to be tried in its place.
const WORTH_MORE: f64 = 0.5;
const EXCHANGES: usize = 2;
const RIVALS_PROMISE: f64 = 0.3;
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

/// The rig as it is, fitted, and what it leaves.
pub struct Ground<'o> {
    /// The recordings.
    pub sets: &'o Sets,
    /// Where hypotheses compete.
    pub contest: Contest<'o>,
    /// What was sought of the rig.
    pub problem: Problem<'o>,
    /// What was found.
    pub found: Found,
    /// What it leaves.
    pub residuals: Vec<Whitened>,
    /// Beyond what recordings of this very rig would show.
    pub excess: Excess,
    /// Of replicates.
    pub seed: u64,
}

impl<'o> Ground<'o> {
    /// Fits the rig.
    ///
    /// # Errors
    /// What the simulation refuses.
    pub fn of(rig: &Rig, sets: &'o Sets, seed: u64) -> Result<Self, DiagnoseError> {
        let unknown = rig.unknown_keys().iter().filter_map(|key| Coordinate::of(rig, key)).collect();
        let mut contest = Contest {
            all: &sets.fitted,
            brief: &sets.brief,
            few: &sets.few,
            which: &sets.which,
            rig: rig.clone(),
            unknown,
            angles: None,
        };
        let (problem, found) = contest.null(Part::All)?;
        contest.angles = Some(found.point.angles.clone());
        let residuals = residuals(&problem, &found)?;
        let excess = excess(&residuals).beyond(replicated(&problem, &found, seed)?);
        Ok(Self { sets, contest, problem, found, residuals, excess, seed })
    }

    /// The rig as it was found.
    ///
    /// # Errors
    /// None that the search has not met.
    pub fn rig(&self) -> Result<Rig, DiagnoseError> {
        Ok(self.problem.rig_at(&self.found.point.coordinates)?)
    }

    /// All hypotheses; those in time or frequency start where the residual of a few recordings points.
    fn hypotheses(&self) -> Result<Vec<Hypothesis>, DiagnoseError> {
        let (problem, found) = self.contest.null(Part::Few)?;
        let pointers = pointers::of(&self.contest.rig, &self.sets.few, &problem.expected(&found.point)?);
        Ok(hypothesis::all(&self.contest.rig, self.sets.load_n, &pointers))
    }

    /// The causes that explain what the rig leaves, two at most.
    ///
    /// # Errors
    /// What the simulation refuses of the rig without any of them.
    pub fn explain(&self, progress: &dyn Fn(&str)) -> Result<Explanation<'o>, DiagnoseError> {
        let hypotheses = self.hypotheses()?;
        let Ranking { contenders, dropped } = self.contest.run(&hypotheses, f64::NEG_INFINITY, progress)?;
        let Some(best) = self.best(contenders.clone()) else {
            return Ok(Explanation { contenders, dropped, ..Explanation::nothing(self.excess) });
        };
        let single = self.nearer(best, progress);
        let mut pair = self.second(&single, &hypotheses, progress)?;
        let left = pair.as_ref().map_or(&single, |pair| &pair.last).left;
        // Beside friction every look takes long.
        if left.is_more_than_chance()
            && self.excess.explained(&left) < EXPLAINED
            && !heeds_scatter(&single.cause.rig()?)
            && let Some(other) = self.another(&single)?
        {
            let beside_other = self.second(&self.nearer(other, progress), &hypotheses, progress)?;
            pair = pair.into_iter().chain(beside_other).min_by(|a, b| a.last.left.nats.total_cmp(&b.last.left.nats));
        }
        let pair = pair.map(|pair| self.exchanged(pair, &single.left, &hypotheses, progress)).transpose()?;
        let kept = pair.and_then(|pair| self.reduced(pair, &single)).unwrap_or_else(|| vec![single.clone()]);
        let last = kept.last().unwrap_or(&single);
        let gain = self.found.expansion.misfit() - last.cause.found.expansion.misfit();
        Ok(Explanation { contenders, dropped, left: last.left, gain, kept })
    }

    /// The best contender that gains enough and can be run everywhere: a rig that stands only as long as nothing shakes it is
    /// none.
    fn best(&self, rivals: Vec<Contender<'o>>) -> Option<Choice<'o>> {
        let leaves = |c: &Contender| {
            let all = excess(&residuals(&c.problem, &c.found)?);
            Ok::<_, DiagnoseError>(all.beyond(replicated(&c.problem, &c.found, self.seed)?))
        };
        let enough = rivals.iter().filter(|c| c.merit > LEAST_MERIT);
        let (cause, left) = enough.cloned().find_map(|c| {
            let left = leaves(&c).ok()?;
            Some((c, left))
        })?;
        Some(Choice { cause, rivals, left })
    }

    /// Whether what leaves this explains much and yet not all.
    fn is_worth_more(&self, left: &Excess) -> bool {
        left.is_more_than_chance() && (WORTH_MORE..EXACT).contains(&self.excess.explained(left))
    }

    /// The same, brought nearer where the search for it has stopped short of what it can explain.
    fn nearer(&self, choice: Choice<'o>, progress: &dyn Fn(&str)) -> Choice<'o> {
        if !self.is_worth_more(&choice.left) {
            return choice;
        }
        progress(&format!("fitting {} {} once more, slowly", choice.cause.name, choice.cause.place));
        let nearer = choice.cause.nearer(LEAST_MERIT).and_then(|cause| self.best(vec![cause]));
        match nearer {
            Some(nearer) => Choice { rivals: choice.rivals, ..nearer },
            None => choice,
        }
    }

    /// A rival that gains much by changing something else: of two causes a third may stand for the greater part of both, which
    /// then hides either.
    fn another(&self, first: &Choice<'o>) -> Result<Option<Choice<'o>>, DiagnoseError> {
        let of_first = residuals(&first.cause.problem, &first.cause.found)?;
        let like = |c: &Contender| Some(likeness(&self.residuals, &of_first, &residuals(&c.problem, &c.found).ok()?));
        let rivals = first.rivals.iter().filter(|c| c.gain > ANOTHER_GAINS * first.cause.gain);
        let rivals = rivals.filter_map(|c| Some((like(c)?, c))).filter(|(like, _)| *like < ALIKE);
        let other = rivals.min_by(|a, b| a.0.total_cmp(&b.0)).and_then(|(_, c)| self.best(vec![c.clone()]));
        // Those that gain more alone lose where both causes are there.
        let below = |other: &Choice| first.rivals.iter().filter(|c| c.merit <= other.cause.merit).cloned().collect();
        Ok(other.map(|other| Choice { rivals: below(&other), ..other }))
    }

    /// A second cause beside the first; nothing where none is worth its parameters.
    fn second(
        &self,
        first: &Choice<'o>,
        hypotheses: &[Hypothesis],
        progress: &dyn Fn(&str),
    ) -> Result<Option<Pair<'o>>, DiagnoseError> {
        let (cause, left) = (&first.cause, &first.left);
        let explained = self.excess.explained(left);
        // The random part of friction is not exact, least of all where it holds a mass: beside what stands by itself nothing is told.
        let stands_alone = (explained > EXPLAINED || !left.is_more_than_chance()) && heeds_scatter(&cause.rig()?);
        if explained < WORTH_A_SECOND || stands_alone {
            return Ok(None);
        }
        let least = least_of_a_second(cause, left);
        progress("looking for a second cause");
        let mut rivals = self.beside(&cause.problem, &cause.found.point, hypotheses, cause, least, progress)?;
        rivals.retain(|c| c.gain > least);
        let Some(best) = self.best(rivals) else { return Ok(None) };
        let last = self.nearer(best, progress);
        // What does not show by itself may be what the first cause's own linearisation leaves out.
        if !left.is_more_than_chance() && !self.beyond_replicates(cause, &last.cause)? {
            return Ok(None);
        }
        Ok(Some(Pair { first: first.clone(), last }))
    }

    /// The pair with each of its causes sought anew beside the other, as long as that gains and something is left: the first
    /// was found where the second was missing, and may have stood in for both, unless it left next to nothing.
    fn exchanged(
        &self,
        mut pair: Pair<'o>,
        left_by_first: &Excess,
        hypotheses: &[Hypothesis],
        progress: &dyn Fn(&str),
    ) -> Result<Pair<'o>, DiagnoseError> {
        if self.excess.explained(left_by_first) > RIGHT {
            return Ok(pair);
        }
        for _ in 0..EXCHANGES {
            if !self.is_worth_more(&pair.last.left) {
                break;
            }
            progress("looking for the first cause again, beside the second");
            let both = &pair.last.cause;
            let Some((problem, found)) = self.alone(both) else { break };
            let had = found.expansion.misfit() - both.found.expansion.misfit();
            let mut rivals = self.beside(&problem, &found.point, hypotheses, both, RIVALS_PROMISE * had, progress)?;
            rivals.retain(|c| c.cost() + LEAST_MERIT < both.cost());
            let Some(best) = self.best(rivals) else { break };
            pair = Pair { first: pair.last, last: self.nearer(best, progress) };
        }
        Ok(pair)
    }

    /// The contest for another cause beside that of a problem, which is part of the rig, its parameters fitted along.
    fn beside(
        &self,
        problem: &Problem<'o>,
        point: &Point,
        hypotheses: &[Hypothesis],
        cause: &Contender,
        least: f64,
        progress: &dyn Fn(&str),
    ) -> Result<Vec<Contender<'o>>, DiagnoseError> {
        let rig = problem.rig_at(&point.coordinates)?;
        let angles = Some(point.angles.clone());
        let contest = Contest { rig, unknown: problem.coordinates.clone(), angles, ..self.contest.clone() };
        let is_the_same = |h: &Hypothesis| h.name == cause.name && h.place == cause.place;
        let others: Vec<_> = hypotheses.iter().filter(|h| !is_the_same(h)).cloned().collect();
        // With a cause that is not the right one the rig may not stand in every recording: then there is no other.
        Ok(contest.run(&others, least, progress).unwrap_or_default().contenders)
    }

    /// A pair that takes away enough of what the first alone left; nothing where it does not. Where one has but stood in for
    /// the other, that one alone.
    fn reduced(&self, pair: Pair<'o>, single: &Choice<'o>) -> Option<Vec<Choice<'o>>> {
        let left = pair.last.left;
        if left.is_more_than_chance() && single.left.nats - left.nats < SECOND_EXPLAINS * single.left.nats {
            return None;
        }
        let both = &pair.last.cause;
        let alone = self.alone(both).filter(|(problem, found)| cost(problem, found) <= both.cost() + LEAST_MERIT);
        let Some((problem, found)) = alone else { return Some(vec![pair.first, pair.last]) };
        let gain = self.found.expansion.misfit() - found.expansion.misfit();
        let merit = cost(&self.problem, &self.found) - cost(&problem, &found);
        let cause = Contender { problem, found, merit, gain, ..both.clone() };
        Some(vec![Choice { cause, rivals: single.rivals.clone(), left }])
    }

    /// Whether a second cause gains more than it does on recordings that the first alone has made.
    fn beyond_replicates(&self, first: &Contender, both: &Contender) -> Result<bool, DiagnoseError> {
        let made = replicate(&first.rig()?, first.problem.observed, &first.found.point.angles, self.seed)?;
        let misfit = |of: &Contender| {
            let problem = Problem { observed: &made, ..of.problem.clone() };
            Ok::<_, RigError>(search(&problem, of.found.point.clone(), &Limits::default())?.expansion.misfit())
        };
        let by_chance = misfit(first)? - misfit(both)?;
        Ok(both.gain > BEYOND * by_chance.max(0.0) + LEAST_MERIT)
    }

    /// The last of two causes without the first, fitted; nothing where the rig does not stand so.
    fn alone(&self, both: &Contender<'o>) -> Option<(Problem<'o>, Found)> {
        let mut rig = both.rig().ok()?;
        let number = self.contest.rig.effects.len();
        rig.effects.remove(number);
        // Those of the rig, of the first and of the last; these are free still, under the number that it now has.
        let before = self.contest.unknown.len();
        let of_last = |c: &Coordinate| c.key.starts_with(&format!("effect[{}]", number + 2));
        let own = both.problem.coordinates.iter().position(of_last).unwrap_or(both.problem.coordinates.len());
        let renumbered = both.problem.coordinates[own..].iter().filter_map(|c| {
            let key = c.key.replace(&format!("effect[{}]", number + 2), &format!("effect[{}]", number + 1));
            Coordinate::of(&rig, &key)
        });
        let coordinates = self.contest.unknown.iter().cloned().chain(renumbered).collect();
        let problem = Problem::new(both.problem.observed, rig, coordinates);
        let mut point = both.found.point.clone();
        point.coordinates.drain(before..own);
        let found = search(&problem, point, &Limits::default()).ok()?;
        Some((problem, found))
    }
}

/// A cause, whom it was chosen among, and what it leaves.
#[derive(Clone, Debug)]
pub struct Choice<'o> {
    /// The cause.
    pub cause: Contender<'o>,
    /// It and the others, the best first.
    pub rivals: Vec<Contender<'o>>,
    /// Beyond what recordings of its rig would show.
    pub left: Excess,
}

impl Choice<'_> {
    /// Share of the cause among its rivals of other names in their posterior.
    pub fn probability(&self) -> f64 {
        let others = self.rivals.iter().filter(|c| c.name != self.cause.name);
        (1.0 / (1.0 + others.map(|c| (c.merit - self.cause.merit).exp()).sum::<f64>())).min(0.999)
    }
}

/// Two causes; the rig of the last has both.
struct Pair<'o> {
    first: Choice<'o>,
    last: Choice<'o>,
}

/// What the search for causes has found.
#[derive(Clone, Debug)]
pub struct Explanation<'o> {
    /// The best hypotheses as a first cause, the best first.
    pub contenders: Vec<Contender<'o>>,
    /// Those that were left behind before.
    pub dropped: Vec<Dropped>,
    /// What was kept, in the order in which it was found; the last has all of them in its rig.
    pub kept: Vec<Choice<'o>>,
    /// What the last leaves, beyond what recordings of its rig would show.
    pub left: Excess,
    /// What all of them together gain in ln L.
    pub gain: f64,
}

impl<'o> Explanation<'o> {
    /// No cause.
    pub fn nothing(left: Excess) -> Self {
        Self { contenders: Vec::new(), dropped: Vec::new(), kept: Vec::new(), left, gain: 0.0 }
    }

    /// The rig with all causes, as a problem and what was found; nothing where there are none.
    pub fn last(&self) -> Option<&Contender<'o>> {
        self.kept.last().map(|choice| &choice.cause)
    }

    /// Whether a cause of this name was kept.
    pub fn keeps(&self, name: &str) -> bool {
        self.kept.iter().any(|choice| choice.cause.name == name)
    }
}

/// ln L that a second cause must promise at the first look, and then gain. Where the first leaves nothing that shows by
/// itself, a second may yet show beside it, as far as what the first leaves is exact: of an effect on small motions the
/// rig's linearisation is not.
fn least_of_a_second(first: &Contender, left: &Excess) -> f64 {
    let exact = effect::definition(first.name).is_some_and(|d| d.deterministic);
    match (left.is_more_than_chance(), exact) {
        (true, _) => SECOND_GAINS * first.gain,
        (false, true) => (HIDDEN_GAINS * first.gain).max(LEAST_PROMISE),
        (false, false) => (INEXACT_GAINS * first.gain).max(LEAST_PROMISE),
    }
}

fn residuals(problem: &Problem, found: &Found) -> Result<Vec<Whitened>, DiagnoseError> {
    Ok(whitened(problem.observed, &problem.expected(&found.point)?))
}

/// The excess that recordings of this very rig would show: what the linearisation of its random part leaves out.
fn replicated(problem: &Problem, found: &Found, seed: u64) -> Result<Excess, DiagnoseError> {
    let rig = problem.rig_at(&found.point.coordinates)?;
    let expected = problem.expected(&found.point)?;
    let count = if heeds_scatter(&rig) { REPLICATES } else { 1 };
    let of = |n: u64| {
        let observed = replicate(&rig, problem.observed, &found.point.angles, seed.wrapping_add(n))?;
        Ok::<_, DiagnoseError>(excess(&whitened(&observed, &expected)))
    };
    Ok(Excess::mean(&(0..count).map(of).collect::<Result<Vec<_>, _>>()?))
}
