//! Cases with hidden causes: a nominal rig, and recordings of a machine with effects that the rig leaves out.
//!
//! Causes, severities, speeds and loads are drawn here, from ranges of their own, independently of the diagnosis. A case
//! on disk is what an engineer would have: a rig and recordings, perhaps of the healthy machine too. Its causes are in
//! [`Truth`], and stay in memory until the case is scored.
//!
//! | module | holds |
//! |---|---|
//! | [`case_spec`] | list of cases |
//! | [`machine`] | rigs, speeds and loads |
//! | [`effects`] | strengths of the effects of the vocabulary |
//! | [`outside`] | effects outside the vocabulary |
//! | [`settings`] | counts, and ranges of the draws |
//! | [`simulator`] | simulators that cases are made with |

pub mod case_spec;
pub mod effects;
pub mod machine;
pub mod outside;
pub mod settings;
pub mod simulator;
#[cfg(test)]
mod tests;

use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::independent;
use crate::recording::Recording;
use crate::recording::write::{WriteError, folder};
use crate::rig::simulate::{simulate, simulate_altered};
use crate::rig::{EffectEntry, Rig, RigError, Value};
use crate::rig::{OperatingCondition, Start};
use case_spec::{CaseSpec, Hidden};
use machine::Drawn;
use settings::CaseSettings;
use simulator::Simulator;

const SETTINGS: CaseSettings = CaseSettings::DEFAULT;

/// A case with its truth.
#[derive(Clone, Debug)]
pub struct Case {
    /// Nominal rig.
    pub rig: Rig,
    /// Recordings of the machine with its causes.
    pub recordings: Vec<Recording>,
    /// Recordings of the healthy machine; `None` if the rig is exact.
    pub baseline: Option<Vec<Recording>>,
    /// Hidden causes.
    pub truth: Truth,
}

/// Hidden causes of a case.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Truth {
    /// Names of the vocabulary; none in a control, `unexplained` for an effect outside the vocabulary.
    pub causes: Vec<String>,
    /// Names that are the same physics in this rig.
    pub accept: Vec<String>,
    /// Parameters of the causes, in SI units, and names of components.
    pub effects: Vec<HiddenEffect>,
    /// Name of an effect outside the vocabulary.
    pub outside: Option<String>,
    /// RMS change by the causes, with the same noise, over the RMS of the recordings without them.
    pub change: f64,
}

/// An effect with its numbers and names.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct HiddenEffect {
    /// Name of the effect.
    pub name: String,
    /// Numbers by key, in SI units.
    pub numbers: std::collections::BTreeMap<String, f64>,
    /// Component and channel by key.
    pub names: std::collections::BTreeMap<String, String>,
    /// Form in words, where the numbers do not say it.
    #[serde(default)]
    pub form: String,
    /// Recordings that have it, from 1; empty for all.
    #[serde(default)]
    pub recordings: Vec<usize>,
}

impl HiddenEffect {
    fn from_entry(entry: &EffectEntry) -> Self {
        let (mut numbers, mut names) = (std::collections::BTreeMap::new(), std::collections::BTreeMap::new());
        for (key, value) in &entry.parameters {
            match value {
                Value::Number(number) => _ = numbers.insert(key.to_string(), *number),
                Value::Text(text) => _ = names.insert(key.to_string(), text.clone()),
            }
        }
        Self { name: entry.kind.to_string(), numbers, names, ..Self::default() }
    }
}

impl Case {
    /// Draws a case. The same spec, simulator and seed give the same samples.
    ///
    /// # Errors
    /// The last draw's error if no draw of the effect can be simulated.
    pub fn draw(spec: &CaseSpec, simulator: Simulator, seconds: f64, seed: u64) -> Result<Self, RigError> {
        match simulator.imperfections() {
            Some(size) => independent::draw_case(spec, seconds, size, seed),
            None => Self::draw_shared(spec, seconds, seed),
        }
    }

