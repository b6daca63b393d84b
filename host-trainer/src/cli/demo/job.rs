//! From a folder of recordings and the nominal rig to a corrected model on the device.
//!
//! Nominal rig → model → device → diagnosis → corrected rig → model with the cause's terms → device. The steps are those
//! of commands: `predict`, `fit`, `export`, `monitor`, `diagnose`, `predict`, `fit --diagnosis`, `export`, `monitor`.

use std::path::Path;

use super::DemoError;
use crate::diagnose::causes;
use crate::diagnose::{self, Task, diagnose};
use crate::model::OwnedModel;
use crate::model::export::{self, Format, Limits, Sizes};
use crate::model::file;
use crate::model::fit::terms::{self, Entered};
use crate::model::fit::{self, FitConfig, Fitted, fit, score};
use crate::model::replay::{self, Replayed};
use crate::recording::input::Input;
use crate::recording::input::Series;
use crate::recording::{Recording, load_all};
use crate::report;
use crate::rig::{Rig, batch};

/// Channel that is modelled.
pub const CHANNEL: &str = "ay";
/// Folder of the diagnosis.
pub const DIAGNOSIS: &str = "diagnosis";
/// File of the nominal rig.
pub const RIG: &str = "rig.toml";

/// Options of the job.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// Options of the fits; only the corrected model is compared with surrogates.
    pub fit: FitConfig,
    /// Count of recordings that are diagnosed.
    pub diagnosed: usize,
}

/// Result of the job.
pub struct JobResult {
    /// Recordings of the machine.
    pub input: Input,
    /// Model of the nominal rig.
    pub before: Fitted,
    /// Replay of all recordings with that model on the device.
    pub watched: Replayed,
    /// Indices of the diagnosed recordings, from 0.
    pub diagnosed: Vec<usize>,
    /// Indices of the held-out recordings of the same period, on which the models are compared.
    pub judged: Vec<usize>,
    /// Diagnosis of the nominal rig.
    pub diagnosis: diagnose::result::DiagnosisResult,
    /// Terms that the diagnosis added to the library.
    pub entered: Vec<Entered>,
    /// Model of the corrected rig.
    pub after: Fitted,
    /// Replay of the held-out recordings with that model on the device.
    pub watched_after: Replayed,
    /// Memory and operations of that model on the device.
    pub sizes: Sizes,
    /// Unexplained variance of each model.
    pub residuals: Residuals,
}

/// Share of each recording's variance that the next-sample prediction does not explain.
#[derive(Clone, Debug, PartialEq)]
pub struct Residuals {
    /// Model of the nominal rig, on held-out simulations of it.
    pub own: f64,
    /// Model of the nominal rig, on all recordings.
    pub before: Vec<f64>,
    /// Model of the corrected rig, on all recordings.
    pub after: Vec<f64>,
    /// Model of the corrected rig with the old library, on all recordings; `None` if no term was added.
    pub without_terms: Option<Vec<f64>>,
    /// Model fitted to the held-out recordings themselves by the same training: the attainable minimum.
    pub floor: Vec<f64>,
}

