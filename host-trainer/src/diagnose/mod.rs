//! Diagnosis of a mismatch between a rig and recordings: causes, parameters, location.
//!
//! | module | holds |
//! |---|---|
//! | [`result`] | result of a diagnosis |
//! | [`mod@write`] | a diagnosis as a folder |
//! | `sdof` | the rig of one degree of freedom |
//! | `bearing` | the 5-DoF rig: which of its back ends |
//! | `spectral` | rigs of known structure, by the power spectra of their recordings |
//! | `machine` | machines of unknown structure, with or without a baseline |
//! | `acquisition` | faults between sensor and file |
//! | `shown` | fit to held-out recordings |
//! | `evidence` | rank of significance tests |
//! | `locate` | where the mismatch is |

pub(crate) mod acquisition;
pub(crate) mod bearing;
pub(crate) mod causes;
mod error;
pub(crate) mod evidence;
pub(crate) mod locate;
pub(crate) mod machine;
pub mod result;
pub(crate) mod sdof;
pub(crate) mod shown;
pub(crate) mod spectral;
#[cfg(test)]
mod tests;
pub mod write;

pub use error::DiagnoseError;

use crate::identify::input_check;
use crate::recording::Recording;
use crate::rig::{Machine, Rig};

/// Rig and recordings to diagnose.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// Nominal rig.
    pub rig: &'a Rig,
    /// Recordings of the healthy machine.
    pub baseline: Option<&'a [Recording]>,
    /// Recordings to diagnose, at least one.
    pub recordings: &'a [Recording],
    /// Seed of simulations and permutations.
    pub seed: u64,
}

/// Diagnoses a rig of either kind. `progress` gets each step in words.
///
/// # Errors
/// Recordings or a rig that lack something required; recordings that contradict themselves or the rig.
///
/// # Examples
///
/// ```
/// use ballrace::rig::effect::{EffectKind, ParameterKey};
/// use ballrace::rig::{EffectEntry, Rig, RigError, sdof};
/// use ballrace::{Task, diagnose};
///
/// let rig = "kind = \"sdof\"\nmass_kg = 2.0\ndamping_n_s_per_m = 4.0\nstiffness_n_per_m = 800.0\n\
///            input_gain_n_per_unit = 3.0\nrestoring = \"linear\"\ngravity_n = 0.0";
/// let rig = Rig::parse(rig, "rig.toml".as_ref())?;
/// let friction = EffectEntry::new(EffectKind::CoulombFriction, &[(ParameterKey::ForceN, 0.5)]);
/// let machine = rig.clone().with_effect(friction);
/// let record = |n: i32| {
///     let tones = |t: f64| (0..8).map(|k| (f64::from(2 + 3 * k + n) * t + f64::from(k * k)).sin()).sum::<f64>();
///     let input: Vec<f64> = (0..3000).map(|k| 0.5 * tones(f64::from(k) / 500.0)).collect();
///     let drive = sdof::Drive { input: &input, sample_rate_hz: 500.0, ..Default::default() };
///     let mut recording = sdof::simulate(&machine, &drive)?;
///     recording.channels.retain(|channel| ["u", "q"].contains(&channel.name.as_str()));
///     Ok::<_, RigError>(recording)
/// };
/// let recordings = (0..4).map(record).collect::<Result<Vec<_>, _>>()?;
/// let task = Task { rig: &rig, baseline: None, recordings: &recordings, seed: 1 };
/// let diagnosis = diagnose(&task, &|_| ())?.diagnosis;
/// assert_eq!(diagnosis.causes[0].name, "coulomb-friction");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn diagnose(task: &Task, progress: &dyn Fn(&str)) -> Result<result::DiagnosisResult, DiagnoseError> {
    if task.recordings.is_empty() {
        return Err(DiagnoseError::Empty);
    }
    let mut notes = input_check::check(task.rig, task.recordings)?;
    let mut task = *task;
    if let Some(baseline) = task.baseline {
        input_check::check_apart(baseline, task.recordings)?;
        let of_baseline = input_check::check(task.rig, baseline)?;
        match input_check::other_machine(baseline, task.recordings) {
            None => notes.extend(of_baseline.into_iter().map(|note| format!("baseline, {note}"))),
            Some(why) => {
                notes.push(format!(
                    "the baseline is not used, since it is not of the same machine in the same condition: {why}"
                ));
                task.baseline = None;
            }
        }
    }
    let mut result = match task.rig.model {
        Machine::Sdof(_) => sdof::diagnose(&task, progress),
        Machine::Bearing(_) => bearing::diagnose(&task, progress),
    }?;
    result.caveats.splice(0..0, notes);
    Ok(result)
}
