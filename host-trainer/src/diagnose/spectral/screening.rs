//! Screening: starts of all hypotheses on beginnings of few recordings, so that few remain for fits to all.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::candidate::{Candidate, NullFit, best};
use super::data::{Data, Point};
use super::fit::Model;
use super::hypotheses::Hypothesis;
use super::observation::Observation;
use super::settings::SearchSettings;
use super::unevenness::UnevenMachines;
use crate::rig::EffectEntry;

const SETTINGS: SearchSettings = SearchSettings::DEFAULT;

/// Beginnings of some recordings, on which hypotheses are screened.
pub struct Brief {
    /// Of the recording of greatest load.
    first: Vec<Observation>,
    /// Of those of least and greatest load.
    second: Vec<Observation>,
}

impl Brief {
    /// Beginnings of the fitted recordings.
    pub fn new(observations: &[Observation]) -> Self {
        let load = |o: &&Observation| o.condition.load_n;
        let least = observations.iter().min_by(|a, b| load(a).total_cmp(&load(b)));
        let greatest = observations.iter().max_by(|a, b| load(a).total_cmp(&load(b)));
        let other = greatest.filter(|g| least.is_some_and(|l| l.name != g.name));
        let [first, second] = SETTINGS.brief_s;
        Self {
            first: greatest.into_iter().map(|o| o.beginning(first)).collect(),
            second: least.into_iter().chain(other).map(|o| o.beginning(second)).collect(),
        }
    }

    /// Data of the first and the second screening for a null fit's machine; `None` if it cannot run with uneven balls.
    pub fn data(&self, null: &NullFit) -> Option<[Data<'_>; 2]> {
        let orders = null.model.data.orders;
        let data = |observations| {
            Some(Data::new(observations, orders, UnevenMachines::new(&null.rig, observations, &orders).ok()?))
        };
        Some([data(&self.first)?, data(&self.second)?])
    }
}

/// Null fit of the same rig to brief recordings; `None` if it cannot run.
pub fn brief_null<'d, 'a>(null: &NullFit, data: &'d Data<'a>) -> Option<NullFit<'d, 'a>> {
    let (model, at) = (Model::fixed(data, null.rig.clone()), &null.point);
    let jitter = at.jitter.iter().copied().max().unwrap_or(0);
    let from = at.clone().in_recordings(data.observations.len(), jitter);
    let point = model.search(model.start_from(&from).ok()?, SETTINGS.brief_steps).ok()?;
    Some(NullFit::new(&model, &point))
}

/// Gain of a hypothesis at a start.
pub struct StartScore<'h> {
    /// Decrease of −ln.
    pub gain: f64,
    /// Hypothesis.
    pub hypothesis: &'h Hypothesis,
    /// Start.
    pub effect: EffectEntry,
}

/// Hypotheses that gain most over null fits to brief recordings, best first, each with where its search ended: every start on the
/// first, the best of them on the second, those of a support in one direction as well, and a short search of the best of these.
pub fn screened<'h>([first, second]: [&NullFit; 2], hypotheses: &'h [Hypothesis]) -> Vec<StartScore<'h>> {
    let starts = hypotheses.iter().flat_map(|h| h.starts.iter().map(move |s| (h, s.clone()))).collect();
    let kept = best_starts(scores(first, starts, &SETTINGS.scales), SETTINGS.starts, SETTINGS.starts_each);
    let directed = kept.iter().flat_map(|score| {
        let directions = hypotheses.iter().filter(|h| h.is_direction_of(score.hypothesis));
        directions.map(|h| (h, h.placed(&score.effect)))
    });
    let starts = directed.chain(kept.iter().map(|score| (score.hypothesis, score.effect.clone()))).collect();
    let kept = best_starts(scores(second, starts, &[]), SETTINGS.hypotheses, 1);
    searched_briefly(second, kept)
}

