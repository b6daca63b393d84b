//! Diagnosis of the 5-DoF rig by its likelihood.
//!
//! 1. Faults of the acquisition are found and taken out ([`acquisition`](super::acquisition)).
//! 2. The rig as it is, its unknown parameters and the angles fitted, leaves a residual; [`residual`](super::residual)
//!    says whether chance could have left it.
//! 3. Every hypothesis is brought as near as it can come ([`compete`](super::compete)), on recordings without the last.
//!    The best is kept where it gains more than its parameters are worth. A second one is sought in the same way in what
//!    it leaves.
//! 4. What is kept stands where it gains more on the recording that took no part than chance gives
//!    ([`prove`](super::prove)), and takes away most of what there was to explain. Where something is left and nothing
//!    stands, nothing in the vocabulary explains it.

use super::acquisition::Acquired;
use super::compete::{Contender, Contest, Dropped, Part, Ranking, samples};
use super::hypothesis::{self, Hypothesis};
use super::outcome::{Cause, Diagnosis, Location, Outcome, SCHEMA, Verdict};
use super::prove::{Proof, prove, replicate, shown};
use super::residual::{Excess, Whitened, excess, tests, whitened};
use super::statement;
use super::{DiagnoseError, Task};
use super::{locate, pointers, recorded};
use crate::calibrate::bearing::{Options, calibrate};
use crate::calibrate::split::{Split, part};
use crate::recording::Recording;
use crate::rig::{Rig, RigError, effect};
use crate::whittle::coordinate::Coordinate;
use crate::whittle::observed::Observed;
use crate::whittle::problem::{Point, Problem};
use crate::whittle::search::{Found, Limits, search};

/// ln L that a cause must gain beyond what its parameters are worth: some ninety explanations, each from many starts, were
/// tried on the same recordings.
pub(super) const LEAST_MERIT: f64 = 12.0;
/// Share of the excess that causes must take away to be an explanation; of what the first leaves, that a second must.
const EXPLAINED: f64 = 0.97;
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
/// p-value on the recording that took no part.
const LEAST_P: f64 = 0.01;
/// Length of the beginnings that all hypotheses are first tried on, s.
const BRIEF_S: f64 = 0.4;

/// Diagnoses recordings of a bearing rig, at least one.
///
/// # Errors
/// Recordings without acceleration, speed or load; a rig that cannot run.
pub fn diagnose(task: &Task, progress: &dyn Fn(&str)) -> Result<Outcome, DiagnoseError> {
    let Task { recordings, seed, .. } = *task;
    let rig = match measure(task, progress)? {
        Measure::Waveforms(rig) => rig,
        Measure::Rhythm(rig) => return recorded::diagnose(&Task { rig: &rig, ..*task }, progress),
    };
    let acquired = Acquired::of(&rig, recordings)?;
    let sets = Sets::of(&acquired.recordings)?;
    progress("fitting the rig as it is");
    let ground = Ground::of(&rig, &sets, seed)?;
    // What was cut off is lost, and with it what another cause could be known by.
    let explanation = if acquired.clipped.is_empty() {
        ground.explain(seed, progress)?
    } else {
        Explanation {
            contenders: Vec::new(),
            dropped: Vec::new(),
            kept: Vec::new(),
            rivals: Vec::new(),
            left: ground.excess,
        }
    };
    let judgement = Judgement::of(&ground, &explanation, seed, progress)?;
    outcome(recordings, &acquired, &ground, &explanation, judgement, seed, progress)
}

/// The rig that recordings are measured by.
enum Measure {
    /// Of the right kind, so that waveforms count.
    Waveforms(Rig),
    /// With a transmission path in the place of a structure that is not the rig's, so that only the rhythm counts.
    Rhythm(Rig),
}

fn measure(task: &Task, progress: &dyn Fn(&str)) -> Result<Measure, DiagnoseError> {
    let Task { rig, baseline, recordings, seed } = *task;
    if let Some(baseline) = baseline {
        progress("calibrating to the baseline");
        let rig = calibrate(rig, baseline, &Options { seed, ..Options::default() }, progress)?.rig;
        return Ok(if rig.paths.is_empty() { Measure::Waveforms(rig) } else { Measure::Rhythm(rig) });
    }
    if !rig.unknown.is_empty() {
        progress("fitting the rig's unknown parameters");
        if let Some(rig) = recorded::beyond_the_rig(rig, recordings, seed)? {
            return Ok(Measure::Rhythm(rig));
        }
    }
    Ok(Measure::Waveforms(rig.clone()))
}

