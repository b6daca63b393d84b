//! Result of a diagnosis of a rig of one degree of freedom.

use serde::Serialize;

use crate::diagnose::result::Verdict;
use crate::identify::force_balance::HeldOutTrace;
use crate::rig::config::RigKind;
use crate::rig::{EffectEntry, Rig};

/// Parameter of a cause.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CauseParameter {
    /// Name in the vocabulary.
    pub name: String,
    /// Value, SI units.
    pub value: f64,
    /// 95 % interval, if fitted.
    pub interval95: Option<[f64; 2]>,
}

/// Accepted cause.
#[derive(Clone, Debug, Serialize)]
pub struct FoundCause {
    /// Name in the vocabulary.
    pub name: String,
    /// Bootstrap probability that a model with the cause is best, theory (84).
    pub probability: f64,
    /// Parameters of the vocabulary.
    pub parameters: Vec<CauseParameter>,
    /// Evidence in one checkable sentence.
    pub evidence: String,
    /// Equation of the effect.
    pub equation: String,
    /// Effect for the corrected rig.
    #[serde(skip)]
    pub entry: EffectEntry,
}

/// Rejected cause.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rejected {
    /// Name in the vocabulary.
    pub name: String,
    /// Reason of the rejection.
    pub why: String,
}

/// Location of the mismatch.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Where {
    /// Recordings and stretches of the largest residual, s.
    pub time_s: Vec<(String, [f64; 2])>,
    /// Band with most of the residual, Hz.
    pub frequency_hz: [f64; 2],
    /// Positions and velocities of the largest residual, in words.
    pub state: String,
}

/// Cross-validated RMS of the residual, in units of the disturbance.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct HeldOutFit {
    /// Measure of the error.
    pub metric: String,
    /// Recordings or parts held out in turn.
    pub held_out: String,
    /// Error of the rig, its unknown parameters fitted.
    pub before: f64,
    /// Error with the causes.
    pub after: f64,
    /// Error by the sensor's noise alone.
    pub noise_floor: f64,
    /// Error with flexible columns in addition: the attainable minimum.
    pub explainable: f64,
    /// Share of the explainable error that the causes explain.
    pub explained_share: f64,
    /// p-value of the causes against none, by sign flips of blocks, theory (81).
    pub p_value: f64,
}

/// Test of the residual of the rig without causes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResidualTest {
    /// Tested force.
    pub what: String,
    /// Reduction of the held-out error, in standard deviations of its sign-flip distribution.
    pub z: f64,
    /// p-value of the reduction.
    pub p_value: f64,
}

/// Result of a diagnosis of the rig of one degree of freedom.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// Verdict of the diagnosis.
    pub verdict: Verdict,
    /// Causes by probability; none unless the verdict is a mismatch.
    pub causes: Vec<FoundCause>,
    /// Rejected causes.
    pub rejected: Vec<Rejected>,
    /// Location of the mismatch.
    pub location: Where,
    /// Cross-validated fit.
    pub fit: HeldOutFit,
    /// Unknown parameters, fitted jointly with the causes: key, value, 95 % interval.
    pub own: Vec<CauseParameter>,
    /// Standard deviation of the sensor's noise, in its unit.
    pub sensor_noise_std: f64,
    /// Tests of the residual of the rig without causes, the most significant first.
    pub tests: Vec<ResidualTest>,
    /// Held-out recordings.
    pub traces: Vec<HeldOutTrace>,
    /// Rig with fitted parameters and causes.
    #[serde(skip)]
    pub rig: Rig,
}

/// Acquisition fault or single event.
#[derive(Clone, Debug)]
pub struct Fault {
    /// Effect of the fault.
    pub entry: EffectEntry,
    /// Evidence in a sentence.
    pub evidence: String,
}

impl Fault {
    /// Accepted cause for the fault.
    pub fn cause(&self) -> FoundCause {
        let stated = self.entry.definition().parameters.iter().filter(|p| p.in_vocabulary());
        let parameters = stated.filter_map(|parameter| {
            let value = self.entry.number(parameter.key)?;
            Some(CauseParameter { name: parameter.key.to_string(), value, interval95: None })
        });
        FoundCause {
            name: self.entry.kind.to_string(),
            probability: 0.99,
            parameters: parameters.collect(),
            evidence: self.evidence.clone(),
            equation: self.entry.equation(RigKind::Sdof),
            entry: self.entry.clone(),
        }
    }
}
