//! Diagnosis of the 5-DoF rig by its likelihood.
//!
//! 1. Faults of the acquisition are found and taken out ([`acquisition`](super::acquisition)).
//! 2. The rig as it is, its unknown parameters and the angles fitted, leaves a residual; [`residual`](super::residual)
//!    says whether chance could have left it.
//! 3. Every hypothesis is brought as near as it can come ([`compete`](super::compete)), on recordings without the last.
//!    The best is kept where it gains more than its parameters are worth. A second one is sought in the same way in what
//!    it leaves, and then either anew beside the other ([`explain`](super::explain)).
//! 4. What is kept stands where it gains more on the recording that took no part than chance gives
//!    ([`prove`](super::prove)), errs little more there, and takes away most of what there was to explain. Where something
//!    is left and nothing stands, nothing in the vocabulary explains it.

use super::acquisition::Acquired;
use super::explain::{Explanation, Ground};
use super::outcome::{Cause, Diagnosis, Location, Outcome, SCHEMA, Verdict};
use super::prove::{Proof, prove, shown};
use super::residual::tests;
use super::sets::Sets;
use super::statement::{self, Failure};
use super::{DiagnoseError, Task};
use super::{locate, recorded};
use crate::calibrate::bearing::{Options, calibrate};
use crate::calibrate::split::Split;
use crate::recording::Recording;
use crate::rig::Rig;
use crate::whittle::observed::Observed;

/// Share of the excess that causes must take away to be an explanation.
const EXPLAINED: f64 = 0.93;
/// Power of the error on what took no part, in shares of the rig's without them, that causes may not reach in any channel.
const GREATEST_ERROR_RATIO: f64 = 2.0;
/// p-value on the recording that took no part.
const LEAST_P: f64 = 0.01;

/// Diagnoses recordings of a bearing rig, at least one.
///
/// # Errors
/// Recordings without acceleration, speed or load; a rig that cannot run.
pub fn diagnose(task: &Task, progress: &dyn Fn(&str)) -> Result<Outcome, DiagnoseError> {
    let Task { recordings, seed, .. } = *task;
    let rig = match measure(task, progress)? {
        Measure::Waveforms(rig) => rig,
        Measure::Rhythm(rig) => return recorded::diagnose(&Task { rig: &rig, ..*task }, progress),
    };
    let acquired = Acquired::of(&rig, recordings)?;
    let sets = Sets::of(&acquired.recordings)?;
    progress("fitting the rig as it is");
    let ground = Ground::of(&rig, &sets, seed)?;
    // What was cut off is lost, and with it what another cause could be known by.
    let explanation =
        if acquired.clipped.is_empty() { ground.explain(progress)? } else { Explanation::nothing(ground.excess) };
    let judgement = Judgement::of(&ground, &explanation, progress)?;
    outcome(recordings, &acquired, &ground, &explanation, judgement, progress)
}

/// The rig that recordings are measured by.
enum Measure {
    /// Of the right kind, so that waveforms count.
    Waveforms(Rig),
    /// With a transmission path in the place of a structure that is not the rig's, so that only the rhythm counts.
    Rhythm(Rig),
}

fn measure(task: &Task, progress: &dyn Fn(&str)) -> Result<Measure, DiagnoseError> {
    let Task { rig, baseline, recordings, seed } = *task;
    if let Some(baseline) = baseline {
        progress("calibrating to the baseline");
        let rig = calibrate(rig, baseline, &Options { seed, ..Options::default() }, progress)?.rig;
        return Ok(if rig.paths.is_empty() { Measure::Waveforms(rig) } else { Measure::Rhythm(rig) });
    }
    if !rig.unknown.is_empty() {
        progress("fitting the rig's unknown parameters");
        if let Some(rig) = recorded::beyond_the_rig(rig, recordings, seed)? {
            return Ok(Measure::Rhythm(rig));
        }
    }
    Ok(Measure::Waveforms(rig.clone()))
}