/// Recordings by the part that they take.
struct Sets {
    split: Split,
    fitted: Vec<Observed>,
    held_out: Vec<Observed>,
    /// Those of the least and the greatest load among the fitted ones, and which these are: what depends on the load shows
    /// between them.
    few: Vec<Observed>,
    which: Vec<usize>,
    /// Their beginnings.
    brief: Vec<Observed>,
    /// Mean over all recordings.
    load_n: f64,
}

impl Sets {
    fn of(recordings: &[Recording]) -> Result<Self, DiagnoseError> {
        let split = Split::of(recordings);
        let which = extremes(&split.fitted);
        let few: Vec<Recording> = which.iter().map(|n| split.fitted[*n].clone()).collect();
        let beginning = |r: &Recording| part(r, 0..r.len().min((BRIEF_S * r.sample_rate_hz) as usize));
        let brief: Vec<Recording> = few.iter().map(beginning).collect();
        Ok(Self {
            fitted: Observed::of_all(&split.fitted)?,
            held_out: Observed::of_all(&split.held_out)?,
            few: Observed::of_all(&few)?,
            which,
            brief: Observed::of_all(&brief)?,
            load_n: recordings.iter().filter_map(|r| r.load_n).sum::<f64>() / recordings.len() as f64,
            split,
        })
    }
}

/// The recordings of the least and of the greatest load; one where that is the same.
fn extremes(recordings: &[Recording]) -> Vec<usize> {
    let load = |n: &usize| recordings[*n].load_n.unwrap_or_default();
    let least = (0..recordings.len()).min_by(|a, b| load(a).total_cmp(&load(b)));
    let greatest = (0..recordings.len()).max_by(|a, b| load(a).total_cmp(&load(b)));
    least.into_iter().chain(greatest.filter(|g| Some(*g) != least)).collect()
}

/// The rig as it is, fitted, and what it leaves.
struct Ground<'o> {
    sets: &'o Sets,
    contest: Contest<'o>,
    problem: Problem<'o>,
    found: Found,
    residuals: Vec<Whitened>,
    /// Beyond what recordings of this very rig would show.
    excess: Excess,
}

impl<'o> Ground<'o> {
    fn of(rig: &Rig, sets: &'o Sets, seed: u64) -> Result<Self, DiagnoseError> {
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

    fn rig(&self) -> Result<Rig, DiagnoseError> {
        Ok(self.problem.rig_at(&self.found.point.coordinates)?)
    }

    /// All hypotheses; those in time or frequency start where the residual of a few recordings points.
    fn hypotheses(&self) -> Result<Vec<Hypothesis>, DiagnoseError> {
        let (problem, found) = self.contest.null(Part::Few)?;
        let pointers = pointers::of(&self.contest.rig, &self.sets.few, &problem.expected(&found.point)?);
        Ok(hypothesis::all(&self.contest.rig, self.sets.load_n, &pointers))
    }

    /// The causes that explain what the rig leaves, two at most.
    fn explain(&self, seed: u64, progress: &dyn Fn(&str)) -> Result<Explanation<'o>, DiagnoseError> {
        let hypotheses = self.hypotheses()?;
        let Ranking { contenders, dropped } = self.contest.run(&hypotheses, f64::NEG_INFINITY, progress)?;
        let mut out = Explanation { contenders, dropped, kept: Vec::new(), rivals: Vec::new(), left: self.excess };
        let Some((first, left)) = best(&out.contenders, seed) else { return Ok(out) };
        let single = Kept { causes: vec![first.clone()], rivals: vec![out.contenders.clone()], left };
        let kept = match self.second(&single, &hypotheses, seed, progress)? {
            Some(pair) => self.reduced(self.exchanged(pair, &hypotheses, seed, progress)?, &single)?.unwrap_or(single),
            None => single,
        };
        (out.kept, out.rivals, out.left) = (kept.causes, kept.rivals, kept.left);
        Ok(out)
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

/// Causes that are kept, the last with all of them in its rig.
struct Kept<'o> {
    causes: Vec<Contender<'o>>,
    /// Whom each was chosen among.
    rivals: Vec<Vec<Contender<'o>>>,
    /// What they leave, beyond what recordings of their rig would show.
    left: Excess,
}

/// What the search for causes has found.
pub(super) struct Explanation<'o> {
    /// The best hypotheses as a first cause, the best first.
    pub contenders: Vec<Contender<'o>>,
    /// Those that were left behind before.
    pub dropped: Vec<Dropped>,
    /// What was kept, in the order in which it was found; the last has all of them in its rig.
    pub kept: Vec<Contender<'o>>,
    /// Whom each of those was chosen among.
    pub rivals: Vec<Vec<Contender<'o>>>,
    /// What the last leaves, beyond what recordings of its rig would show.
    pub left: Excess,
}

