//! Model selection: every hypothesis is screened, the best are fitted and ranked by their BIC gain.

use crate::rig::config::RigKey;
use crate::rig::effect::EffectKind;
use crate::rig::effect::ParameterKey;
use rayon::prelude::*;

use super::hypothesis::{self, Hypothesis, Start};
use super::residual::{EDGE, lack_of_fit, whitened};
use super::screening::{Stakes, screen};
use super::start_score::{NullPrediction, StartScore};
use crate::identify::likelihood::coordinate::Coordinate;
use crate::identify::likelihood::observed::Observed;
use crate::identify::likelihood::problem::{Point, Problem};
use crate::identify::likelihood::search::{Limits, Optimum, search, search_from_rig};
use crate::rig::simulate::fewest_substeps;
use crate::rig::{Rig, RigError};

/// Hypotheses that are searched on the few recordings, and of those the ones that are on all, where a step a sample does.
const SEARCHED: usize = 10;
const FULL_FITS: usize = 4;
/// The fewest of them where more steps have to be taken, and the most steps that count.
const LEAST_SEARCHED: usize = 4;
const LEAST_FULL_FITS: usize = 2;
const MOST_WORK: usize = 4;
/// Searched at a time: one alone leaves a second core idle in the steps between its simulations. The second of them is searched
/// even where what the first gains leaves it no rival.
const SIDE_BY_SIDE: usize = 2;
/// Of either, those of one name at most: a race may be wavy in some thirty ways.
const SEARCHED_OF_A_NAME: usize = 4;
const FULL_FITS_OF_A_NAME: usize = 2;
/// Of those that are searched, the first so many that promise most are searched slowly too, where a step a sample does.
const SLOWLY: usize = 5;
/// A search of a part of the recordings.
const QUICK: Limits = Limits { steps: 6, least_increment: 1.0, change: 0.5 };
/// Steps of a finalist's search.
const STEPS: usize = 20;
/// Where one hypothesis leaves nothing to explain, only those that promise at least this share of its gain are rivals; where
/// it leaves something, this.
const RIVAL: f64 = 0.3;
const DISTANT_RIVAL: f64 = 0.03;
/// Shares of the band that a search goes through, from what turns slowly to all: slow parts have few wrong places to end.
const BANDS: [f64; 3] = [0.06, 0.2, 1.0];

/// Hypothesis with its best parameters.
#[derive(Clone, Debug)]
pub struct Candidate<'o> {
    /// Name in the vocabulary.
    pub kind: EffectKind,
    /// Component, channel or lobes; empty if there is no choice.
    pub place: String,
    /// Likelihood problem of the fit.
    pub problem: Problem<'o>,
    /// Optimum of the fit.
    pub found: Optimum,
    /// Gain in half the BIC over the rig without the effect, by [`half_bic`].
    pub bic_gain: f64,
    /// Gain in ln L over the rig without the effect.
    pub log_likelihood_gain: f64,
}

impl Candidate<'_> {
    /// Rig with the fitted effect.
    ///
    /// # Errors
    /// Errors of the rig, none that the search has not met.
    pub fn rig(&self) -> Result<Rig, RigError> {
        self.problem.rig_at(&self.found.point.coordinates)
    }

    /// Half the Bayesian information criterion of the fit, by [`half_bic`].
    pub fn half_bic(&self) -> f64 {
        half_bic(&self.problem, &self.found)
    }

    /// Candidate refitted from low to high frequencies; `None` if that gains less than `least` in ln L. A search of all
    /// frequencies at once may stop at a local optimum that low frequencies exclude.
    pub fn refined(&self, least: f64) -> Option<Self> {
        let found =
            search_slowly(&self.problem, self.found.point.clone(), &Limits { steps: STEPS, ..Limits::default() })?;
        let more = self.found.expansion.neg_log_likelihood() - found.expansion.neg_log_likelihood();
        (more > least).then(|| Self {
            found,
            bic_gain: self.bic_gain + more,
            log_likelihood_gain: self.log_likelihood_gain + more,
            ..self.clone()
        })
    }
}

/// Half the Bayesian information criterion: −ln L plus half the logarithm of the sample count per parameter (G. Schwarz, Annals of Statistics 6 (1978)
/// 461–464).
pub fn half_bic(problem: &Problem, found: &Optimum) -> f64 {
    found.expansion.neg_log_likelihood() + 0.5 * problem.coordinates.len() as f64 * samples(problem.observed).ln()
}

fn samples(observed: &[Observed]) -> f64 {
    observed.iter().map(|o| o.condition.samples).sum::<usize>() as f64
}