/// Whether an explanation stands.
struct Judgement {
    /// What it does to recordings that took no part; `None` where nothing was kept, or cannot be run there.
    proof: Option<Proof>,
    /// What speaks against it.
    failure: Option<Failure>,
    /// Of the machine, whatever the acquisition does.
    verdict: Verdict,
}

impl Judgement {
    fn of(ground: &Ground, explanation: &Explanation, progress: &dyn Fn(&str)) -> Result<Self, DiagnoseError> {
        let (excess, left) = (ground.excess, explanation.left);
        let proof = match explanation.last() {
            Some(last) => {
                progress("proving it on what took no part");
                // A rig that cannot be run under the condition that was held out is not proved.
                prove(&ground.rig()?, &last.rig()?, &ground.sets.held_out, ground.seed).ok()
            }
            None => None,
        };
        let explained = excess.explained(&left);
        let failure = if left.is_more_than_chance() && explained <= EXPLAINED {
            Some(Failure::Leaves(1.0 - explained.max(0.0)))
        } else {
            match &proof {
                Some(p) if p.p_value < LEAST_P && p.after < p.before => {
                    // A cause may make recordings more likely by but making the noise greater that is expected of them.
                    (p.error_ratio > GREATEST_ERROR_RATIO).then(|| Failure::Errs(p.error_ratio.sqrt()))
                }
                _ => Some(Failure::NotConfirmed),
            }
        };
        let verdict = if failure.is_none() {
            Verdict::Mismatch
        } else if excess.is_more_than_chance() {
            Verdict::Unexplained
        } else {
            Verdict::NoMismatch
        };
        Ok(Self { proof, failure, verdict })
    }
}

/// Faults of the acquisition and causes in the machine together; `raw` are the recordings with the faults in them.
fn outcome(
    raw: &[Recording],
    acquired: &Acquired,
    ground: &Ground,
    explanation: &Explanation,
    judgement: Judgement,
    progress: &dyn Fn(&str),
) -> Result<Outcome, DiagnoseError> {
    let Judgement { proof, failure, verdict } = judgement;
    let stands = failure.is_none();
    let (rig, split) = (&ground.contest.rig, &ground.sets.split);
    let (problem, found) = match explanation.last() {
        Some(last) if stands => (&last.problem, &last.found),
        _ => (&ground.problem, &ground.found),
    };
    let mut corrected = problem.rig_at(&found.point.coordinates)?;
    let (values, fitted) = statement::parameters(problem, found, rig, ground.contest.unknown.len());
    let mut causes: Vec<Cause> = acquired.faults().map(statement::of_fault).collect();
    if stands {
        causes.extend(statement::causes(&corrected, rig, &values, explanation, proof.as_ref()));
    }
    corrected.effects.extend(acquired.faults().rev().map(|fault| fault.effect.clone()));
    let faulty = acquired.faults().next().is_some();
    let verdict = if faulty { Verdict::Mismatch } else { verdict };
    let location = match verdict {
        Verdict::NoMismatch => Location::default(),
        _ => locate::locate(rig, &corrected, &ground.sets.fitted, &ground.residuals),
    };
    let (fit, held_out) = if faulty {
        progress("showing it on what took no part");
        let p_value = acquired.faults().map(|fault| fault.p_value).fold(0.0, f64::max);
        shown(rig, &corrected, &Observed::of_all(&Split::of(raw).held_out)?, &split.describe(), p_value, ground.seed)?
    } else {
        statement::fit(proof, stands, split.describe())
    };
    let rejected = statement::rejected(explanation, failure);
    let caveats = match failure {
        Some(failure) if verdict == Verdict::Unexplained => vec![failure.caveat(EXPLAINED)],
        _ => Vec::new(),
    };
    let diagnosis = Diagnosis { schema: SCHEMA.into(), verdict, causes, rejected, location, fit };
    Ok(Outcome { diagnosis, rig: corrected, held_out, tests: tests(&ground.residuals), fitted, caveats })
}
