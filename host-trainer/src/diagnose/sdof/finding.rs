//! What a diagnosis of a rig of one degree of freedom says.

use serde::Serialize;

use crate::diagnose::result::Verdict;
use crate::identify::force_balance::HeldOutTrace;
use crate::rig::config::RigKind;
use crate::rig::{EffectEntry, Rig};

/// A number of a cause.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CauseParameter {
    /// Its name in the vocabulary.
    pub name: String,
    /// Its value, SI.
    pub value: f64,
    /// 95 % interval, where it was fitted.
    pub interval95: Option<[f64; 2]>,
}

/// A cause that stands.
#[derive(Clone, Debug, Serialize)]
pub struct FoundCause {
    /// Its name in the vocabulary.
    pub name: String,
    /// Share of redrawn sets of held-out blocks in which a model with it leaves least.
    pub probability: f64,
    /// Numbers of the vocabulary.
    pub parameters: Vec<CauseParameter>,
    /// One sentence that a person can check.
    pub evidence: String,
    /// The term it adds.
    pub equation: String,
    /// For the corrected rig.
    #[serde(skip)]
    pub entry: EffectEntry,
}

/// A cause that was considered and does not stand.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rejected {
    /// Its name in the vocabulary.
    pub name: String,
    /// Why.
    pub why: String,
}

/// Where the mismatch sits.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Where {
    /// Recording and from when to when it leaves most, s.
    pub time_s: Vec<(String, [f64; 2])>,
    /// The band that holds most of what the rig leaves, Hz.
    pub frequency_hz: [f64; 2],
    /// In which positions and speeds, in words.
    pub state: String,
}

/// How well it fits, root mean square over rows that took no part in each fit, in units of the disturbance.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct HeldOutFit {
    /// What is measured.
    pub metric: String,
    /// Which recordings or parts were held out in turn.
    pub held_out: String,
    /// The rig, its unknown parameters fitted.
    pub before: f64,
    /// With the causes.
    pub after: f64,
    /// By the sensor's noise alone.
    pub noise_floor: f64,
    /// With columns that have no name on top: the least that is known to be possible.
    pub explainable: f64,
    /// Share of what is explainable which the causes explain.
    pub explained_share: f64,
    /// Of causes against none, by permutation of blocks.
    pub p_value: f64,
}

/// A test of what the rig without causes leaves of the balance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResidualTest {
    /// What is looked for in it.
    pub what: String,
    /// What it takes away on held-out blocks, in standard deviations of the same with each block's sign by chance.
    pub z: f64,
    /// Probability of as much by chance.
    pub p_value: f64,
}

/// The result of a diagnosis.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// The verdict.
    pub verdict: Verdict,
    /// Causes by probability; none unless the verdict is a mismatch.
    pub causes: Vec<FoundCause>,
    /// The others.
    pub rejected: Vec<Rejected>,
    /// Where it sits.
    pub location: Where,
    /// How well it fits.
    pub fit: HeldOutFit,
    /// The unknown parameters, fitted together with the causes: key, value, 95 % interval.
    pub own: Vec<CauseParameter>,
    /// Noise of the sensor, standard deviation in its unit.
    pub sensor_noise_std: f64,
    /// What was looked for in the residual of the rig without causes, the most telling first.
    pub tests: Vec<ResidualTest>,
    /// Recordings that took no part.
    pub traces: Vec<HeldOutTrace>,
    /// The rig with fitted parameters and causes.
    #[serde(skip)]
    pub rig: Rig,
}

/// A fault.
#[derive(Clone, Debug)]
pub struct Fault {
    /// Its effect.
    pub entry: EffectEntry,
    /// The sentence.
    pub evidence: String,
}

impl Fault {
    /// As a cause that stands.
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