/// Result of a model selection.
#[derive(Clone, Debug, Default)]
pub struct Ranking<'o> {
    /// Candidates fitted to all recordings, the best first.
    pub candidates: Vec<Candidate<'o>>,
    /// Hypotheses dropped after screening or after the fit to a subset of the recordings.
    pub dropped: Vec<Dropped>,
}

/// Hypothesis that was dropped.
#[derive(Clone, Debug)]
pub struct Dropped {
    /// Name in the vocabulary.
    pub kind: EffectKind,
    /// Component, channel or lobes; empty if there is no choice.
    pub place: String,
    /// Expected gain in ln L on all recordings.
    pub log_likelihood_gain: f64,
    /// Stage at which it was dropped.
    pub at: Stage,
}

/// Stage at which a hypothesis is dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// After screening.
    Screened,
    /// After the fit to a subset of the recordings.
    Fitted,
    /// After a fit with implausible parameters, outside the recordings, or that cannot be simulated.
    Invalid,
}

impl Dropped {
    fn new(hypothesis: &Hypothesis, log_likelihood_gain: f64, at: Stage) -> Self {
        Self { kind: hypothesis.kind, place: hypothesis.place.clone(), log_likelihood_gain, at }
    }
}

/// Recordings and rig of a model selection.
#[derive(Clone, Debug)]
pub struct ModelSelection<'o> {
    /// All fitted recordings.
    pub all: &'o [Observed],
    /// Beginnings of the subset, for screening.
    pub beginnings: &'o [Observed],
    /// Subset of the recordings, whole, for effects that their beginnings do not show.
    pub subset: &'o [Observed],
    /// Indices of the subset among all.
    pub which: &'o [usize],
    /// Rig without the sought effect; its unknown parameters are fitted with every hypothesis.
    pub rig: Rig,
    /// Unknown parameters of the rig.
    pub unknown: Vec<Coordinate>,
    /// Initial angles of all recordings, rad, if known.
    pub angles: Option<Vec<[f64; 2]>>,
}

/// Part of the recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// All recordings, whole.
    All,
    /// Subset, whole.
    Subset,
    /// Beginnings of the subset.
    Beginnings,
}

impl<'o> ModelSelection<'o> {
    /// Null model of a part: the rig without the sought effect, fitted.
    ///
    /// # Errors
    /// Errors of the simulation.
    pub fn null(&self, part: Part) -> Result<(Problem<'o>, Optimum), RigError> {
        let problem = Problem::new(self.observed(part), self.rig.clone(), self.unknown.clone());
        let found = match self.known(part) {
            // Parts begin where all have ended.
            Some(angles) => {
                let limits = if part == Part::All { Limits::default() } else { QUICK };
                search(&problem, problem.start_at(angles), &limits)?
            }
            None => search_from_rig(&problem)?,
        };
        Ok((problem, found))
    }

    /// Angles of a part, where they are known.
    fn known(&self, part: Part) -> Option<Vec<[f64; 2]>> {
        let all = self.angles.as_ref()?;
        Some(match part {
            Part::All => all.clone(),
            Part::Subset | Part::Beginnings => self.which.iter().map(|n| all[*n]).collect(),
        })
    }

