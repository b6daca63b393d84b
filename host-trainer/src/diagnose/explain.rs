//! What a bearing rig leaves of its recordings, and the one or two causes that explain it.

use super::DiagnoseError;
use super::compete::{Contender, Contest, Dropped, Part, Ranking, samples};
use super::hypothesis::{self, Hypothesis};
use super::pointers;
use super::prove::replicate;
use super::residual::{Excess, Whitened, excess, whitened};
use super::sets::Sets;
use crate::rig::{Rig, RigError, effect};
use crate::whittle::coordinate::Coordinate;
use crate::whittle::problem::{Point, Problem};
use crate::whittle::search::{Found, Limits, search};

/// ln L that a cause must gain beyond what its parameters are worth: some ninety explanations, each from many starts, were
/// tried on the same recordings.
pub const LEAST_MERIT: f64 = 12.0;
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
/// Times that a pair's causes are sought anew beside each other, the share of the excess from which a pair is worth that,
/// and the share of a cause's gain that others must promise to be tried in its place.
const EXCHANGES: usize = 2;
const WORTH_AN_EXCHANGE: f64 = 0.5;
const RIVALS_PROMISE: f64 = 0.3;

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
        Ok(Self { sets, contest, problem, found, residuals, excess })
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
    pub fn explain(&self, seed: u64, progress: &dyn Fn(&str)) -> Result<Explanation<'o>, DiagnoseError> {
        let hypotheses = self.hypotheses()?;
        let Ranking { contenders, dropped } = self.contest.run(&hypotheses, f64::NEG_INFINITY, progress)?;
        let Some((first, left)) = best(&contenders, seed) else {
            return Ok(Explanation { contenders, dropped, kept: Kept::nothing(self.excess) });
        };
        let single = Kept { causes: vec![first.clone()], rivals: vec![contenders.clone()], left };
        let kept = match self.second(&single, &hypotheses, seed, progress)? {
            Some(pair) => self.reduced(self.exchanged(pair, &hypotheses, seed, progress)?, &single)?.unwrap_or(single),
            None => single,
        };
        Ok(Explanation { contenders, dropped, kept })
    }

    /// A second cause beside the first; nothing where none is worth its parameters.
    fn second(
        &self,
        single: &Kept<'o>,
        hypotheses: &[Hypothesis],
        seed: u64,
        progress: &dyn Fn(&str),
    ) -> Result<Option<Kept<'o>>, DiagnoseError> {
        let Some(first) = single.causes.first() else { return Ok(None) };
        let least = least_of_a_second(first, &single.left);
        progress("looking for a second cause");
        let mut rivals = self.beside(&first.problem, &first.found.point, hypotheses, first, least, progress)?;
        rivals.retain(|c| c.gain > least);
        let Some((next, left)) = best(&rivals, seed) else { return Ok(None) };
        // What does not show by itself may be what the first cause's own linearisation leaves out.
        if !single.left.is_more_than_chance() && !beyond_replicates(first, next, seed)? {
            return Ok(None);
        }
        let causes = vec![first.clone(), next.clone()];
        Ok(Some(Kept { causes, rivals: vec![single.rivals[0].clone(), rivals], left }))
    }

    /// The pair with each of its causes sought anew beside the other, as long as that gains and something is left: the first
    /// was found where the second was missing, and may have stood in for both.
    fn exchanged(
        &self,
        mut pair: Kept<'o>,
        hypotheses: &[Hypothesis],
        seed: u64,
        progress: &dyn Fn(&str),
    ) -> Result<Kept<'o>, DiagnoseError> {
        for _ in 0..EXCHANGES {
            let hopeless = self.excess.explained(&pair.left) < WORTH_AN_EXCHANGE;
            let [_, next] = pair.causes.as_slice() else { break };
            if hopeless || !pair.left.is_more_than_chance() {
                break;
            }
            progress("looking for the first cause again, beside the second");
            let Some((problem, found)) = self.alone(next) else { break };
            let had = found.expansion.misfit() - next.found.expansion.misfit();
            let mut rivals = self.beside(&problem, &found.point, hypotheses, next, RIVALS_PROMISE * had, progress)?;
            rivals.retain(|c| costs(&c.problem, &c.found) + LEAST_MERIT < costs(&next.problem, &next.found));
            let Some((again, left)) = best(&rivals, seed) else { break };
            let again = again.clone();
            pair.causes.remove(0);
            pair.rivals.remove(0);
            pair.causes.push(again);
            pair.rivals.push(rivals);
            pair.left = left;
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
        let others: Vec<_> = hypotheses.iter().filter(|h| !is_of(cause, h)).cloned().collect();
        // With a cause that is not the right one the rig may not stand in every recording: then there is no other.
        Ok(contest.run(&others, least, progress).unwrap_or_default().contenders)
    }

    /// A pair that takes away enough of what the first left. Where the first has but stood in for the second, that one alone.
    fn reduced(&self, pair: Kept<'o>, single: &Kept<'o>) -> Result<Option<Kept<'o>>, DiagnoseError> {
        let left = single.left.nats;
        if pair.left.is_more_than_chance() && left - pair.left.nats < SECOND_EXPLAINS * left {
            return Ok(None);
        }
        let [_, both] = pair.causes.as_slice() else { return Ok(Some(pair)) };
        let Some((problem, found)) = self.alone(both) else { return Ok(Some(pair)) };
        if costs(&problem, &found) > costs(&both.problem, &both.found) + LEAST_MERIT {
            return Ok(Some(pair));
        }
        let gain = self.found.expansion.misfit() - found.expansion.misfit();
        let merit = costs(&self.problem, &self.found) - costs(&problem, &found);
        let alone = Contender { problem, found, merit, gain, ..both.clone() };
        Ok(Some(Kept { causes: vec![alone], rivals: vec![single.rivals[0].clone()], left: pair.left }))
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

