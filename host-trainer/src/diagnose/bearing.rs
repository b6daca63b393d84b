//! Diagnosis of the 5-DoF rig by its likelihood.
//!
//! 1. Faults of the acquisition are found and removed ([`acquisition`](super::acquisition)).
//! 2. The null model, the nominal rig with its unknown parameters and the angles fitted, gives a residual;
//!    [`residual`](super::residual) tests it for lack of fit.
//! 3. Every candidate is fitted to all recordings but the last ([`model_selection`](super::model_selection)). The best is kept
//!    if its gain exceeds the BIC penalty of its parameters. A second one is sought in the residual in the same way, then
//!    either anew given the other; if both leave much unexplained, another comes first ([`explain`](super::explain)).
//! 4. The kept causes are accepted if their gain on the held-out recording is significant
//!    ([`validation`](super::validation)), their error there is not much larger, and they explain most of the lack of fit. If
//!    there is a lack of fit and no cause is accepted, the mismatch is unexplained.

use super::acquisition::Acquired;
use super::data_split::DataSplit;
use super::evidence;
use super::explain::{EXPLAINED, Explanation, NullFit};
use super::findings::{self, Failure};
use super::result::{Cause, Diagnosis, DiagnosisResult, Left, Location, SCHEMA, Verdict};
use super::validation::{Validation, shown, validate};
use super::{DiagnoseError, Task};
use super::{locate, machine};
use crate::identify::calibrate::bearing::{Calibration, Options, PathChoice, calibrate};
use crate::identify::calibrate::estimate::ParameterPrior;
use crate::identify::calibrate::split::Split;
use crate::identify::likelihood::observed::Observed;
use crate::recording::Recording;
use crate::rig::Rig;

/// Ratio of held-out error power with causes to that without, above which causes are rejected; of any channel.
const GREATEST_ERROR_RATIO: f64 = 2.0;
/// Significance level of the gain on the held-out recording.
const SIGNIFICANCE_LEVEL: f64 = 0.01;
/// Caveat of an acquisition fault with a further, unexplained mismatch.
const BESIDE_A_FAULT: &str = "With the acquisition fault removed the recordings still differ from the rig by more than \
                              chance, and nothing in the vocabulary explains that; the fault may be part of a cause outside \
                              the vocabulary.";
/// Caveat of clipped recordings, in which no other cause is sought.
const CUT_OFF: &str = "Clipping cut off part of the signal, so no other cause was sought.";

/// Diagnoses recordings of a bearing rig, at least one.
///
/// # Errors
/// Recordings without acceleration, speed or load; a rig that cannot run.
pub fn diagnose(task: &Task, progress: &dyn Fn(&str)) -> Result<DiagnosisResult, DiagnoseError> {
    let Task { recordings, seed, .. } = *task;
    if machine::is_unknown(task.rig) {
        return machine::diagnose(task, progress);
    }
    let (rig, prior) = calibrated(task, progress)?;
    let acquired = Acquired::detect(&rig, recordings)?;
    let split = DataSplit::new(&acquired.recordings)?;
    progress("fitting the nominal rig");
    let null_fit = NullFit::new(&rig, &split, seed)?;
    // Clipped samples hide what would distinguish another cause.
    let explanation = if acquired.clipped.is_empty() {
        null_fit.explain(progress)?
    } else {
        Explanation::nothing(null_fit.lack_of_fit)
    };
    let judgement = Judgement::new(&null_fit, &explanation, progress)?;
    outcome(recordings, &acquired, &prior, &null_fit, &explanation, judgement, progress)
}

/// Caveat of recordings without a stated load.
const NO_LOAD: &str = "No load is stated (load_n in recordings.toml); the rig was simulated with 0 N, so that what depends on \
                       the load is a guess.";

/// Rig that recordings are compared with, calibrated to the baseline where there is one, and the prior of its parameters.
fn calibrated(task: &Task, progress: &dyn Fn(&str)) -> Result<(Rig, ParameterPrior), DiagnoseError> {
    let Task { rig, baseline, seed, .. } = *task;
    let Some(baseline) = baseline else { return Ok((rig.clone(), ParameterPrior::none())) };
    progress("calibrating to the baseline");
    // Its waveforms are compared, so that it gets no path of its own.
    let options = Options { path: PathChoice::None, seed };
    let Calibration { rig, prior, .. } = calibrate(rig, baseline, &options, progress)?;
    Ok((rig, prior))
}

/// Validation and verdict of an explanation.
struct Judgement {
    /// Validation on held-out recordings; `None` if the simulation fails there.
    validation: Option<Validation>,
    /// Reason to reject the explanation.
    failure: Option<Failure>,
    /// Verdict on the machine, without acquisition faults.
    verdict: Verdict,
}

impl Judgement {
    fn new(null_fit: &NullFit, explanation: &Explanation, progress: &dyn Fn(&str)) -> Result<Self, DiagnoseError> {
        let (lack_of_fit, left) = (null_fit.lack_of_fit, explanation.left);
        let validation = match explanation.last() {
            Some(last) => {
                progress("validating on held-out recordings");
                // A rig that cannot be simulated under the held-out condition is not validated.
                validate(&null_fit.rig()?, &last.rig()?, &null_fit.split.held_out, null_fit.seed).ok()
            }
            // Held-out recordings are shown all the same.
            None => validate(&null_fit.rig()?, &null_fit.rig()?, &null_fit.split.held_out, null_fit.seed).ok(),
        };
        let explained = if left.is_more_than_chance() { lack_of_fit.explained(&left) } else { 1.0 };
        let failure = failure(explained, validation.as_ref());
        let verdict = if failure.is_none() {
            Verdict::Mismatch
        } else if lack_of_fit.is_more_than_chance() {
            Verdict::Unexplained
        } else {
            Verdict::NoMismatch
        };
        Ok(Self { validation, failure, verdict })
    }
}

