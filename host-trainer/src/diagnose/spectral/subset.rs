//! Diagnosis of all recordings and, where that explains nothing, of those that differ most from the rig: a fault may be in some
//! recordings only, or grow from one to the next.

use rayon::prelude::*;

use super::colour::Colour;
use super::data::Data;
use super::growth::Refitted;
use super::lack::{lack, level_nats};
use super::observation::Observation;
use super::pipeline::{Whole, nominal, whole};
use super::settings::{FitSettings, GateSettings};
use super::text;
use super::unevenness::UnevenMachines;
use crate::diagnose::result::{Cause, DiagnosisResult, Nuisance, Verdict};
use crate::diagnose::{DiagnoseError, Task};
use crate::recording::Recording;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::{Rig, RigError};
use crate::signal::kinematics::Orders;

const GATE: GateSettings = GateSettings::DEFAULT;
const FIT: FitSettings = FitSettings::DEFAULT;

/// Diagnoses recordings of a bearing rig of known structure; `rig` is calibrated to the baseline.
///
/// # Errors
/// Recordings without acceleration or speed; a rig that cannot run.
pub fn diagnose(task: &Task, rig: &Rig, progress: &dyn Fn(&str)) -> Result<DiagnosisResult, DiagnoseError> {
    let machine = rig.bearing().ok_or(DiagnoseError::NotBearing { found: rig.model.kind().name() })?;
    let Whole { result, searched, .. } = whole(task, rig, progress)?;
    let is_explained = match result.diagnosis.verdict {
        Verdict::Unexplained => false,
        Verdict::Mismatch => !result.diagnosis.causes.iter().all(may_be_no_gain),
        _ => true,
    };
    if is_explained || searched.len() < 2 {
        return Ok(result);
    }
    progress("searching for the recordings that differ most");
    let orders = machine.bearing.geometry().orders();
    let fits = own_fits(rig, &searched, orders)?;
    let Some(differing) = Differing::of(&OwnFit::apart(&fits)) else { return Ok(result) };
    let chosen: Vec<Recording> = differing.recordings.iter().map(|n| task.recordings[*n].clone()).collect();
    let Whole { result: mut own, lasting, .. } = whole(&Task { recordings: &chosen, ..*task }, rig, progress)?;
    if own.diagnosis.verdict != Verdict::Mismatch {
        return Ok(result);
    }
    let names: Vec<&str> = differing.recordings.iter().map(|n| searched[*n].name.as_str()).collect();
    let refitted = (!differing.has_others_within_chance)
        .then(|| {
            progress("fitting what was found there to the other recordings");
            let others =
                (0..searched.len()).filter(|n| !differing.recordings.contains(n)).map(|n| (&searched[n], fits[n].lack));
            Refitted::of(&lasting, rig, &others.collect::<Vec<_>>(), orders)
        })
        .transpose()?;
    if refitted.as_ref().is_some_and(|refitted| refitted.left > GATE.refitted_left) {
        return Ok(result);
    }
    own.caveats.push(match &refitted {
        None => text::in_some(&names),
        Some(refitted) => text::in_all(&names, &refitted.said, refitted.left),
    });
    let of_others = |n: &&Nuisance| !own.diagnosis.nuisance.iter().any(|own| own.recording == n.recording);
    let others: Vec<_> = result.diagnosis.nuisance.iter().filter(of_others).cloned().collect();
    own.diagnosis.nuisance.extend(others);
    Ok(own)
}

/// Whether a cause is a sensor's gain that may be 1: it may be another one in some recordings.
fn may_be_no_gain(cause: &Cause) -> bool {
    let is_around_1 = |[from, to]: &[f64; 2]| (*from..*to).contains(&1.0);
    cause.name == EffectKind::SensorGain.name()
        && cause.interval95.get(ParameterKey::Value.name()).is_some_and(is_around_1)
}

/// Fit of the rig to a recording by itself: the colour of the noise is its own, so that others' faults are no part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct OwnFit {
    /// Lack of fit, nats.
    lack: f64,
    /// −ln of the prior of its levels.
    level: f64,
}

impl OwnFit {
    /// Lack of fit of each recording with what its levels cost beyond the least of all, nats: they may be others in some.
    fn apart(all: &[Self]) -> Vec<f64> {
        let least = all.iter().map(|own| own.level).fold(f64::INFINITY, f64::min);
        all.iter().map(|own| own.lack + own.level - least).collect()
    }
}

/// Fit to each recording by itself.
fn own_fits(rig: &Rig, searched: &[Observation], orders: Orders) -> Result<Vec<OwnFit>, RigError> {
    let of = |observation: &Observation| {
        let own = std::slice::from_ref(observation);
        let data = Data::new(own, orders, UnevenMachines::new(rig, own, &orders)?);
        let model = nominal(rig, &data);
        let point = model.search(model.start()?, FIT.nominal_steps)?;
        let level = level_nats(&point.colour_in(0), &Colour::default());
        Ok::<_, RigError>(OwnFit { lack: lack(&data, &point).total(), level })
    };
    searched.par_iter().map(of).collect()
}

/// Recordings that differ from a rig more than others.
#[derive(Clone, Debug, PartialEq)]
struct Differing {
    /// Their indices.
    recordings: Vec<usize>,
    /// Whether the others are within chance.
    has_others_within_chance: bool,
}

impl Differing {
    /// Recordings of a lack of fit beyond chance, where that of others is within it; else the one of the greatest. `None` if all
    /// are within chance.
    fn of(lacks: &[f64]) -> Option<Self> {
        let beyond: Vec<usize> = (0..lacks.len()).filter(|n| lacks[*n] > GATE.lack).collect();
        let most = (0..lacks.len()).max_by(|a, b| lacks[*a].total_cmp(&lacks[*b]))?;
        match beyond.len() {
            0 => None,
            count if count < lacks.len() => Some(Self { recordings: beyond, has_others_within_chance: true }),
            _ => Some(Self { recordings: vec![most], has_others_within_chance: false }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recordings_beyond_chance_are_taken_or_the_farthest_of_all() {
        let of = |lacks: &[f64]| Differing::of(lacks).map(|found| (found.recordings, found.has_others_within_chance));
        assert_eq!(of(&[1.0, 900.0, 2.0, 300.0]), Some((vec![1, 3], true)));
        assert_eq!(of(&[100.0, 900.0, 200.0, 300.0]), Some((vec![1], false)));
        assert_eq!(of(&[1.0, 2.0]), None);
    }

    #[test]
    fn a_level_of_some_recordings_sets_them_apart() {
        let all = [(1.0, 150.0), (0.0, 62.0), (2.0, 60.0), (0.0, 130.0)].map(|(lack, level)| OwnFit { lack, level });
        assert_eq!(OwnFit::apart(&all), [91.0, 2.0, 2.0, 70.0]);
    }
}
