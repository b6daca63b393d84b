//! Search for the effect that explains what a rig leaves.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use rayon::prelude::*;

use super::data::{Data, Point};
use super::fit::Model;
use super::guesses::Guesses;
use super::hypotheses::{Hypothesis, all};
use super::likelihood::Colour;
use super::observation::{Observation, mean_load_n};
use super::prediction::{Known, Prediction};
use super::settings::SearchSettings;
use crate::identify::likelihood::coordinate::Coordinate;
use crate::rig::config::RigKey;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::{EffectEntry, Rig};
use crate::signal::transform::median;

const SETTINGS: SearchSettings = SearchSettings::DEFAULT;

/// Parameters of a defect that a power spectrum shows.
const DEFECT_KEYS: &[ParameterKey] = &[ParameterKey::DepthM, ParameterKey::WidthRad, ParameterKey::AngleRad];

/// Effect fitted together with all that the model had before.
#[derive(Clone)]
pub struct Candidate<'d, 'a> {
    /// Effect.
    pub kind: EffectKind,
    /// Component, channel or lobes.
    pub place: String,
    /// Model with the effect last.
    pub model: Model<'d, 'a>,
    /// Fit.
    pub point: Point,
    /// Decrease of −ln by the effect.
    pub gain: f64,
}

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
}

/// Fit of a rig without another effect to brief recordings.
struct NullFit<'d, 'a> {
    model: Model<'d, 'a>,
    point: Point,
}

impl<'d, 'a> NullFit<'d, 'a> {
    fn new(data: &'d Data<'a>, fitted: &Rig, at: &Point) -> Option<Self> {
        let model = Model::fixed(data, fitted.clone());
        let count = data.observations.len();
        let jitter = vec![at.jitter.iter().copied().max().unwrap_or(0); count];
        let from = Point { stretch: vec![0.0; count], jitter, ..at.clone() };
        let point = model.search(model.start_from(&from).ok()?, SETTINGS.brief_steps).ok()?;
        Some(Self { model, point })
    }

    /// Scores of hypotheses at starts, each with the best of some sizes; starts that cannot run are left out.
    fn scores<'h>(
        &self,
        fitted: &Rig,
        starts: Vec<(&'h Hypothesis, EffectEntry)>,
        scales: &[f64],
    ) -> Vec<StartScore<'h>> {
        let prepared = starts.into_iter().filter_map(|(hypothesis, effect)| {
            let prepared = prepare(&self.model, fitted, &self.point, hypothesis, &effect, true)?;
            Some((prepared, StartScore { gain: f64::NEG_INFINITY, hypothesis, effect }))
        });
        let (prepared, mut scores): (Vec<_>, Vec<StartScore>) = prepared.unzip();
        let parts = prepared.chunks(SETTINGS.side_by_side).zip(scores.chunks_mut(SETTINGS.side_by_side));
        for (prepared, scores) in parts {
            let points = Model::start_all(prepared);
            scores.par_iter_mut().zip(prepared).zip(points).for_each(|((score, (model, from)), point)| {
                let Some(point) = point else { return };
                score.gain = self.point.objective() - point.objective();
                self.resize(score, model, from, &point.predictions, scales);
            });
        }
        scores.retain(|score| score.gain.is_finite());
        scores
    }

    /// Moves a score to the best size of its effect, whose predictions at its first size are known.
    fn resize(&self, score: &mut StartScore, model: &Model, from: &Point, predictions: &[Prediction], scales: &[f64]) {
        let size = score.hypothesis.size.and_then(|key| Some((key, score.effect.number(key)?)));
        let Some((key, size)) = size else { return };
        for &scale in scales {
            let scaled =
                predictions.iter().zip(self.point.predictions.iter()).map(|(own, null)| own.scaled(null, scale));
            let gain = self.point.objective() - model.started(from, scaled.collect()).objective();
            if gain > score.gain {
                *score = StartScore { gain, effect: score.effect.clone().with_number(key, scale * size), ..*score };
            }
        }
    }
}