    fn draw_shared(spec: &CaseSpec, seconds: f64, seed: u64) -> Result<Self, RigError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let CaseSettings { recordings: count, baseline: healthy_count, attempts, .. } = SETTINGS;
        let drawn = machine::draw(spec.loud, seconds, count + healthy_count, &mut rng)?;
        let start = |n: usize| Start::of_series(seed, n);
        let healthy = |n: usize| simulate(&drawn.rig, &drawn.conditions[n], &start(n));
        let without = (0..count).map(healthy).collect::<Result<Vec<_>, _>>()?;
        let mut attempt = hide(spec, &drawn, &without, &start, &mut rng);
        for _ in 1..attempts {
            if attempt.is_ok() {
                break;
            }
            attempt = hide(spec, &drawn, &without, &start, &mut rng);
        }
        let (mut recordings, mut truth) = attempt?;
        truth.change = change(&without, &recordings);
        let mut rig = drawn.rig.clone();
        let baseline = if spec.guessed {
            machine::guess(&mut rig, &mut rng)?;
            Some((count..count + healthy_count).map(healthy).collect::<Result<Vec<_>, _>>()?)
        } else {
            None
        };
        if !spec.tachometer {
            recordings.iter_mut().for_each(|r| r.channels.retain(|c| c.name != "tacho"));
        }
        Ok(Self { rig, recordings, baseline, truth })
    }

    /// Writes a case without its truth: `rig.toml`, the recordings with their manifest, `baseline/`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), CaseError> {
        folder(path, &self.recordings)?;
        if let Some(baseline) = &self.baseline {
            folder(&path.join("baseline"), baseline)?;
        }
        Ok(self.rig.write(&path.join("rig.toml"))?)
    }
}

/// Errors of writing a case.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CaseError {
    /// Recordings that cannot be written.
    #[error(transparent)]
    Recordings(#[from] WriteError),
    /// Rig that cannot be simulated or written.
    #[error(transparent)]
    Rig(#[from] RigError),
}

/// Recordings of the machine with its hidden causes, and the truth.
fn hide(
    spec: &CaseSpec,
    drawn: &Drawn,
    without: &[Recording],
    start: &dyn Fn(usize) -> Start,
    rng: &mut ChaCha8Rng,
) -> Result<(Vec<Recording>, Truth), RigError> {
    let conditions: &[OperatingCondition] = &drawn.conditions[..without.len()];
    let mut truth = Truth::default();
    let mut rig = drawn.rig.clone();
    let mut alter = None;
    match &spec.hidden {
        Hidden::Nothing => {}
        Hidden::Effects(names) => {
            for (kind, severity) in names {
                let (at, span) = severity.share();
                let share = at + span * rng.random::<f64>();
                let entry = effects::draw(*kind, share, drawn, without, rng);
                truth.accept.extend(effects::same_as(&entry).map(|kind| kind.to_string()));
                truth.effects.push(HiddenEffect::from_entry(&entry));
                truth.causes.push(entry.kind.to_string());
                rig = rig.with_effect(entry);
            }
        }
        Hidden::Outside(kind) => {
            truth.causes.push("unexplained".into());
            truth.outside = Some(kind.name().into());
            alter = Some(outside::draw(*kind, drawn, without, rng));
        }
        // Forms of the independent simulator, which only that one has.
        Hidden::OutsideIndependent(_) => return Err(independent::foreign()),
    }
    let run = |(n, condition): (usize, &OperatingCondition)| match &alter {
        Some(alter) => simulate_altered(&rig, condition, &start(n), &|assembly| alter(n, assembly)),
        None => simulate(&rig, condition, &start(n)),
    };
    Ok((conditions.iter().enumerate().map(run).collect::<Result<_, _>>()?, truth))
}

/// RMS of the change in both channels over the RMS without it.
pub(super) fn change(without: &[Recording], with: &[Recording]) -> f64 {
    let (mut difference, mut power) = (0.0, 0.0);
    for (a, b) in without.iter().zip(with) {
        for name in ["ax", "ay"] {
            let (Some(a), Some(b)) = (a.channel(name), b.channel(name)) else { continue };
            difference += a.samples.iter().zip(&b.samples).map(|(a, b)| (b - a).powi(2)).sum::<f64>();
            power += a.samples.iter().map(|a| a * a).sum::<f64>();
        }
    }
    (difference / power.max(f64::MIN_POSITIVE)).sqrt()
}
