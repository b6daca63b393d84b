//! Candidates: hypotheses fitted on top of a null fit.

use std::sync::{Arc, OnceLock};

use super::colour::Colour;
use super::data::Point;
use super::fit::Model;
use super::guesses::Guesses;
use super::hypotheses::{Hypothesis, all};
use super::observation::mean_load_n;
use super::prediction::{Known, is_inner};
use super::settings::GateSettings;
use crate::identify::likelihood::coordinate::Coordinate;
use crate::identify::likelihood::observed::CHANNELS;
use crate::rig::config::RigKey;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::{EffectEntry, Rig};
use crate::signal::transform::median;

const GATE: GateSettings = GateSettings::DEFAULT;

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
    /// Gain of the predicted phase between the channels over that without the effect, nats; 0 where it was not asked for.
    pub phase: f64,
}

impl<'d, 'a> Candidate<'d, 'a> {
    /// Null fit with the effect, on top of which others are fitted.
    pub fn as_null(&self) -> NullFit<'d, 'a> {
        NullFit::new(&self.model, &self.point)
    }

    /// Candidate after a search of at most `steps` steps; the same if the rig cannot run.
    pub fn searched(self, steps: usize) -> Self {
        match self.model.search(self.point.clone(), steps) {
            Ok(point) => Self { gain: self.gain + self.point.objective() - point.objective(), point, ..self },
            Err(_) => self,
        }
    }

    /// Gain by powers and phase less the price of the fitted numbers: ½ ln N nats each, N bins (G. Schwarz, Ann. Stat. 6 (1978)
    /// 461–464), so that dry friction rounded beyond the speeds of the motion is a damper.
    pub fn merit(&self) -> f64 {
        let bins: usize = self.model.data.observations.iter().map(|o| CHANNELS.len() * o.bins().len()).sum();
        self.gain + self.phase - 0.5 * self.model.coordinates.len() as f64 * (bins as f64).ln()
    }

    /// Whether the phase between the channels speaks against the effect.
    pub fn is_contradicted(&self) -> bool {
        let [least, share] = GATE.phase;
        self.phase < -least.max(share * self.gain)
    }

    /// Whether this is a fit of a hypothesis.
    pub fn is_of(&self, hypothesis: &Hypothesis) -> bool {
        (self.kind, &self.place) == (hypothesis.kind, &hypothesis.place)
    }

    /// Effect with its fitted parameters; `None` if they are out of range.
    pub fn effect(&self) -> Option<EffectEntry> {
        self.model.rig_at(&self.point.values).ok()?.effects.last().cloned()
    }
}

/// Candidate that gains most.
pub fn best<'d, 'a>(candidates: impl IntoIterator<Item = Candidate<'d, 'a>>) -> Option<Candidate<'d, 'a>> {
    candidates.into_iter().max_by(|a, b| a.gain.total_cmp(&b.gain))
}

/// Sorts candidates, the one of greatest merit first.
pub fn rank(candidates: &mut [Candidate]) {
    candidates.sort_by(|a, b| b.merit().total_cmp(&a.merit()));
}

/// Fit of a rig without another effect, on top of which hypotheses are fitted.
pub struct NullFit<'d, 'a> {
    /// Model.
    pub model: Model<'d, 'a>,
    /// Its fit.
    pub point: Point,
    /// Rig at the fit.
    pub rig: Rig,
    /// Gain of each channel by the level of its sensor's noise, once it is asked for.
    noise_level_gains: OnceLock<[f64; 2]>,
}

impl<'d, 'a> NullFit<'d, 'a> {
    /// Null fit of a model.
    pub fn new(model: &Model<'d, 'a>, point: &Point) -> Self {
        let rig = model.rig_at(&point.values).unwrap_or_else(|_| model.rig.clone());
        Self { model: model.clone(), point: point.clone(), rig, noise_level_gains: OnceLock::new() }
    }

    /// Hypotheses beside what the rig has.
    pub fn hypotheses(&self) -> Vec<Hypothesis> {
        let data = self.model.data;
        all(&self.rig, mean_load_n(data.observations), &Guesses::new(data, &self.point))
    }

    /// Decrease of −ln from the null fit to a point of a model; of a sensor's gain that beyond another level of its noise.
    pub fn gain(&self, model: &Model, point: &Point) -> f64 {
        let gain = self.point.objective() - point.objective();
        match model.rig.effects.last() {
            Some(effect) if effect.kind == EffectKind::SensorGain => {
                let of_noise = self.noise_level_gains.get_or_init(|| self.model.data.noise_level_gains(&self.point));
                gain - channels(effect).into_iter().map(|c| of_noise[c]).sum::<f64>()
            }
            _ => gain,
        }
    }

