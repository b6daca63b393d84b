//! Angle of a defect in the outer race: by the powers, and by the phase between the channels, without which either side of the
//! load is the same.

use std::f64::consts::FRAC_PI_2;

use super::candidate::{Candidate, NullFit};
use super::cross::cross_gains;
use super::fit::Model;
use super::settings::SearchSettings;
use crate::rig::config::RigKey;
use crate::rig::effect::{EffectKind, ParameterKey};

const SETTINGS: SearchSettings = SearchSettings::DEFAULT;

/// Candidate of an outer race at its best angle; any other as it is.
pub fn turned<'d, 'a>(candidate: Candidate<'d, 'a>, null: &NullFit) -> Candidate<'d, 'a> {
    let Some(angle) = angle(&candidate) else { return candidate };
    let from_load = angle - FRAC_PI_2;
    let sides = SETTINGS.turns.iter().flat_map(|share| [*share, -*share]);
    let candidate = best_of(candidate, sides.map(|share| FRAC_PI_2 + share * from_load), null);
    let candidate = searched_there(&candidate, null).unwrap_or(candidate);
    let angle = self::angle(&candidate).unwrap_or(angle);
    best_of(candidate, SETTINGS.near_turns_rad.iter().map(|by| angle + by), null)
}

/// Candidate after a search of all but its angle, which the powers alone would move away.
fn searched_there<'d, 'a>(candidate: &Candidate<'d, 'a>, null: &NullFit) -> Option<Candidate<'d, 'a>> {
    let key = RigKey::Effect { index: candidate.model.rig.effects.len() - 1, key: ParameterKey::AngleRad };
    let at = candidate.model.coordinates.iter().position(|c| c.key == key)?;
    let mut fixed = Model { rig: candidate.model.rig_at(&candidate.point.values).ok()?, ..candidate.model.clone() };
    fixed.coordinates.remove(at);
    let mut point = candidate.point.clone();
    let angle = point.values.remove(at);
    let mut point = fixed.search(point, SETTINGS.steps[1]).ok()?;
    point.values.insert(at, angle);
    Some(Candidate { gain: null.gain(&candidate.model, &point), point, ..candidate.clone() })
}

/// Angle of a defect in the outer race, rad; `None` of another effect.
fn angle(candidate: &Candidate) -> Option<f64> {
    candidate.effect().filter(|effect| effect.kind == EffectKind::OuterRaceDefect)?.number(ParameterKey::AngleRad)
}

/// Best of a candidate and of the same at other angles.
fn best_of<'d, 'a>(
    candidate: Candidate<'d, 'a>,
    angles: impl Iterator<Item = f64>,
    null: &NullFit,
) -> Candidate<'d, 'a> {
    let prepared: Vec<_> = angles.filter_map(|angle| Some((at(&candidate, angle)?, candidate.point.clone()))).collect();
    let points = Model::start_all(&prepared);
    let mut all = vec![candidate];
    for ((model, _), point) in prepared.into_iter().zip(points) {
        let Some(point) = point else { continue };
        all.push(Candidate { gain: null.gain(&model, &point), model, point, ..all[0].clone() });
    }
    let gains = total_gains(&all);
    let best = (0..all.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b])).unwrap_or(0);
    all.swap_remove(best)
}

/// Model of a candidate at another angle.
fn at<'d, 'a>(candidate: &Candidate<'d, 'a>, angle: f64) -> Option<Model<'d, 'a>> {
    let model = &candidate.model;
    let mut rig = model.rig_at(&candidate.point.values).ok()?;
    let index = rig.effects.len().checked_sub(1)?;
    rig.set(RigKey::Effect { index, key: ParameterKey::AngleRad }, angle).ok()?;
    Some(Model { rig, ..model.clone() })
}

/// Gain of each candidate by powers and cross-spectra; negative infinity if it cannot run.
fn total_gains(candidates: &[Candidate]) -> Vec<f64> {
    let models: Vec<_> = candidates.iter().map(|c| (&c.model, &c.point)).collect();
    let gains = cross_gains(&models).into_iter().zip(candidates);
    gains.map(|(cross, candidate)| cross.map_or(f64::NEG_INFINITY, |cross| candidate.gain + cross)).collect()
}