/// Scores of hypotheses at starts, each with the best of some sizes; starts that cannot run are left out.
pub fn scores<'h>(null: &NullFit, starts: Vec<(&'h Hypothesis, EffectEntry)>, scales: &[f64]) -> Vec<StartScore<'h>> {
    let prepared = starts.into_iter().filter_map(|(hypothesis, effect)| {
        let prepared = null.with_effect(hypothesis, &effect, true)?;
        Some((prepared, StartScore { gain: f64::NEG_INFINITY, hypothesis, effect }))
    });
    let (prepared, mut scores): (Vec<_>, Vec<StartScore>) = prepared.unzip();
    let parts = prepared.chunks(SETTINGS.side_by_side).zip(scores.chunks_mut(SETTINGS.side_by_side));
    for (prepared, scores) in parts {
        let points = Model::start_all(prepared);
        scores.par_iter_mut().zip(prepared).zip(points).for_each(|((score, (model, from)), point)| {
            let Some(point) = point else { return };
            score.gain = null.gain(model, &point);
            score.resize(null, model, from, &point, scales);
        });
    }
    scores.retain(|score| score.gain.is_finite());
    scores
}

impl StartScore<'_> {
    /// Moves a score to the best size of its effect, of which `point` is at the first size.
    fn resize(&mut self, null: &NullFit, model: &Model, from: &Point, point: &Point, scales: &[f64]) {
        let size = self.hypothesis.size.and_then(|key| Some((key, self.effect.number(key)?)));
        let Some((key, size)) = size else { return };
        let scaled = |scale: f64| {
            let each = point.predictions.iter().zip(null.point.predictions.iter());
            each.map(|(own, null)| own.scaled(null, scale)).collect()
        };
        let near = Point { stretch: point.stretch.clone(), ..from.clone() };
        let rough = |scale: &f64| null.gain(model, &model.with_predictions(&near, scaled(*scale)));
        let best = scales.iter().map(|scale| (rough(scale), *scale)).max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, scale)) = best else { return };
        let gain = null.gain(model, &model.started(from, scaled(scale)));
        if gain > self.gain {
            *self = Self { gain, effect: self.effect.clone().with_number(key, scale * size), ..*self };
        }
    }
}

/// Best starts, at most `each` of a hypothesis, and of a kind at most some hypotheses.
pub fn best_starts(mut scores: Vec<StartScore>, most: usize, each: usize) -> Vec<StartScore> {
    rank(&mut scores);
    let mut places = BTreeMap::new();
    let mut kinds = BTreeMap::new();
    scores.retain(|score| {
        let place = places.entry((score.hypothesis.kind, score.hypothesis.place.as_str())).or_insert(0);
        let kind = kinds.entry(score.hypothesis.kind).or_insert(0);
        *kind += usize::from(*place == 0);
        *place += 1;
        *place <= each && *kind <= SETTINGS.places
    });
    scores.truncate(most);
    scores
}

/// Scores after a short search from each on the same recordings; those that cannot run are left out.
pub fn searched_briefly<'h>(null: &NullFit, scores: Vec<StartScore<'h>>) -> Vec<StartScore<'h>> {
    let searched = scores.into_par_iter().filter_map(|StartScore { hypothesis, effect, .. }| {
        let (model, from) = null.with_effect(hypothesis, &effect, true)?;
        let point = model.start_from(&from).ok()?;
        let best = null.candidate(hypothesis, model, point).searched(SETTINGS.brief_steps);
        Some(StartScore { gain: best.gain, hypothesis, effect: best.effect()? })
    });
    let mut searched: Vec<StartScore> = searched.collect();
    rank(&mut searched);
    searched
}

/// Best of as many searches, from the best of some starts of a hypothesis.
pub fn searched_from_best<'d, 'a>(
    hypothesis: &Hypothesis,
    scores: Vec<StartScore>,
    searches: usize,
    null: &NullFit<'d, 'a>,
) -> Option<Candidate<'d, 'a>> {
    let kept = best_starts(scores, searches, searches);
    let starts: Vec<EffectEntry> = kept.into_iter().map(|score| score.effect).collect();
    let started = null.started(hypothesis, &starts);
    let searched: Vec<_> = started.into_par_iter().map(|c| c.searched(SETTINGS.steps[1])).collect();
    best(searched)
}

fn rank(scores: &mut [StartScore]) {
    scores.sort_by(|a, b| b.gain.total_cmp(&a.gain));
}
