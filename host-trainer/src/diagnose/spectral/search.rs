//! Search for the effect that explains what a rig leaves.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use rayon::prelude::*;

use super::fit::{Data, Known, Model, Point};
use super::hypotheses::{Guesses, Hypothesis, all};
use super::likelihood::{Colour, Range};
use super::observation::Observation;
use super::settings::SearchSettings;
use crate::identify::likelihood::coordinate::Coordinate;
use crate::rig::config::RigKey;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::{EffectEntry, Rig};
use crate::signal::transform::median;

const SETTINGS: SearchSettings = SearchSettings::DEFAULT;

/// Parameters of a defect that its power spectrum shows.
const LIKE_A_DEFECT: &[ParameterKey] = &[ParameterKey::DepthM, ParameterKey::WidthRad, ParameterKey::AngleRad];

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

/// Beginnings of some recordings, on which hypotheses are first tried.
pub struct Brief {
    first: Vec<Observation>,
    second: Vec<Observation>,
}

impl Brief {
    /// Of the recording of greatest load, then of those of least and greatest load.
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

/// A look at brief recordings: the nominal rig there.
struct Look<'d, 'a> {
    model: Model<'d, 'a>,
    point: Point,
}

impl<'d, 'a> Look<'d, 'a> {
    fn new(data: &'d Data<'a>, fitted: &Rig, at: &Point) -> Option<Self> {
        let model =
            Model { data, rig: fitted.clone(), coordinates: Vec::new(), guesses: Vec::new(), known: Known::Nothing };
        let count = data.observations.len();
        let jitter = vec![at.jitter.iter().copied().max().unwrap_or(0); count];
        let from = Point { stretch: vec![0.0; count], jitter, ..at.clone() };
        let point = model.search(model.start(Some(&from)).ok()?, 3).ok()?;
        Some(Self { model, point })
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
    let load =
        data.observations.iter().map(|o| o.condition.load_n).sum::<f64>() / data.observations.len().max(1) as f64;
    let fitted = null.rig_at(&at.values).unwrap_or_else(|_| null.rig.clone());
    let mut list = all(&fitted, load, &guesses(data, at));
    list.retain(|h| !before.contains(&h.kind));
    let (first, second) = (Data::new(&brief.first, data.orders), Data::new(&brief.second, data.orders));
    let (Some(first), Some(second)) = (Look::new(&first, &fitted, at), Look::new(&second, &fitted, at)) else {
        return Vec::new();
    };
    // Every start on one brief recording, the best on two, the best of these on all.
    let starts: Vec<(&Hypothesis, &EffectEntry)> =
        list.iter().flat_map(|h| h.starts.iter().map(move |s| (h, s))).collect();
    let tried = starts
        .par_iter()
        .filter_map(|(h, s)| Some((Candidate::new(&first.model, &fitted, &first.point, h, s, true)?.gain, *h, *s)));
    let tried = best_starts(tried.collect(), SETTINGS.starts, SETTINGS.starts_each);
    let tried = tried
        .into_par_iter()
        .filter_map(|(_, h, s)| Some((Candidate::new(&second.model, &fitted, &second.point, h, s, true)?.gain, h, s)));
    let tried = best_starts(tried.collect(), SETTINGS.hypotheses, 1);
    let searched = tried.into_par_iter().filter_map(|(_, h, s)| {
        let best = Candidate::new(&second.model, &fitted, &second.point, h, s, true)?.searched(&second.point, 3);
        let rig = best.model.rig_at(&best.point.values).ok()?;
        Some((best.gain, h, rig.effects.last()?.clone()))
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
    full.extend(whole(null, &fitted, at, &list));
    full.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let most = full.first().map_or(0.0, |c| c.gain);
    let close = |c: &Candidate| c.gain > most - SETTINGS.close_nats - SETTINGS.close_share * most.abs();
    let (near, far): (Vec<Candidate>, Vec<Candidate>) = full.into_iter().partition(close);
    let mut near: Vec<Candidate> =
        near.into_par_iter().map(|c| c.searched(at, SETTINGS.steps[1]).elsewhere(null, &fitted, at)).collect();
    near.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    near.into_iter().chain(far).collect()
}

/// Fit of what a brief recording does not show: a speed that drifts.
fn whole<'d, 'a>(null: &Model<'d, 'a>, fitted: &Rig, at: &Point, list: &[Hypothesis]) -> Option<Candidate<'d, 'a>> {
    let drift = list.iter().find(|h| h.kind == EffectKind::SpeedDrift)?;
    let starts = drift.starts.par_iter().filter_map(|start| Candidate::new(null, fitted, at, drift, start, false));
    Some(starts.max_by(|a, b| a.gain.total_cmp(&b.gain))?.searched(at, SETTINGS.steps[0]))
}

type Tried<'h> = (f64, &'h Hypothesis, &'h EffectEntry);

/// Best starts, at most `each` of a hypothesis, and of a kind at most some hypotheses.
fn best_starts(mut tried: Vec<Tried>, most: usize, each: usize) -> Vec<Tried> {
    tried.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut places = std::collections::BTreeMap::new();
    let mut kinds = std::collections::BTreeMap::new();
    tried.retain(|(_, h, _)| {
        let place = places.entry((h.kind, h.place.as_str())).or_insert(0);
        let kind = kinds.entry(h.kind).or_insert(0);
        *kind += usize::from(*place == 0);
        *place += 1;
        *place <= each && *kind <= SETTINGS.places
    });
    tried.truncate(most);
    tried
}

impl<'d, 'a> Candidate<'d, 'a> {
    fn new(
        null: &Model<'d, 'a>,
        fitted: &Rig,
        at: &Point,
        hypothesis: &Hypothesis,
        effect: &EffectEntry,
        first: bool,
    ) -> Option<Self> {
        let rig = fitted.clone().with_effect(effect.clone());
        let index = rig.effects.len() - 1;
        let own =
            hypothesis.free.iter().filter_map(|key| Coordinate::for_key(&rig, RigKey::Effect { index, key: *key }));
        let coordinates = null.coordinates.iter().cloned().chain(own).collect();
        let is_steady = effect.definition().is_deterministic && null.coordinates.is_empty();
        let known = match (is_steady, first) {
            (true, _) => Known::Noise(Arc::new(at.predictions.clone())),
            (false, true) => Known::Scatter(at.predictions.iter().map(|p| p.scatter).collect()),
            (false, false) => Known::Nothing,
        };
        let mut from = at.clone();
        let mut rig = rig;
        if effect.kind == EffectKind::SensorGain {
            take_level(&mut rig, &mut from.colour)?;
        }
        let model = Model { data: null.data, rig, coordinates, guesses: null.guesses.clone(), known };
        let point = model.start(Some(&from)).ok()?;
        let gain = at.objective() - point.objective();
        Some(Self { kind: hypothesis.kind, place: hypothesis.place.clone(), model, point, gain })
    }

    /// Best of the effect as screened and weaker: friction takes away the motion that the screening saw.
    fn best_of(
        null: &Model<'d, 'a>,
        fitted: &Rig,
        at: &Point,
        hypothesis: &Hypothesis,
        effect: &EffectEntry,
    ) -> Option<Self> {
        let key = match effect.kind {
            EffectKind::CoulombFriction => ParameterKey::ForceN,
            EffectKind::QuadraticDrag => ParameterKey::DragNS2PerM2,
            _ => return Self::new(null, fitted, at, hypothesis, effect, false),
        };
        let size = effect.number(key)?;
        let weaker = [1.0, 0.6, 0.35, 0.2].into_par_iter().filter_map(|share| {
            let effect = effect.clone().with_number(key, share * size);
            Self::new(null, fitted, at, hypothesis, &effect, false)
        });
        weaker.max_by(|a, b| a.gain.total_cmp(&b.gain))
    }

    /// Better of a defect and the defects that look like it: its width shows by the zeros of its lines' envelope, and its
    /// place by their strength, so that a search may end at another width or on the other side of the load.
    fn elsewhere(self, null: &Model<'d, 'a>, fitted: &Rig, at: &Point) -> Self {
        use ParameterKey::{AngleRad, DepthM, WidthRad};
        let Some(effect) = self.model.rig_at(&self.point.values).ok().and_then(|rig| rig.effects.last().cloned())
        else {
            return self;
        };
        let (Some(depth), Some(width)) = (effect.number(DepthM), effect.number(WidthRad)) else { return self };
        let free: Vec<ParameterKey> =
            self.model.coordinates.iter().filter_map(|c| c.key.of_effect(self.model.rig.effects.len() - 1)).collect();
        let angles = match effect.number(AngleRad).filter(|_| free.contains(&AngleRad)) {
            Some(angle) => vec![Some(angle), Some(PI - angle), Some(0.5 * (angle + FRAC_PI_2)), Some(FRAC_PI_2 + 0.15)],
            None => vec![None],
        };
        let sizes =
            SETTINGS.other_widths.iter().flat_map(|share| [share.powf(-0.5), *share].map(|deeper| (*share, deeper)));
        let others = sizes.flat_map(|size| angles.iter().map(move |angle| (size, *angle)));
        let others: Vec<EffectEntry> = others
            .map(|((wider, deeper), angle)| {
                let other = effect.clone().with_number(DepthM, deeper * depth).with_number(WidthRad, wider * width);
                angle.map_or(other.clone(), |angle| other.with_number(AngleRad, angle))
            })
            .collect();
        let (kind, place) = (self.kind, self.place.clone());
        let free = if free.contains(&AngleRad) { LIKE_A_DEFECT } else { &LIKE_A_DEFECT[..2] };
        let hypothesis = Hypothesis { kind, place, free, starts: Vec::new() };
        let mut tried: Vec<Candidate> =
            others.par_iter().filter_map(|other| Self::new(null, fitted, at, &hypothesis, other, false)).collect();
        tried.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        tried.truncate(SETTINGS.restarts);
        let searched = tried.into_par_iter().map(|c| c.searched(at, SETTINGS.steps[1]));
        let best = searched.max_by(|a, b| a.gain.total_cmp(&b.gain));
        best.filter(|best| best.gain > self.gain).unwrap_or(self)
    }

    fn searched(self, null: &Point, steps: usize) -> Self {
        match self.model.search(self.point.clone(), steps) {
            Ok(point) => Self { gain: null.objective() - point.objective(), point, ..self },
            Err(_) => self,
        }
    }
}

/// Moves the level of a noise's colour to the gain of the last effect; `None` if there is none.
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

/// Starts that the recordings show.
fn guesses(data: &Data, at: &Point) -> Guesses {
    Guesses {
        peaks_hz: [0, 1].map(|channel| peaks_hz(data, at, channel)),
        slips: slips(data, at),
        drifts_per_s: drifts_per_s(data),
        mains: mains(data, at),
    }
}

/// Slip beyond that of a healthy cage with which the lines suit the recordings better.
fn slips(data: &Data, at: &Point) -> Vec<f64> {
    const GAIN: f64 = 8.0;
    let of = |n: usize| {
        let healthy = Range { around: 0.0, reach: 0.009, healthy: true };
        let any = Range { around: -0.05, reach: 0.04, healthy: false };
        let ((_, before), (stretch, after)) = (data.stretch(at, n, healthy), data.stretch(at, n, any));
        (after > before + GAIN).then_some(-stretch)
    };
    let mut all: Vec<f64> = (0..data.observations.len()).into_par_iter().filter_map(of).collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() < 1e-3);
    all
}

/// Rates of the tachometers, or a grid without any.
fn drifts_per_s(data: &Data) -> Vec<f64> {
    const LEAST: f64 = 3e-3;
    let told: Vec<f64> = data.observations.iter().filter_map(|o| Some(o.tachometer?.gains_per_s)).collect();
    if told.is_empty() {
        return [0.008, 0.014, 0.025, 0.045, 0.08].into_iter().flat_map(|rate| [rate, -rate]).collect();
    }
    let mean = told.iter().sum::<f64>() / told.len() as f64;
    if mean.abs() > LEAST { vec![mean] } else { Vec::new() }
}

/// Lines of 45 to 65 Hz that every recording shows at the same frequency, with their amplitude.
fn mains(data: &Data, at: &Point) -> Vec<(f64, f64)> {
    const LEAST: f64 = 6.0;
    let of = |hz: f64| -> Option<(f64, f64)> {
        let each = (0..data.observations.len()).map(|n| {
            let o = &data.observations[n];
            let of_channel = |c: usize| {
                let spectrum = data.channel(at, n, c);
                let k = (hz / o.hz(1.0)).round() as usize;
                let power = *o.power[c].as_ref()?.get(k)?;
                let mean = spectrum.noise(k) + spectrum.line(k);
                Some((power / mean, (4.0 * power / o.condition.samples as f64 / 1.2).sqrt()))
            };
            (0..2).filter_map(of_channel).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 0.0))
        });
        let each: Vec<(f64, f64)> = each.collect();
        let least = each.iter().map(|e| e.0).fold(f64::MAX, f64::min);
        let mean = each.iter().map(|e| e.1).sum::<f64>() / each.len().max(1) as f64;
        (least > LEAST).then_some((least, mean))
    };
    let tried = (0..81u32).map(|n| 45.0 + 0.25 * f64::from(n)).filter_map(|hz| Some((hz, of(hz)?)));
    let best = tried.max_by(|a, b| a.1.0.total_cmp(&b.1.0));
    best.map(|(hz, (_, amplitude))| (hz, amplitude)).into_iter().collect()
}

/// Frequencies near which the power of a channel differs most from a prediction, Hz, of all recordings.
fn peaks_hz(data: &Data, at: &Point, channel: usize) -> Vec<f64> {
    const BANDS_PER_OCTAVE: f64 = 16.0;
    let band = |hz: f64| (BANDS_PER_OCTAVE * (hz / 100.0).log2()).floor() as i64;
    let mut bands = std::collections::BTreeMap::<i64, [f64; 2]>::new();
    for n in 0..data.observations.len() {
        let spectrum = data.channel(at, n, channel);
        for (k, power, noise, line) in spectrum.bins() {
            let hz = spectrum.observation.hz(k as f64);
            if hz < 150.0 {
                continue;
            }
            let entry = bands.entry(band(hz)).or_default();
            // Bounded, so that lines do not count as modes.
            entry[0] += (power / (noise + line)).min(6.0) - 0.985;
            entry[1] += 1.0;
        }
    }
    let mut found: Vec<(f64, i64)> = bands.iter().map(|(band, [sum, count])| (sum / count.sqrt(), *band)).collect();
    found.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    let mut out: Vec<(f64, i64)> = Vec::new();
    for (z, band) in found {
        if z.abs() > 4.0 && out.len() < 3 && out.iter().all(|(_, other)| (other - band).abs() > 4) {
            out.push((z, band));
        }
    }
    out.into_iter().map(|(_, band)| 100.0 * ((band as f64 + 0.5) / BANDS_PER_OCTAVE).exp2()).collect()
}