/// Candidates that gain most, best first; none of the kinds that the model has already.
pub fn candidates<'d, 'a>(
    null: &Model<'d, 'a>,
    at: &Point,
    brief: &Brief,
    before: &[EffectKind],
) -> Vec<Candidate<'d, 'a>> {
    let data = null.data;
    let fitted = null.rig_at(&at.values).unwrap_or_else(|_| null.rig.clone());
    let mut list = all(&fitted, mean_load_n(data.observations), &Guesses::new(data, at));
    list.retain(|h| !before.contains(&h.kind));
    let (first, second) = (Data::new(&brief.first, data.orders), Data::new(&brief.second, data.orders));
    let (Some(first), Some(second)) = (NullFit::new(&first, &fitted, at), NullFit::new(&second, &fitted, at)) else {
        return Vec::new();
    };
    // Every start on one brief recording, the best on two, the best of these on all.
    let starts = list.iter().flat_map(|h| h.starts.iter().map(move |s| (h, s.clone()))).collect();
    let kept = best_starts(first.scores(&fitted, starts, &SETTINGS.scales), SETTINGS.starts, SETTINGS.starts_each);
    let starts = kept.into_iter().map(|score| (score.hypothesis, score.effect)).collect();
    let kept = best_starts(second.scores(&fitted, starts, &[]), SETTINGS.hypotheses, 1);
    let searched = kept.into_par_iter().filter_map(|StartScore { hypothesis, effect, .. }| {
        let (model, from) = prepare(&second.model, &fitted, &second.point, hypothesis, &effect, true)?;
        let candidate = Candidate::started(model, &from, &second.point, hypothesis)?;
        let best = candidate.searched(&second.point, SETTINGS.brief_steps);
        let rig = best.model.rig_at(&best.point.values).ok()?;
        Some((best.gain, hypothesis, rig.effects.last()?.clone()))
    });
    let mut screened: Vec<(f64, &Hypothesis, EffectEntry)> = searched.collect();
    screened.sort_by(|a, b| b.0.total_cmp(&a.0));
    let most = screened.first().map_or(0.0, |c| c.0);
    screened.retain(|c| c.0 > SETTINGS.rival_share * most);
    screened.truncate(SETTINGS.full_fits);
    let full = screened.into_par_iter().filter_map(|(_, hypothesis, effect)| {
        Some(Candidate::best_of(null, &fitted, at, hypothesis, &effect)?.searched(at, SETTINGS.steps[0]))
    });
    let mut full: Vec<Candidate> = full.collect();
    // A brief recording does not show a drift of the speed, and an error of the load is always a rival.
    let also = [EffectKind::SpeedDrift, EffectKind::ConstantForce].into_iter();
    let also = also.filter(|kind| full.iter().all(|c| c.kind != *kind)).collect::<Vec<_>>();
    full.extend(also.into_iter().filter_map(|kind| fit_without_screening(null, &fitted, at, &list, kind)));
    full.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let most = full.first().map_or(0.0, |c| c.gain);
    let close = |c: &Candidate| c.gain > most - SETTINGS.close_nats - SETTINGS.close_share * most.abs();
    let (near, far): (Vec<Candidate>, Vec<Candidate>) = full.into_iter().partition(close);
    let mut near: Vec<Candidate> =
        near.into_par_iter().map(|c| c.searched(at, SETTINGS.steps[1]).restart_defect(null, &fitted, at)).collect();
    near.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    near.into_iter().chain(far).collect()
}

/// Fit of an effect to all recordings without a screening; `None` if it is not among the hypotheses.
fn fit_without_screening<'d, 'a>(
    null: &Model<'d, 'a>,
    fitted: &Rig,
    at: &Point,
    list: &[Hypothesis],
    kind: EffectKind,
) -> Option<Candidate<'d, 'a>> {
    let hypothesis = list.iter().find(|h| h.kind == kind)?;
    let started = Candidate::started_all(null, fitted, at, hypothesis, &hypothesis.starts);
    let best = started.into_iter().max_by(|a, b| a.gain.total_cmp(&b.gain))?;
    Some(best.searched(at, SETTINGS.steps[0]))
}