    fn observed(&self, part: Part) -> &'o [Observed] {
        match part {
            Part::All => self.all,
            Part::Subset => self.subset,
            Part::Beginnings => self.beginnings,
        }
    }

    /// Ranking of the hypotheses; those that cannot be simulated are left out, those whose expected gain is less than
    /// `least` are dropped after screening.
    ///
    /// # Errors
    /// Errors of the simulation of the null model.
    pub fn run(&self, hypotheses: &[Hypothesis], least: f64, progress: &dyn Fn(&str)) -> Result<Ranking<'o>, RigError> {
        let bare = self.null(Part::All)?;
        // Where there is little to explain, leaving little of it says nothing.
        let explainable = !leaves_nothing(&bare.0, &bare.1)?;
        progress("screening all candidates");
        let screened = self.screen(hypotheses, least)?;
        let mut dropped = Vec::new();
        let subset_fits =
            self.subset_fits(screened, least, &mut PruningThreshold::new(explainable), &mut dropped, progress)?;
        let mut candidates =
            self.full_fit(subset_fits, &bare, &mut PruningThreshold::new(explainable), &mut dropped, progress)?;
        candidates.sort_by(|a, b| b.bic_gain.total_cmp(&a.bic_gain));
        dropped.sort_by(|a, b| b.at.cmp(&a.at).then(b.log_likelihood_gain.total_cmp(&a.log_likelihood_gain)));
        Ok(Ranking { candidates, dropped })
    }

    /// What every hypothesis scores on a few recordings or their beginnings, the most promising first.
    fn screen<'h>(&self, hypotheses: &'h [Hypothesis], least: f64) -> Result<Vec<ScreeningResult<'h, 'o>>, RigError> {
        let mut screened: Vec<ScreeningResult> = Vec::new();
        for part in [Part::Beginnings, Part::Subset] {
            let observed = self.observed(part);
            let fits = |h: &Hypothesis| h.needs_whole_recordings() == (part == Part::Subset);
            let these: Vec<_> = hypotheses.iter().enumerate().filter(|(_, h)| fits(h)).collect();
            if these.is_empty() {
                continue;
            }
            let bare = self.null(part)?;
            let neg_log_likelihood = bare.1.expansion.neg_log_likelihood();
            let fitted = bare.0.rig_at(&bare.1.point.coordinates)?;
            let soft = Self { rig: hypothesis::softened(&self.rig), ..self.clone() };
            let (problem, found) = if soft.rig == self.rig { bare } else { soft.null(part)? };
            let expected = problem.predict(&found.point)?;
            let rig = problem.rig_at(&found.point.coordinates)?;
            let null = NullPrediction::new(&rig, observed, found.point.angles.clone(), expected)?;
            // A gain grows with what is looked at.
            let scale = samples(self.all) / samples(observed);
            let most = screened.iter().map(|l| l.score.log_likelihood_gain).fold(0.0, f64::max);
            let stakes = Stakes { least: least / scale, others: most / scale };
            screened.extend(screen(&null, &rig, &these, stakes)?.into_iter().map(|p| ScreeningResult {
                hypothesis: &hypotheses[p.hypothesis],
                score: StartScore { log_likelihood_gain: p.log_likelihood_gain * scale, ..p },
                observed,
                rig: fitted.clone(),
                neg_log_likelihood,
                scale,
            }));
        }
        screened.sort_by(|a, b| b.score.log_likelihood_gain.total_cmp(&a.score.log_likelihood_gain));
        Ok(screened)
    }

    /// Those that promise most, fitted to what they were looked at on; the best first.
    fn subset_fits<'h>(
        &self,
        screened: Vec<ScreeningResult<'h, 'o>>,
        least: f64,
        bar: &mut PruningThreshold,
        dropped: &mut Vec<Dropped>,
        progress: &dyn Fn(&str),
    ) -> Result<Vec<SubsetFit<'h>>, RigError> {
        let mut subset_fits: Vec<SubsetFit> = Vec::new();
        let (mut n, mut done) = (0, 0);
        let mut screened = screened.into_iter();
        while screened.len() > 0 {
            let entries = some_of(&mut screened, |look, together: &[Entry]| {
                let ScreeningResult { hypothesis, score, .. } = &look;
                let before = subset_fits.iter().map(|h| h.hypothesis).chain(together.iter().map(|e| e.look.hypothesis));
                let crowd = before.filter(|h| h.kind == hypothesis.kind).count();
                let full = n >= LEAST_SEARCHED && done >= SEARCHED || crowd >= SEARCHED_OF_A_NAME;
                if full || score.log_likelihood_gain < least || bar.is_above(score.log_likelihood_gain) {
                    dropped.push(Dropped::new(hypothesis, score.log_likelihood_gain, Stage::Screened));
                    return None;
                }
                n += 1;
                progress(&format!("fitting {} {} ({n} of {SEARCHED})", hypothesis.kind, hypothesis.place));
                let problem = self.problem(&look.rig, look.observed, &score.start)?;
                let slowly = done < SLOWLY;
                done += work(&problem);
                Some(Entry { look, problem, slowly })
            });
            let found: Vec<Option<Optimum>> = entries.par_iter().map(Entry::searched).collect();
            for (Entry { look, problem, .. }, found) in entries.into_iter().zip(found) {
                let ScreeningResult { hypothesis, score, neg_log_likelihood, scale, .. } = look;
                let Some(found) = found else { continue };
                let log_likelihood_gain = (neg_log_likelihood - found.expansion.neg_log_likelihood()) * scale;
                let Some(effect) = problem.rig_at(&found.point.coordinates)?.effects.pop() else { continue };
                if !effect.is_plausible() {
                    dropped.push(Dropped::new(hypothesis, log_likelihood_gain, Stage::Invalid));
                    continue;
                }
                bar.raise(log_likelihood_gain, &problem, &found)?;
                subset_fits.push(SubsetFit {
                    log_likelihood_gain,
                    hypothesis,
                    start: Start { effect, ..score.start },
                    found,
                });
            }
        }
        subset_fits.sort_by(|a, b| b.log_likelihood_gain.total_cmp(&a.log_likelihood_gain));
        Ok(subset_fits)
    }

    /// The best of those, fitted to all recordings.
    fn full_fit(
        &self,
        subset_fits: Vec<SubsetFit>,
        (bare, null): &(Problem<'o>, Optimum),
        bar: &mut PruningThreshold,
        dropped: &mut Vec<Dropped>,
        progress: &dyn Fn(&str),
    ) -> Result<Vec<Candidate<'o>>, RigError> {
        let mut candidates: Vec<Candidate> = Vec::new();
        let (mut n, mut done) = (0, 0);
        let mut subset_fits = subset_fits.into_iter();
        while subset_fits.len() > 0 {
            let finalists = some_of(&mut subset_fits, |subset_fit, together: &[SubsetFit]| {
                let Hypothesis { kind, place, .. } = subset_fit.hypothesis;
                let before = candidates.iter().map(|c| c.kind).chain(together.iter().map(|h| h.hypothesis.kind));
                let crowd = before.filter(|other| other == kind).count();
                let full = n >= LEAST_FULL_FITS && done >= FULL_FITS || crowd >= FULL_FITS_OF_A_NAME;
                // Two at least: the best is told from another by what either gains on all.
                if full || n > 1 && bar.is_above(subset_fit.log_likelihood_gain) {
                    dropped.push(Dropped::new(subset_fit.hypothesis, subset_fit.log_likelihood_gain, Stage::Fitted));
                    return None;
                }
                n += 1;
                progress(&format!("fitting {kind} {place} to all recordings ({n} of {FULL_FITS})"));
                Some(subset_fit)
            });
            let fitted: Vec<_> = finalists.par_iter().map(|subset_fit| self.fitted_to_all(subset_fit, null)).collect();
            for (subset_fit, fitted) in finalists.into_iter().zip(fitted) {
                let Some((problem, found)) = fitted else {
                    dropped.push(Dropped::new(subset_fit.hypothesis, subset_fit.log_likelihood_gain, Stage::Invalid));
                    continue;
                };
                let log_likelihood_gain = null.expansion.neg_log_likelihood() - found.expansion.neg_log_likelihood();
                done += work(&problem);
                bar.raise(log_likelihood_gain, &problem, &found)?;
                let bic_gain = half_bic(bare, null) - half_bic(&problem, &found);
                let Hypothesis { kind, place, .. } = subset_fit.hypothesis;
                candidates.push(Candidate {
                    kind: *kind,
                    place: place.clone(),
                    problem,
                    found,
                    bic_gain,
                    log_likelihood_gain,
                });
            }
        }
        Ok(candidates)
    }

    /// Nothing where it cannot be simulated under all conditions, or comes to what [`Stage::Invalid`] says.
    fn fitted_to_all(&self, subset_fit: &SubsetFit, null: &Optimum) -> Option<(Problem<'o>, Optimum)> {
        let problem = self.problem(&self.rig, self.all, &subset_fit.start)?;
        let rig = problem.rig_at(&subset_fit.found.point.coordinates).ok()?;
        // Where it has been fitted already, its angles are known.
        let fitted: Vec<(usize, [f64; 2])> =
            self.which.iter().copied().zip(subset_fit.found.point.angles.iter().copied()).collect();
        let angles = problem.aligned_given(&rig, &self.rig, &null.point.angles, &fitted).ok()?;
        let from = Point { angles, ..subset_fit.found.point.clone() };
        let limits = Limits { steps: STEPS, ..Limits::default() };
        let mut found = search(&problem, from, &limits).ok()?;
        let latched = problem.latched(&found.point).ok()?;
        if latched != found.point {
            found = search(&problem, latched, &limits).ok()?;
        }
        // Before a recording, or at its ends, an impact stands for the jump that the ends are.
        let effect = problem.rig_at(&found.point.coordinates).ok()?.effects.pop()?;
        let inside = |time_s: f64| self.all.iter().all(|o| o.condition.is_within(time_s, EDGE));
        (effect.number(ParameterKey::TimeS).is_none_or(inside) && effect.is_plausible()).then_some((problem, found))
    }

    /// A hypothesis beside a rig, the selection's with its unknown parameters at other values.
    fn problem(&self, rig: &Rig, observed: &'o [Observed], start: &Start) -> Option<Problem<'o>> {
        let effect = hypothesis::sharpened(rig.bearing()?, start.effect.clone());
        let rig = rig.clone().with_effect(effect);
        rig.check().ok()?;
        let index = rig.effects.len() - 1;
        let own = start.free.iter().map(|key| Coordinate::for_key(&rig, RigKey::Effect { index, key: *key }));
        let coordinates = self.unknown.iter().cloned().map(Some).chain(own).collect::<Option<Vec<_>>>()?;
        Some(Problem::new(observed, rig, coordinates))
    }
}

