//! Diagnosis of the 5-DoF rig: machines of unknown structure against their baseline, rigs of known structure by their
//! simulation, calibrated to the baseline where there is one.

use super::result::DiagnosisResult;
use super::{DiagnoseError, Task, machine, spectral};
use crate::identify::calibrate::bearing::{Calibration, Options, PathChoice, calibrate};

/// Diagnoses recordings of a bearing rig, at least one.
///
/// # Errors
/// Recordings without acceleration or speed; a rig that cannot run.
pub fn diagnose(task: &Task, progress: &dyn Fn(&str)) -> Result<DiagnosisResult, DiagnoseError> {
    let Task { rig, baseline, seed, .. } = *task;
    if machine::is_unknown(rig) {
        return machine::diagnose(task, progress);
    }
    let Some(baseline) = baseline else { return spectral::diagnose(task, rig, progress) };
    progress("calibrating to the baseline");
    // The path from rig to sensor is part of what is compared.
    let options = Options { path: PathChoice::None, seed };
    let Calibration { rig: near, .. } = calibrate(rig, baseline, &options, progress)?;
    let rig = spectral::calibrated(&near, &rig.unknown_keys(), baseline)?;
    spectral::diagnose(task, &rig, progress)
}