/// Reason to reject causes that explain a share of the lack of fit; the share is 1 if the rest is within chance.
fn failure(explained: f64, validation: Option<&Validation>) -> Option<Failure> {
    if explained <= EXPLAINED {
        return Some(Failure::Leaves(1.0 - explained.max(0.0)));
    }
    match validation {
        Some(p) if p.p_value < SIGNIFICANCE_LEVEL && p.after < p.before => {
            // A cause may raise the likelihood merely by raising the expected noise.
            (p.error_ratio > GREATEST_ERROR_RATIO).then(|| Failure::Errs(p.error_ratio.sqrt()))
        }
        _ => Some(Failure::NotConfirmed),
    }
}

/// Result of acquisition faults and causes in the machine together; `raw` are the recordings with the faults.
fn outcome(
    raw: &[Recording],
    acquired: &Acquired,
    prior: &ParameterPrior,
    null_fit: &NullFit,
    explanation: &Explanation,
    judgement: Judgement,
    progress: &dyn Fn(&str),
) -> Result<DiagnosisResult, DiagnoseError> {
    let Judgement { validation, failure, verdict: of_machine } = judgement;
    let stands = failure.is_none();
    let (rig, split) = (&null_fit.selection.rig, &null_fit.split.split);
    let (problem, found) = match explanation.last() {
        Some(last) if stands => (&last.problem, &last.found),
        _ => (&null_fit.problem, &null_fit.found),
    };
    let mut corrected = problem.rig_at(&found.point.coordinates)?;
    let (values, fitted) = findings::parameters(problem, found, rig, null_fit.selection.unknown.len(), prior)?;
    let mut causes: Vec<Cause> = acquired.faults().map(findings::fault_cause).collect();
    if stands {
        causes.extend(findings::causes(&corrected, rig, &values, explanation, validation.as_ref()));
    }
    corrected.effects.extend(acquired.faults().rev().map(|fault| fault.effect.clone()));
    let faulty = acquired.faults().next().is_some();
    let verdict = if faulty { Verdict::Mismatch } else { of_machine };
    let tests = evidence::of_residual(null_fit)?;
    let location = match verdict {
        Verdict::NoMismatch => Location::default(),
        _ => locate::locate(rig, &corrected, &tests),
    };
    let (fit, held_out) = if faulty {
        progress("simulating held-out recordings");
        let p_value = acquired.faults().map(|fault| fault.p_value).fold(0.0, f64::max);
        shown(
            rig,
            &corrected,
            &Observed::from_recordings(&Split::new(raw).held_out)?,
            &split.describe(),
            p_value,
            null_fit.seed,
        )?
    } else {
        findings::fit(validation, stands, split.describe())
    };
    let rejected = findings::rejected(explanation, failure);
    let unexplained = failure.filter(|_| of_machine == Verdict::Unexplained);
    let mut caveats = caveats(acquired, unexplained);
    if raw.iter().any(|recording| recording.load_n.is_none()) {
        caveats.push(NO_LOAD.into());
    }
    let diagnosis = Diagnosis {
        schema: SCHEMA.into(),
        verdict,
        causes,
        rejected,
        location,
        terms: Vec::new(),
        nuisance: Vec::new(),
        left: Left::default(),
        fit,
    };
    Ok(DiagnosisResult { diagnosis, rig: corrected, held_out, tests, fitted, caveats })
}

/// Caveats of the verdict; `unexplained` is the reason to reject the best explanation if the machine's mismatch is
/// unexplained.
fn caveats(acquired: &Acquired, unexplained: Option<Failure>) -> Vec<String> {
    if !acquired.clipped.is_empty() {
        return vec![CUT_OFF.into()];
    }
    let Some(failure) = unexplained else { return Vec::new() };
    let beside = acquired.faults().next().map(|_| BESIDE_A_FAULT.into());
    beside.into_iter().chain([failure.caveat(EXPLAINED)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::recordings;
    use crate::rig::EffectEntry;
    use crate::rig::effect::{EffectKind, ParameterKey};
    use crate::rig::test_support::nominal;

    #[test]
    fn causes_that_leave_much_prove_little_or_err_more_do_not_stand() {
        let pit = EffectEntry::new(
            EffectKind::OuterRaceDefect,
            &[(ParameterKey::DepthM, 1e-6), (ParameterKey::WidthRad, 0.05), (ParameterKey::AngleRad, 1.6)],
        );
        let (plain, pitted) = (nominal(), nominal().with_effect(pit));
        let made = Observed::from_recordings(&recordings(&pitted, 2)).unwrap();
        let validation = validate(&plain, &pitted, &made, 1).unwrap();
        assert!(validation.error_ratio < 0.5, "{}", validation.error_ratio);
        assert_eq!(failure(1.0, Some(&validation)), None);
        assert_eq!(failure(0.75, Some(&validation)), Some(Failure::Leaves(0.25)));
        assert_eq!(failure(1.0, None), Some(Failure::NotConfirmed));
        let reverse = validate(&pitted, &plain, &made, 1).unwrap();
        assert_eq!(failure(1.0, Some(&reverse)), Some(Failure::NotConfirmed));
        assert!(reverse.error_ratio > GREATEST_ERROR_RATIO, "{}", reverse.error_ratio);
        let erring = Validation { error_ratio: 9.0, ..validation };
        assert_eq!(failure(1.0, Some(&erring)), Some(Failure::Errs(3.0)));
    }
}