/// How much a hypothesis must gain to be a rival of those that have been fitted.
struct PruningThreshold {
    /// Whether there is so much to explain that leaving nothing of it says something.
    explainable: bool,
    log_likelihood_gain: f64,
}

impl PruningThreshold {
    fn new(explainable: bool) -> Self {
        Self { explainable, log_likelihood_gain: f64::NEG_INFINITY }
    }

    /// Raises it to what a fitted hypothesis asks of its rivals.
    fn raise(&mut self, log_likelihood_gain: f64, problem: &Problem, found: &Optimum) -> Result<(), RigError> {
        let explains = self.explainable && leaves_nothing(problem, found)?;
        self.log_likelihood_gain =
            self.log_likelihood_gain.max(log_likelihood_gain * if explains { RIVAL } else { DISTANT_RIVAL });
        Ok(())
    }

    /// Whether one that gains as little is no rival.
    fn is_above(&self, log_likelihood_gain: f64) -> bool {
        log_likelihood_gain < self.log_likelihood_gain
    }
}

/// What a hypothesis scores at the first look.
struct ScreeningResult<'h, 'o> {
    hypothesis: &'h Hypothesis,
    /// Its gain is in ln L, as it would be on all.
    score: StartScore,
    /// What was looked at, and the rig and −ln L of it without the hypothesis: the angles go with what that rig has on a ball.
    observed: &'o [Observed],
    rig: Rig,
    neg_log_likelihood: f64,
    /// How much more there is in all.
    scale: f64,
}