/// Causes that are kept, in the order in which they were found; the last has all of them in its rig.
pub struct Kept<'o> {
    /// The causes.
    pub causes: Vec<Contender<'o>>,
    /// Whom each was chosen among.
    pub rivals: Vec<Vec<Contender<'o>>>,
    /// What they leave, beyond what recordings of their rig would show.
    pub left: Excess,
}

impl Kept<'_> {
    /// No cause.
    pub fn nothing(left: Excess) -> Self {
        Self { causes: Vec::new(), rivals: Vec::new(), left }
    }
}

/// What the search for causes has found.
pub struct Explanation<'o> {
    /// The best hypotheses as a first cause, the best first.
    pub contenders: Vec<Contender<'o>>,
    /// Those that were left behind before.
    pub dropped: Vec<Dropped>,
    /// What was kept.
    pub kept: Kept<'o>,
}

impl Explanation<'_> {
    /// Whether a cause of this name was kept.
    pub fn keeps(&self, name: &str) -> bool {
        self.kept.causes.iter().any(|k| k.name == name)
    }
}

/// The best contender that gains enough and can be run everywhere, and what it leaves: a rig that stands only as long as
/// nothing shakes it is none.
fn best<'c, 'o>(contenders: &'c [Contender<'o>], seed: u64) -> Option<(&'c Contender<'o>, Excess)> {
    contenders.iter().filter(|c| c.merit > LEAST_MERIT).find_map(|c| Some((c, remaining(c, seed).ok()?)))
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

/// −ln L, and half the logarithm of the count of samples for each parameter.
fn costs(problem: &Problem, found: &Found) -> f64 {
    found.expansion.misfit() + 0.5 * problem.coordinates.len() as f64 * samples(problem.observed).ln()
}

/// Whether a second cause gains more than it does on recordings that the first alone has made.
fn beyond_replicates(first: &Contender, both: &Contender, seed: u64) -> Result<bool, DiagnoseError> {
    let made = replicate(&first.rig()?, first.problem.observed, &first.found.point.angles, seed)?;
    let misfit = |of: &Contender| {
        let problem = Problem { observed: &made, ..of.problem.clone() };
        Ok::<_, RigError>(search(&problem, of.found.point.clone(), &Limits::default())?.expansion.misfit())
    };
    let by_chance = misfit(first)? - misfit(both)?;
    Ok(both.gain > BEYOND * by_chance.max(0.0) + LEAST_MERIT)
}

fn is_of(contender: &Contender, hypothesis: &Hypothesis) -> bool {
    hypothesis.name == contender.name && hypothesis.place == contender.place
}

/// What a contender leaves beyond what its own replicates do.
fn remaining(contender: &Contender, seed: u64) -> Result<Excess, DiagnoseError> {
    let all = excess(&residuals(&contender.problem, &contender.found)?);
    Ok(all.beyond(replicated(&contender.problem, &contender.found, seed)?))
}

fn residuals(problem: &Problem, found: &Found) -> Result<Vec<Whitened>, DiagnoseError> {
    Ok(whitened(problem.observed, &problem.expected(&found.point)?))
}

/// The excess that recordings of this very rig would show: what the linearisation of its random part leaves out.
fn replicated(problem: &Problem, found: &Found, seed: u64) -> Result<Excess, DiagnoseError> {
    let rig = problem.rig_at(&found.point.coordinates)?;
    let expected = problem.expected(&found.point)?;
    let observed = replicate(&rig, problem.observed, &found.point.angles, seed)?;
    Ok(excess(&whitened(&observed, &expected)))
}