/// Runs the job in a folder that has `recordings/` and `rig.toml`.
///
/// # Errors
/// The first error of any step.
pub fn run(job: &Job, out: &Path, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<JobResult, DemoError> {
    progress("reading", 0.02);
    let recordings = load_all(&out.join("recordings"))?;
    let input = Input::from_recordings(&recordings, Some(CHANNEL))?;
    let rig = Rig::read(&out.join(RIG))?;
    let (total, least) = (recordings.len(), 4 * job.diagnosed.max(1));
    if total < least {
        return Err(DemoError::Few { found: total, expected: least });
    }
    let seed = |which: u64| job.fit.seed.wrapping_add(which << 32);
    let plain = FitConfig { null_fits: 0, ..job.fit.clone() };

    progress("fitting the model of the nominal rig", 0.05);
    let before = model_of(&rig, &recordings, seed(1), &plain, &|share| progress("model before", 0.05 + 0.1 * share))?;
    file::write(&out.join("before.json"), &before.model, &before.report)?;
    store(&before.model, out, &[("before.bin", Format::Bin)])?;

    progress("replaying all recordings on the device", 0.15);
    let watched = replay::replay(&before.model, &input, &replay::Options::default(), &mut |_, _| ())?;
    let lines: String = watched.events.iter().map(|event| format!("{event}\n")).collect();
    super::write(&out.join("events.jsonl"), lines.as_bytes())?;

    let alarm = watched.summary.first_alarm.as_ref().map(|alarm| alarm.recording_index as usize);
    let (diagnosed, judged) = parted(total, alarm, job.diagnosed);
    let chosen: Vec<Recording> = diagnosed.iter().map(|n| recordings[*n].clone()).collect();
    let task = Task { rig: &rig, baseline: None, recordings: &chosen, seed: job.fit.seed };
    let diagnosis = diagnose(&task, &|what| progress(what, 0.2))?;
    let folder = out.join(DIAGNOSIS);
    report::diagnosis::folder(&folder, &task, &diagnosis)?;

    // As `fit --diagnosis` does, from the files.
    let corrected = Rig::read(&folder.join(diagnose::write::RIG))?;
    let mut with_terms = job.fit.clone();
    let entered = terms::enter(&mut with_terms, &causes::read(&folder.join(diagnose::write::DOCUMENT))?)?;
    let show = |from: f64, to: f64| move |share: f64| progress("models after", from + (to - from) * share);
    let mut after = model_of(&corrected, &recordings, seed(2), &with_terms, &show(0.6, 0.85))?;
    after.report.training.entered.clone_from(&entered);
    file::write(&out.join("model.json"), &after.model, &after.report)?;
    let sizes = export::sizes(&after.model.view());
    Limits::default().check(&sizes)?;
    let forms = [("model.bin", Format::Bin), ("model.h", Format::C), ("model.rs", Format::Rust)];
    store(&after.model, out, &forms)?;

    let judged_input = Input {
        series: judged.iter().map(|n| input.series[*n].clone()).collect(),
        gaps: judged.iter().map(|n| input.gaps[*n].clone()).collect(),
        ..input.clone()
    };
    let watched_after = replay::replay(&after.model, &judged_input, &replay::Options::default(), &mut |_, _| ())?;
    let old_library = match entered.iter().any(|e| e.changed) {
        true => Some(model_of(&corrected, &recordings, seed(2), &plain, &show(0.85, 0.9))?),
        false => None,
    };
    let own_library = FitConfig { null_fits: 0, ..with_terms };
    let floor = fit_to(&judged_input.series, input.sample_rate_hz, &own_library, &show(0.9, 0.95))?;
    let of = |fitted: &Fitted, series: &[Series]| score::unexplained(&fitted.model.view(), series);
    let residuals = Residuals {
        own: before.report.scores.causal.next_sample.map_or(f64::NAN, |r| 1.0 - r),
        before: of(&before, &input.series),
        after: of(&after, &input.series),
        without_terms: old_library.map(|fitted| of(&fitted, &input.series)),
        floor: of(&floor, &judged_input.series),
    };
    Ok(JobResult {
        input,
        before,
        watched,
        diagnosed,
        judged,
        diagnosis,
        entered,
        after,
        watched_after,
        sizes,
        residuals,
    })
}

/// Model fitted to simulations of a rig under the operating conditions of the recordings.
pub(super) fn model_of(
    rig: &Rig,
    recordings: &[Recording],
    seed: u64,
    config: &FitConfig,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Fitted, DemoError> {
    let simulated = Input::from_recordings(&batch::recordings(rig, recordings, seed)?, Some(CHANNEL))?;
    fit_to(&simulated.series, simulated.sample_rate_hz, config, progress)
}

fn fit_to(
    series: &[Series],
    sample_rate_hz: f64,
    config: &FitConfig,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Fitted, DemoError> {
    let mut fitted = fit(series, sample_rate_hz, config, &|stage: fit::Stage| progress(stage.done))?;
    fitted.report.training.channel = Some(CHANNEL.into());
    Ok(fitted)
}

fn store(model: &OwnedModel, out: &Path, forms: &[(&str, Format)]) -> Result<(), DemoError> {
    for (name, format) in forms {
        super::write(&out.join(name), &export::export(model, *format)?)?;
    }
    Ok(())
}

/// Indices of `count` recordings to diagnose, evenly spaced from the alarm on, and of the rest of that period. Without an
/// alarm the period is the last half; after a late one it is extended to hold twice `count`.
fn parted(total: usize, alarm: Option<usize>, count: usize) -> (Vec<usize>, Vec<usize>) {
    let from = alarm.unwrap_or(total / 2).min(total.saturating_sub(2 * count));
    let length = total - from;
    let diagnosed: Vec<usize> = (0..count).map(|k| from + (2 * k + 1) * length / (2 * count)).collect();
    let judged = (from..total).filter(|n| !diagnosed.contains(n)).collect();
    (diagnosed, judged)
}

#[cfg(test)]
mod tests {
    use super::parted;

    #[test]
    fn what_is_judged_took_no_part() {
        for alarm in [None, Some(0), Some(30), Some(59)] {
            let (diagnosed, judged) = parted(60, alarm, 4);
            assert_eq!(diagnosed.len(), 4, "{alarm:?}");
            assert!(judged.len() >= 4 && judged.iter().all(|n| !diagnosed.contains(n) && *n < 60), "{alarm:?}");
        }
        let (diagnosed, judged) = parted(60, Some(30), 3);
        assert_eq!((diagnosed.as_slice(), judged.len()), (&[35, 45, 55][..], 27));
    }
}