/// Gain of a hypothesis at a start.
struct StartScore<'h> {
    gain: f64,
    hypothesis: &'h Hypothesis,
    effect: EffectEntry,
}

/// Best starts, at most `each` of a hypothesis, and of a kind at most some hypotheses.
fn best_starts(mut scores: Vec<StartScore>, most: usize, each: usize) -> Vec<StartScore> {
    scores.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let mut places = std::collections::BTreeMap::new();
    let mut kinds = std::collections::BTreeMap::new();
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

/// Model with an effect, and the nuisances from which its fit starts: those of the null fit `at`.
fn prepare<'d, 'a>(
    null: &Model<'d, 'a>,
    fitted: &Rig,
    at: &Point,
    hypothesis: &Hypothesis,
    effect: &EffectEntry,
    is_screening: bool,
) -> Option<(Model<'d, 'a>, Point)> {
    let mut rig = fitted.clone().with_effect(effect.clone());
    let index = rig.effects.len() - 1;
    let own = hypothesis.free.iter().filter_map(|key| Coordinate::for_key(&rig, RigKey::Effect { index, key: *key }));
    let coordinates = null.coordinates.iter().cloned().chain(own).collect();
    let is_steady = effect.definition().is_deterministic && null.coordinates.is_empty();
    let known = match (is_steady, is_screening) {
        (true, _) => Known::Noise(Arc::clone(&at.predictions)),
        (false, true) => Known::Scatter(at.predictions.iter().map(|p| p.scatter).collect()),
        (false, false) => Known::Nothing,
    };
    let mut from = at.clone();
    if effect.kind == EffectKind::SensorGain {
        take_level(&mut rig, &mut from.colour)?;
    }
    Some((Model { data: null.data, rig, coordinates, guesses: null.guesses.clone(), known }, from))
}

impl<'d, 'a> Candidate<'d, 'a> {
    /// Candidates at starts of a search, all simulated side by side; those that cannot run are left out.
    fn started_all(
        null: &Model<'d, 'a>,
        fitted: &Rig,
        at: &Point,
        hypothesis: &Hypothesis,
        starts: &[EffectEntry],
    ) -> Vec<Self> {
        let prepared: Vec<_> =
            starts.iter().filter_map(|start| prepare(null, fitted, at, hypothesis, start, false)).collect();
        let points = Model::start_all(&prepared);
        let all = prepared.into_iter().zip(points);
        all.filter_map(|((model, _), point)| Some(Self::at(model, point?, at, hypothesis))).collect()
    }

    fn at(model: Model<'d, 'a>, point: Point, null: &Point, hypothesis: &Hypothesis) -> Self {
        let gain = null.objective() - point.objective();
        Self { kind: hypothesis.kind, place: hypothesis.place.clone(), model, point, gain }
    }

    fn started(model: Model<'d, 'a>, from: &Point, at: &Point, hypothesis: &Hypothesis) -> Option<Self> {
        let point = model.start_from(from).ok()?;
        Some(Self::at(model, point, at, hypothesis))
    }

    /// Best of an effect as screened and weaker: friction reduces the motion on which the screening's noise rests.
    fn best_of(
        null: &Model<'d, 'a>,
        fitted: &Rig,
        at: &Point,
        hypothesis: &Hypothesis,
        effect: &EffectEntry,
    ) -> Option<Self> {
        let key = match effect.kind {
            EffectKind::CoulombFriction => Some(ParameterKey::ForceN),
            EffectKind::QuadraticDrag => Some(ParameterKey::DragNS2PerM2),
            _ => None,
        };
        let starts = match key.and_then(|key| Some((key, effect.number(key)?))) {
            Some((key, size)) => SETTINGS.weaker.map(|share| effect.clone().with_number(key, share * size)).to_vec(),
            None => vec![effect.clone()],
        };
        let started = Self::started_all(null, fitted, at, hypothesis, &starts);
        started.into_iter().max_by(|a, b| a.gain.total_cmp(&b.gain))
    }

    /// Better of a defect and defects with like spectra: a search may end at another width, of another place of the zeros in
    /// the lines' envelope, or on the other side of the load.
    fn restart_defect(self, null: &Model<'d, 'a>, fitted: &Rig, at: &Point) -> Self {
        use ParameterKey::{AngleRad, DepthM, WidthRad};
        let Some(effect) = self.model.rig_at(&self.point.values).ok().and_then(|rig| rig.effects.last().cloned())
        else {
            return self;
        };
        let Some(width) = effect.number(WidthRad) else { return self };
        let free: Vec<ParameterKey> =
            self.model.coordinates.iter().filter_map(|c| c.key.of_effect(self.model.rig.effects.len() - 1)).collect();
        let angles = match effect.number(AngleRad).filter(|_| free.contains(&AngleRad)) {
            Some(angle) => {
                let near_load = FRAC_PI_2 + SETTINGS.near_load_rad;
                vec![Some(angle), Some(PI - angle), Some(0.5 * (angle + FRAC_PI_2)), Some(near_load)]
            }
            None => vec![None],
        };
        let (kind, place) = (self.kind, self.place.clone());
        let free = if free.contains(&AngleRad) { DEFECT_KEYS } else { &DEFECT_KEYS[..2] };
        let hypothesis = Hypothesis { kind, place, free, starts: Vec::new(), size: Some(DepthM) };
        let widths = SETTINGS.other_widths.map(|share| effect.clone().with_number(WidthRad, share * width));
        let turned = |other: EffectEntry| {
            angles.iter().map(move |angle| match angle {
                Some(angle) => other.clone().with_number(AngleRad, *angle),
                None => other.clone(),
            })
        };
        let starts = widths.into_iter().flat_map(turned).map(|start| (&hypothesis, start)).collect();
        let healthy = NullFit { model: null.clone(), point: at.clone() };
        let scores = healthy.scores(fitted, starts, &SETTINGS.other_depths);
        let kept = best_starts(scores, SETTINGS.restarts, SETTINGS.restarts);
        let starts: Vec<EffectEntry> = kept.into_iter().map(|score| score.effect).collect();
        let started = Self::started_all(null, fitted, at, &hypothesis, &starts);
        let searched = started.into_par_iter().map(|c| c.searched(at, SETTINGS.steps[1]));
        let best = searched.max_by(|a, b| a.gain.total_cmp(&b.gain));
        best.filter(|best| best.gain > self.gain).unwrap_or(self)
    }

    /// Candidate after a search of at most `steps` steps.
    fn searched(self, null: &Point, steps: usize) -> Self {
        match self.model.search(self.point.clone(), steps) {
            Ok(point) => Self { gain: null.objective() - point.objective(), point, ..self },
            Err(_) => self,
        }
    }
}

/// Moves the level of a noise's colour to the last effect, a sensor's gain; `None` if there is none.
fn take_level(rig: &mut Rig, colour: &mut Colour) -> Option<()> {
    let effect = rig.effects.last()?;
    let channels: Vec<usize> = match effect.text(ParameterKey::Channel) {
        Some("ax") => vec![0],
        Some("ay") => vec![1],
        _ => vec![0, 1],
    };
    let mut levels: Vec<f64> = channels.iter().flat_map(|c| colour[*c]).collect();
    let level = median(&mut levels)?;
    let index = rig.effects.len() - 1;
    channels.iter().for_each(|c| colour[*c].iter_mut().for_each(|knot| *knot -= level));
    rig.set(RigKey::Effect { index, key: ParameterKey::Value }, (0.5 * level).exp()).ok()
}