impl Explanation<'_> {
    /// Whether a contender of this name was kept.
    pub fn keeps(&self, name: &str) -> bool {
        self.kept.iter().any(|k| k.name == name)
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

/// Whether an explanation stands.
struct Judgement {
    /// Share of the excess that it takes away.
    explained: f64,
    /// What it does to recordings that took no part; `None` where nothing was kept, or cannot be run there.
    proof: Option<Proof>,
    stands: bool,
    /// Of the machine, whatever the acquisition does.
    verdict: Verdict,
}

impl Judgement {
    fn of(
        ground: &Ground,
        explanation: &Explanation,
        seed: u64,
        progress: &dyn Fn(&str),
    ) -> Result<Self, DiagnoseError> {
        let (excess, left) = (ground.excess, explanation.left);
        let explained = excess.explained(&left);
        let proof = match explanation.kept.last() {
            Some(last) => {
                progress("proving it on what took no part");
                // A rig that cannot be run under the condition that was held out is not proved.
                prove(&ground.rig()?, &last.rig()?, &ground.sets.held_out, seed).ok()
            }
            None => None,
        };
        let proven = proof.as_ref().is_some_and(|p| p.p_value < LEAST_P && p.after < p.before);
        let stands = proven && (!left.is_more_than_chance() || explained > EXPLAINED);
        let verdict = if stands {
            Verdict::Mismatch
        } else if excess.is_more_than_chance() {
            Verdict::Unexplained
        } else {
            Verdict::NoMismatch
        };
        Ok(Self { explained, proof, stands, verdict })
    }
}

/// Faults of the acquisition and causes in the machine together; `raw` are the recordings with the faults in them.
fn outcome(
    raw: &[Recording],
    acquired: &Acquired,
    ground: &Ground,
    explanation: &Explanation,
    judgement: Judgement,
    seed: u64,
    progress: &dyn Fn(&str),
) -> Result<Outcome, DiagnoseError> {
    let Judgement { explained, proof, stands, verdict } = judgement;
    let (rig, split) = (&ground.contest.rig, &ground.sets.split);
    let (problem, found) = match explanation.kept.last() {
        Some(last) if stands => (&last.problem, &last.found),
        _ => (&ground.problem, &ground.found),
    };
    let mut corrected = problem.rig_at(&found.point.coordinates)?;
    let (values, fitted) = statement::parameters(problem, found, rig, ground.contest.unknown.len());
    let mut causes: Vec<Cause> = acquired.faults().map(statement::of_fault).collect();
    if stands {
        causes.extend(statement::causes(&corrected, rig, &values, explanation, proof.as_ref()));
    }
    corrected.effects.extend(acquired.faults().rev().map(|fault| fault.effect.clone()));
    let faulty = acquired.faults().next().is_some();
    let verdict = if faulty { Verdict::Mismatch } else { verdict };
    let location = match verdict {
        Verdict::NoMismatch => Location::default(),
        _ => locate::locate(rig, &corrected, &ground.sets.fitted, &ground.residuals),
    };
    let (fit, held_out) = if faulty {
        progress("showing it on what took no part");
        let p_value = acquired.faults().map(|fault| fault.p_value).fold(0.0, f64::max);
        shown(rig, &corrected, &Observed::of_all(&Split::of(raw).held_out)?, &split.describe(), p_value, seed)?
    } else {
        statement::fit(proof, stands, split.describe())
    };
    let rejected = statement::rejected(explanation, stands, explained);
    let caveats = if verdict == Verdict::Unexplained { vec![too_little(explained)] } else { Vec::new() };
    let diagnosis = Diagnosis { schema: SCHEMA, verdict, causes, rejected, location, fit };
    Ok(Outcome { diagnosis, rig: corrected, held_out, tests: tests(&ground.residuals), fitted, caveats })
}

fn too_little(explained: f64) -> String {
    format!(
        "The best explanation in the vocabulary takes away {:.0} % of what the rig leaves unexplained; {:.0} % are asked for.",
        100.0 * explained.max(0.0),
        100.0 * EXPLAINED
    )
}
