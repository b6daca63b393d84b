//! Hypotheses compete: each is brought as near to the recordings as it can come, and judged by what it gains.

use super::hypothesis::{Hypothesis, Start};
use super::screen::{Ground, Promise, screen};
use crate::rig::{Rig, RigError};
use crate::whittle::coordinate::Coordinate;
use crate::whittle::observed::Observed;
use crate::whittle::problem::{Point, Problem};
use crate::whittle::search::{Found, Limits, search, search_from_rig};

/// Hypotheses that are searched on the few recordings, and of those the ones that are on all.
const SEARCHED: usize = 14;
const FINALISTS: usize = 5;
/// Shares of the band that a search goes through, from what turns slowly to all: slow parts have few wrong places to end.
const BANDS: [f64; 3] = [0.06, 0.2, 1.0];

/// A hypothesis with its best parameters.
#[derive(Clone, Debug)]
pub struct Contender<'o> {
    /// Name in the vocabulary.
    pub name: &'static str,
    /// Where.
    pub place: String,
    /// What was sought, in which rig.
    pub problem: Problem<'o>,
    /// What was found.
    pub found: Found,
    /// Gain in ln L over the rig without it, less half the logarithm of the count of samples for each parameter more
    /// (G. Schwarz, Annals of Statistics 6 (1978) 461–464).
    pub merit: f64,
    /// Gain in ln L.
    pub gain: f64,
}

impl Contender<'_> {
    /// The rig with the effect as it was found.
    ///
    /// # Errors
    /// None that the search has not met.
    pub fn rig(&self) -> Result<Rig, RigError> {
        self.problem.rig_at(&self.found.point.coordinates)
    }
}

/// The contest's surroundings.
#[derive(Clone, Debug)]
pub struct Contest<'o> {
    /// Recordings for all.
    pub all: &'o [Observed],
    /// Beginnings of a few of them, for a first look.
    pub brief: &'o [Observed],
    /// A few of them whole, for what their beginnings do not show.
    pub few: &'o [Observed],
    /// The rig without what is sought; its unknown parameters are fitted along with every hypothesis.
    pub rig: Rig,
    /// Those unknown parameters.
    pub unknown: Vec<Coordinate>,
}

impl<'o> Contest<'o> {
    /// The rig without anything more.
    ///
    /// # Errors
    /// What the simulation refuses.
    pub fn null(&self, observed: &'o [Observed]) -> Result<(Problem<'o>, Found), RigError> {
        let problem = Problem::new(observed, self.rig.clone(), self.unknown.clone());
        let found = search_from_rig(&problem)?;
        Ok((problem, found))
    }

    /// All hypotheses, the best first; those that could not be brought near are left out.
    ///
    /// # Errors
    /// What the simulation refuses of the rig without any of them.
    pub fn run(&self, hypotheses: &[Hypothesis], progress: &dyn Fn(&str)) -> Result<Vec<Contender<'o>>, RigError> {
        let (_, null) = self.null(self.all)?;
        progress("looking at every hypothesis");
        let mut promises = Vec::new();
        for (observed, whole) in [(self.brief, false), (self.few, true)] {
            let fits = |h: &Hypothesis| h.needs_whole_recordings() == whole;
            let these: Vec<_> = hypotheses.iter().enumerate().filter(|(_, h)| fits(h)).collect();
            if these.is_empty() {
                continue;
            }
            let (problem, found) = self.null(observed)?;
            let expected = problem.expected(&found.point)?;
            let ground = Ground { observed, angles: found.point.angles.clone(), expected };
            let rig = problem.rig_at(&found.point.coordinates)?;
            // A gain grows with what is looked at.
            let samples = |o: &[Observed]| o.iter().map(|o| o.condition.samples).sum::<usize>() as f64;
            let scale = samples(self.all) / samples(observed);
            let more = screen(&ground, &rig, &these)?.into_iter().map(|p| Promise { gain: p.gain * scale, ..p });
            promises.extend(more.map(|p| (p, observed, found.expansion.misfit(), scale)));
        }
        promises.sort_by(|a, b| b.0.gain.total_cmp(&a.0.gain));
        promises.truncate(SEARCHED);
        let mut heats = Vec::new();
        for (n, (promise, observed, before, scale)) in promises.into_iter().enumerate() {
            let hypothesis = &hypotheses[promise.hypothesis];
            progress(&format!("fitting {} {} ({} of {SEARCHED})", hypothesis.name, hypothesis.place, n + 1));
            let Some(problem) = self.problem(observed, &promise.start) else { continue };
            let Some(found) = heat(problem, &promise.angles) else { continue };
            heats.push(((before - found.expansion.misfit()) * scale, hypothesis, promise.start, found));
        }
        heats.sort_by(|a, b| b.0.total_cmp(&a.0));
        heats.truncate(FINALISTS);
        let samples: usize = self.all.iter().map(|o| o.condition.samples).sum();
        let mut out = Vec::new();
        for (n, (_, hypothesis, start, heat)) in heats.into_iter().enumerate() {
            progress(&format!("fitting {} {} to all ({} of {FINALISTS})", hypothesis.name, hypothesis.place, n + 1));
            let Some(problem) = self.problem(self.all, &start) else { continue };
            let Ok(rig) = problem.rig_at(&heat.point.coordinates) else { continue };
            let Ok(aligned) = problem.aligned(&rig) else { continue };
            // A weak effect does not move the angles, a strong one does.
            let tries = [aligned, null.point.angles.clone()].map(|angles| Point { angles, ..heat.point.clone() });
            let level = |point: &Point| problem.misfits(point).map_or(f64::INFINITY, |m| m.iter().sum());
            let from = if level(&tries[0]) < level(&tries[1]) { &tries[0] } else { &tries[1] };
            let Ok(found) = search(&problem, from.clone(), &Limits::default()) else { continue };
            let gain = null.expansion.misfit() - found.expansion.misfit();
            let more = problem.coordinates.len() - self.unknown.len();
            let merit = gain - 0.5 * more as f64 * (samples as f64).ln();
            out.push(Contender { name: hypothesis.name, place: hypothesis.place.clone(), problem, found, merit, gain });
        }
        out.sort_by(|a, b| b.merit.total_cmp(&a.merit));
        Ok(out)
    }

    fn problem(&self, observed: &'o [Observed], start: &Start) -> Option<Problem<'o>> {
        let rig = self.rig.clone().with_effect(start.effect.clone());
        rig.check().ok()?;
        let number = rig.effects.len();
        let own = start.free.iter().map(|key| Coordinate::of(&rig, &format!("effect[{number}].{key}")));
        let coordinates = self.unknown.iter().cloned().map(Some).chain(own).collect::<Option<Vec<_>>>()?;
        Some(Problem::new(observed, rig, coordinates))
    }
}

/// A short search, from the slow parts of the recordings to all of them.
fn heat(problem: Problem<'_>, angles: &[[f64; 2]]) -> Option<Found> {
    let coordinates =
        problem.coordinates.iter().map(|c| Some(c.from_value(problem.rig.get(&c.key)?))).collect::<Option<Vec<_>>>()?;
    let mut point = Point { coordinates, angles: angles.to_vec() };
    let quick = Limits { steps: 6, gain: 1.0, ..Limits::default() };
    let direct = search(&problem, point.clone(), &quick).ok()?;
    for band in BANDS {
        let narrow = Problem { band, ..problem.clone() };
        point = search(&narrow, point, &quick).ok()?.point;
    }
    let slowly = search(&problem, point, &quick).ok()?;
    Some(if slowly.expansion.misfit() < direct.expansion.misfit() { slowly } else { direct })
}
