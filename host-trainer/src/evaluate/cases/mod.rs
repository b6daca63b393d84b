//! Cases whose answer is concealed: a nominal rig, and recordings of a machine that has something the rig leaves out.
//!
//! What is hidden, how strongly, and under which speeds and loads is drawn here, from ranges of its own; nothing of the
//! diagnosis is known to this module. A case on disk is what an engineer would have: a rig and recordings, perhaps of
//! the healthy machine too. What was hidden is in [`Truth`], and stays in memory until somebody scores.
//!
//! | module | holds |
//! |---|---|
//! | [`spec`] | which cases there are |
//! | [`machine`] | rigs, speeds and loads |
//! | [`effects`] | how strong an effect of the vocabulary is |
//! | [`outside`] | effects that the vocabulary has no name for |

pub mod case_spec;
pub mod effects;
pub mod machine;
pub mod outside;
#[cfg(test)]
mod tests;

use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::recording::Recording;
use crate::recording::write::{WriteError, folder};
use crate::rig::simulate::{simulate, simulate_altered};
use crate::rig::{EffectEntry, Rig, RigError, Value};
use crate::rig::{OperatingCondition, Start};
use case_spec::{CaseSpec, Hidden};
use machine::Drawn;

/// Recordings of a case, and of the healthy machine where they come with it.
const RECORDINGS: usize = 4;
const BASELINE: usize = 3;
/// Draws of an effect until one stands that can be simulated.
const ATTEMPTS: usize = 20;

/// A case.
#[derive(Clone, Debug)]
pub struct Case {
    /// What the engineer knows.
    pub rig: Rig,
    /// What was recorded.
    pub recordings: Vec<Recording>,
    /// Recordings of the healthy machine; none where the rig is known.
    pub baseline: Option<Vec<Recording>>,
    /// What nobody may know.
    pub truth: Truth,
}

/// What was hidden.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Truth {
    /// Names of the vocabulary; none in a control, `unexplained` for what the vocabulary has not.
    pub causes: Vec<String>,
    /// Names that are the same physics in this rig.
    pub accept: Vec<String>,
    /// The causes' parameters, in SI units; names of components beside them.
    pub effects: Vec<HiddenEffect>,
    /// What was drawn that is no cause of the vocabulary.
    pub outside: Option<String>,
    /// RMS of what the causes change, with all that is random the same, over the RMS of the recording without them.
    pub change: f64,
}

/// An effect with its numbers and names.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct HiddenEffect {
    /// Name.
    pub name: String,
    /// Numbers.
    pub numbers: std::collections::BTreeMap<String, f64>,
    /// Component, channel.
    pub names: std::collections::BTreeMap<String, String>,
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
        Self { name: entry.kind.to_string(), numbers, names }
    }
}

impl Case {
    /// Draws a case. The same spec and seed give the same samples.
    ///
    /// # Errors
    /// Where no draw of the effect can be simulated: the last one's error.
    pub fn draw(spec: &CaseSpec, seconds: f64, seed: u64) -> Result<Self, RigError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let drawn = machine::draw(spec.loud, seconds, RECORDINGS + BASELINE, &mut rng)?;
        let start = |n: usize| Start::of_series(seed, n);
        let healthy = |n: usize| simulate(&drawn.rig, &drawn.conditions[n], &start(n));
        let without = (0..RECORDINGS).map(healthy).collect::<Result<Vec<_>, _>>()?;
        let mut attempt = hide(spec, &drawn, &without, &start, &mut rng);
        for _ in 1..ATTEMPTS {
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
            Some((RECORDINGS..RECORDINGS + BASELINE).map(healthy).collect::<Result<Vec<_>, _>>()?)
        } else {
            None
        };
        if !spec.tachometer {
            recordings.iter_mut().for_each(|r| r.channels.retain(|c| c.name != "tacho"));
        }
        Ok(Self { rig, recordings, baseline, truth })
    }

    /// Writes what an engineer would have: `rig.toml`, the recordings with their manifest, `baseline/`. Nothing else.
    ///
    /// # Errors
    /// What the operating system refuses.
    pub fn write(&self, path: &Path) -> Result<(), CaseError> {
        folder(path, &self.recordings)?;
        if let Some(baseline) = &self.baseline {
            folder(&path.join("baseline"), baseline)?;
        }
        Ok(self.rig.write(&path.join("rig.toml"))?)
    }
}

/// Why a case could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CaseError {
    /// The recordings.
    #[error(transparent)]
    Recordings(#[from] WriteError),
    /// The rig.
    #[error(transparent)]
    Rig(#[from] RigError),
}

/// The machine with what is hidden, recorded.
fn hide(
    spec: &CaseSpec,
    drawn: &Drawn,
    without: &[Recording],
    start: &dyn Fn(usize) -> Start,
    rng: &mut ChaCha8Rng,
) -> Result<(Vec<Recording>, Truth), RigError> {
    let conditions: &[OperatingCondition] = &drawn.conditions[..without.len()];
    let mut truth = Truth { causes: Vec::new(), accept: Vec::new(), effects: Vec::new(), outside: None, change: 0.0 };
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
    }
    let run = |(n, condition): (usize, &OperatingCondition)| match &alter {
        Some(alter) => simulate_altered(&rig, condition, &start(n), &|plan| alter(n, plan)),
        None => simulate(&rig, condition, &start(n)),
    };
    Ok((conditions.iter().enumerate().map(run).collect::<Result<_, _>>()?, truth))
}

fn change(without: &[Recording], with: &[Recording]) -> f64 {
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