    /// Model with an effect, and the nuisances from which its fit starts. A screening takes more of the null fit's predictions
    /// as known.
    pub fn with_effect(
        &self,
        hypothesis: &Hypothesis,
        effect: &EffectEntry,
        is_screening: bool,
    ) -> Option<(Model<'d, 'a>, Point)> {
        let null = &self.model;
        let mut rig = self.rig.clone().with_effect(effect.clone());
        let index = rig.effects.len() - 1;
        let own = hypothesis.free.iter();
        let own = own.filter_map(|key| Coordinate::for_key(&rig, RigKey::Effect { index, key: *key }));
        let coordinates = null.coordinates.iter().cloned().chain(own).collect();
        // A screening moves no number of the rig but the effect's.
        let is_steady = effect.definition().is_deterministic && (is_screening || null.coordinates.is_empty());
        let keeps_inner = !is_inner(effect) && self.point.predictions.iter().all(|p| p.inner.is_some());
        let known = match (is_steady, is_screening) {
            (true, true) if keeps_inner => Known::NoiseAndInner(Arc::clone(&self.point.predictions)),
            (true, _) => Known::Noise(Arc::clone(&self.point.predictions)),
            (false, true) => Known::Scatter(self.point.predictions.iter().map(|p| p.scatter).collect()),
            (false, false) => Known::Nothing,
        };
        let mut from = self.point.clone();
        if effect.kind == EffectKind::SensorGain {
            take_level(&mut rig, &mut from.colour)?;
        }
        Some((Model { data: null.data, rig, coordinates, guesses: null.guesses.clone(), known }, from))
    }

    /// Candidates of a hypothesis at starts of a search, all simulated side by side; those that cannot run are left out.
    pub fn started(&self, hypothesis: &Hypothesis, starts: &[EffectEntry]) -> Vec<Candidate<'d, 'a>> {
        self.started_from(hypothesis, starts, |from| from)
    }

    /// Candidates as by [`NullFit::started`], from the rotation of an even machine.
    pub fn started_evenly(&self, hypothesis: &Hypothesis, starts: &[EffectEntry]) -> Vec<Candidate<'d, 'a>> {
        self.started_from(hypothesis, starts, Point::evenly)
    }

    /// Candidates as by [`NullFit::started`], from changed nuisances.
    fn started_from(
        &self,
        hypothesis: &Hypothesis,
        starts: &[EffectEntry],
        changed: impl Fn(Point) -> Point,
    ) -> Vec<Candidate<'d, 'a>> {
        let prepared = starts.iter().filter_map(|start| self.with_effect(hypothesis, start, false));
        let prepared: Vec<(Model, Point)> = prepared.map(|(model, from)| (model, changed(from))).collect();
        let points = Model::start_all(&prepared);
        let all = prepared.into_iter().zip(points);
        all.filter_map(|((model, _), point)| Some(self.candidate(hypothesis, model, point?))).collect()
    }

    /// Candidate of a hypothesis at a point of its model.
    pub fn candidate(&self, hypothesis: &Hypothesis, model: Model<'d, 'a>, point: Point) -> Candidate<'d, 'a> {
        let gain = self.gain(&model, &point);
        Candidate { kind: hypothesis.kind, place: hypothesis.place.clone(), model, point, gain, phase: 0.0 }
    }
}

/// Channels of an effect.
fn channels(effect: &EffectEntry) -> Vec<usize> {
    let name = effect.text(ParameterKey::Channel);
    let own = (0..CHANNELS.len()).filter(|c| name == Some(CHANNELS[*c]));
    let own: Vec<usize> = own.collect();
    if own.is_empty() { (0..CHANNELS.len()).collect() } else { own }
}

/// Moves the level of a noise's colour to the last effect, a sensor's gain; `None` if there is none.
fn take_level(rig: &mut Rig, colour: &mut Colour) -> Option<()> {
    let effect = rig.effects.last()?;
    let channels = channels(effect);
    let mut levels: Vec<f64> = channels.iter().flat_map(|c| colour[*c]).collect();
    let level = median(&mut levels)?;
    let index = rig.effects.len() - 1;
    channels.iter().for_each(|c| colour[*c].iter_mut().for_each(|knot| *knot -= level));
    rig.set(RigKey::Effect { index, key: ParameterKey::Value }, (0.5 * level).exp()).ok()
}
