//! Screening: starts of all hypotheses on beginnings of few recordings, so that few remain for fits to all.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::candidate::{Candidate, NullFit, best};
use super::data::{Data, Point};
use super::fit::Model;
use super::hypotheses::Hypothesis;
use super::observation::{Observation, duration_s};
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

    /// Length of the recordings on which the screening ends, s.
    pub fn duration_s(&self) -> f64 {
        duration_s(&self.second)
    }
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

/// Hypotheses that gain most on brief recordings, best first, each with where its search ended: every start on one recording,
/// the best of them on two, those of a support in one direction as well, and a short search of the best of these.
pub fn screened<'h>(null: &NullFit, brief: &Brief, hypotheses: &'h [Hypothesis]) -> Vec<StartScore<'h>> {
    let orders = null.model.data.orders;
    let data = |observations| {
        Some(Data::new(observations, orders, UnevenMachines::new(&null.rig, observations, &orders).ok()?))
    };
    let (Some(first), Some(second)) = (data(&brief.first), data(&brief.second)) else { return Vec::new() };
    let (Some(first), Some(second)) = (brief_null(null, &first), brief_null(null, &second)) else {
        return Vec::new();
    };
    let starts = hypotheses.iter().flat_map(|h| h.starts.iter().map(move |s| (h, s.clone()))).collect();
    let kept = best_starts(scores(&first, starts, &SETTINGS.scales), SETTINGS.starts, SETTINGS.starts_each);
    let directed = kept.iter().flat_map(|score| {
        let directions = hypotheses.iter().filter(|h| h.is_direction_of(score.hypothesis));
        directions.map(|h| (h, h.placed(&score.effect)))
    });
    let starts = directed.chain(kept.iter().map(|score| (score.hypothesis, score.effect.clone()))).collect();
    let kept = best_starts(scores(&second, starts, &[]), SETTINGS.hypotheses, 1);
    let searched = kept.into_par_iter().filter_map(|StartScore { hypothesis, effect, .. }| {
        let (model, from) = second.with_effect(hypothesis, &effect, true)?;
        let point = model.start_from(&from).ok()?;
        let best = second.candidate(hypothesis, model, point).searched(SETTINGS.brief_steps);
        Some(StartScore { gain: best.gain, hypothesis, effect: best.effect()? })
    });
    let mut searched: Vec<StartScore> = searched.collect();
    rank(&mut searched);
    searched
}

/// Null fit of the same rig to brief recordings.
fn brief_null<'d, 'a>(null: &NullFit, data: &'d Data<'a>) -> Option<NullFit<'d, 'a>> {
    let (model, at) = (Model::fixed(data, null.rig.clone()), &null.point);
    let jitter = at.jitter.iter().copied().max().unwrap_or(0);
    let from = at.clone().in_recordings(data.observations.len(), jitter);
    let point = model.search(model.start_from(&from).ok()?, SETTINGS.brief_steps).ok()?;
    Some(NullFit::new(&model, &point))
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