/// A hypothesis about to be fitted to what it was looked at on.
struct Entry<'h, 'o> {
    look: ScreeningResult<'h, 'o>,
    problem: Problem<'o>,
    /// Whether it may be searched slowly too.
    slowly: bool,
}

impl Entry<'_, '_> {
    /// A short search; where that leaves something and `slowly` allows it, another from the slow parts of the recordings to all
    /// of them.
    fn searched(&self) -> Option<Optimum> {
        let Self { look, problem, slowly } = self;
        let point = problem.start_at(look.score.angles.clone());
        let direct = search(problem, point.clone(), &QUICK).ok()?;
        if !slowly || leaves_nothing(problem, &direct).ok()? {
            return Some(direct);
        }
        let slowly = search_slowly(problem, point, &QUICK)?;
        Some(if slowly.expansion.neg_log_likelihood() < direct.expansion.neg_log_likelihood() {
            slowly
        } else {
            direct
        })
    }
}

/// The next that `enter` lets in beside those of them that it has let in already, [`SIDE_BY_SIDE`] at most.
fn some_of<T, E>(from: &mut impl Iterator<Item = T>, mut enter: impl FnMut(T, &[E]) -> Option<E>) -> Vec<E> {
    let mut together = Vec::new();
    while together.len() < SIDE_BY_SIDE
        && let Some(next) = from.next()
    {
        together.extend(enter(next, &together));
    }
    together
}

/// A hypothesis fitted to a few recordings.
struct SubsetFit<'h> {
    /// In ln L, as it would be on all.
    log_likelihood_gain: f64,
    hypothesis: &'h Hypothesis,
    start: Start,
    found: Optimum,
}

/// Whether what is left could be noise of the rig's kind, as far as one look tells.
fn leaves_nothing(problem: &Problem, found: &Optimum) -> Result<bool, RigError> {
    Ok(!lack_of_fit(&whitened(problem.observed, &problem.predict(&found.point)?)).is_more_than_chance())
}

/// What a search costs, in searches of a rig that takes one step a sample.
fn work(problem: &Problem) -> usize {
    let steps = |o: &Observed| fewest_substeps(&problem.rig, None, &o.condition);
    problem.observed.iter().map(steps).max().unwrap_or(1).min(MOST_WORK)
}

/// A search from the slow parts of the recordings to all of them, at last within `limits`.
fn search_slowly(problem: &Problem, mut point: Point, limits: &Limits) -> Option<Optimum> {
    for band in BANDS {
        let narrow = Problem { band, ..problem.clone() };
        point = search(&narrow, point, &QUICK).ok()?.point;
    }
    search(problem, point, limits).ok()
}
