//! Result of a diagnosis, in the form of `diagnosis.json`.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::{Rig, Value};

/// Name and version of the format.
pub const SCHEMA: &str = "ballrace-diagnosis/1";

/// Verdict of a diagnosis.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Named causes explain the mismatch.
    Mismatch,
    /// The rig, its unknown parameters fitted, explains the recordings.
    NoMismatch,
    /// No cause of the vocabulary explains the mismatch.
    Unexplained,
}

impl Verdict {
    /// Name in `diagnosis.json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mismatch => "mismatch",
            Self::NoMismatch => "no-mismatch",
            Self::Unexplained => "unexplained",
        }
    }
}

/// Parameter of a cause: a number in SI units, or a name.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Parameter {
    /// Number in SI units.
    Number(f64),
    /// Name of a component or a channel.
    Name(String),
}

impl From<&Value> for Parameter {
    fn from(value: &Value) -> Self {
        match value {
            Value::Number(number) => Self::Number(*number),
            Value::Text(text) => Self::Name(text.clone()),
        }
    }
}

/// Accepted cause of a mismatch.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Cause {
    /// Name in the vocabulary.
    pub name: String,
    /// Probability, given that the cause is in the vocabulary.
    pub probability: f64,
    /// Parameters in SI units.
    pub parameters: BTreeMap<String, Parameter>,
    /// 95 % intervals of the numeric parameters, SI units.
    pub interval95: BTreeMap<String, [f64; 2]>,
    /// Evidence in one checkable sentence.
    pub evidence: String,
    /// Equation of the effect, in the rig's symbols.
    pub equation: String,
    /// What tells it, with units, for a sentence; empty where its parameters do. Not part of `diagnosis.json`.
    #[serde(skip)]
    pub signs: String,
}

impl Cause {
    /// Key with quantity and unit of a parameter that the vocabulary calls `value` or `amplitude`; the others as they are.
    pub fn key_with_unit<'k>(&self, key: &'k str) -> &'k str {
        let name = |key: ParameterKey| match self.parameters.get(key.name()) {
            Some(Parameter::Name(name)) => name.as_str(),
            _ => "",
        };
        let of_signal = |acceleration, displacement, other| match name(ParameterKey::Channel) {
            "ax" | "ay" | "qdd" => acceleration,
            "q" => displacement,
            _ => other,
        };
        match (EffectKind::parse(&self.name), ParameterKey::parse(key)) {
            (Some(EffectKind::MassChange), Some(ParameterKey::Value)) => "mass_kg",
            (Some(EffectKind::DampingChange), Some(ParameterKey::Value)) => "damping_n_s_per_m",
            (Some(EffectKind::StiffnessChange), Some(ParameterKey::Value)) => match name(ParameterKey::Component) {
                "bearing" => "contact_stiffness_n_per_m1_5",
                _ => "stiffness_n_per_m",
            },
            (Some(EffectKind::SensorGain), Some(ParameterKey::Value)) => "gain",
            (Some(EffectKind::SensorBias), Some(ParameterKey::Value)) => {
                of_signal("offset_m_per_s2", "offset_m", "offset")
            }
            (Some(EffectKind::SensorClipping), Some(ParameterKey::Value)) => {
                of_signal("limit_m_per_s2", "limit_m", "limit")
            }
            (Some(EffectKind::MainsInterference), Some(ParameterKey::Amplitude)) => {
                of_signal("amplitude_m_per_s2", "amplitude_m", key)
            }
            _ => key,
        }
    }
}

/// Rejected cause.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Rejected {
    /// Name in the vocabulary.
    pub name: String,
    /// Reason of the rejection.
    pub why: String,
}

/// Location of the mismatch.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Location {
    /// Intervals of time, s.
    pub time_s: Vec<[f64; 2]>,
    /// Bands of frequency, Hz.
    pub frequency_hz: Vec<[f64; 2]>,
    /// Orders of the shaft.
    pub order: Vec<f64>,
    /// Angles, rad.
    pub angle_rad: Vec<[f64; 2]>,
    /// Region of the state, in words.
    pub state: String,
    /// Channel of the largest mismatch.
    pub channel: String,
}

/// Missing force of a cause, as a curve with its band.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Term {
    /// Degree of freedom or channel that the term acts on, such as `outer-y`.
    pub force_on: String,
    /// Variable that it depends on, such as `outer-y`, `shaft angle`, `time`.
    pub depends_on: String,
    /// Equation in the rig's symbols.
    pub equation: String,
    /// Points of the curve: variable, value, lower and upper end of the 95 % band.
    pub curve: Vec<[f64; 4]>,
    /// Unit of the value.
    pub unit: String,
}

/// Fitted properties of a recording that are no cause.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Nuisance {
    /// Name of the recording.
    pub recording: String,
    /// Mean speed of the shaft, Hz; `None` where the recording does not show it.
    pub shaft_hz: Option<f64>,
    /// Slip of the cage, as a share of its kinematic speed.
    pub slip: Option<f64>,
    /// Standard deviation of the speed around its mean, as a share of it.
    pub wander: Option<f64>,
}

/// Part of the mismatch that the causes do not explain.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Left {
    /// Share of the mismatch, 0 to 1.
    pub share: f64,
    /// Bands of frequency, Hz.
    pub frequency_hz: Vec<[f64; 2]>,
    /// Orders of the shaft.
    pub order: Vec<f64>,
    /// Channel with the largest part.
    pub channel: String,
}

/// Fit to held-out recordings, before and after the correction.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Fit {
    /// Measure of the error, with its unit.
    pub metric: String,
    /// Held-out recordings.
    pub held_out: String,
    /// Error of the rig, its unknown parameters fitted.
    pub before: f64,
    /// Error of the corrected rig.
    pub after: f64,
    /// Error that the true rig would have.
    pub noise_floor: f64,
    /// p-value of the improvement.
    pub p_value: f64,
}

/// Content of `diagnosis.json`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Diagnosis {
    /// Format, [`SCHEMA`].
    pub schema: Cow<'static, str>,
    /// Verdict of the diagnosis.
    pub verdict: Verdict,
    /// Accepted causes, the most probable first; without a mismatch none, or a change that is `unexplained` (of a rig of unknown
    /// structure against its baseline).
    pub causes: Vec<Cause>,
    /// Rejected causes.
    pub rejected: Vec<Rejected>,
    /// Location of the mismatch.
    pub location: Location,
    /// Missing forces as curves.
    #[serde(default)]
    pub terms: Vec<Term>,
    /// Fitted properties of the recordings that are no cause.
    #[serde(default)]
    pub nuisance: Vec<Nuisance>,
    /// What the causes do not explain.
    #[serde(default)]
    pub left: Left,
    /// Fit to held-out recordings.
    pub fit: Fit,
}

/// One channel of a held-out recording, measured and simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// File name without ending; the channel is part of it where there are several.
    pub name: String,
    /// Samples per second.
    pub sample_rate_hz: f64,
    /// Measured samples, SI units.
    pub measured: Vec<f64>,
    /// Simulation by the rig before the correction.
    pub before: Vec<f64>,
    /// Simulation by the corrected rig.
    pub after: Vec<f64>,
}

impl HeldOut {
    /// Name of a channel of a recording, where there are several channels.
    pub fn name_of(recording: &str, channel: &str) -> String {
        format!("{recording}-{channel}")
    }
}

/// Aspect of a residual that a test examines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Aspect {
    /// Mean.
    Mean,
    /// Skewness and kurtosis.
    Moments,
    /// Power in a band.
    Spectrum,
    /// Power in a stretch of time relative to the rest.
    Time,
    /// Line at an order of the shaft relative to the noise around it.
    Order,
    /// Line in the spectrum of the squared signal.
    Envelope,
    /// Power at a shaft angle relative to the rest.
    ShaftAngle,
    /// Power at a position of the balls in their pitch relative to the rest.
    CageAngle,
    /// Power in a range of the channel's position relative to the rest.
    Displacement,
    /// Power in a range of the channel's velocity relative to the rest.
    Velocity,
    /// Dependence of power on the load of recordings.
    Load,
    /// Dependence of power on the speed of recordings.
    Speed,
    /// Comb of envelope lines of a local defect.
    Comb,
    /// Force of a term of the library.
    Force,
}

/// Significance test of a residual.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Test {
    /// Aspect of the residual.
    pub aspect: Aspect,
    /// Channel; empty if the test has none.
    pub channel: &'static str,
    /// Interval in Hz, s, order, rad, m or m/s, by the aspect.
    pub at: Option<[f64; 2]>,
    /// Description, such as `ay, power from 3200 to 3600 Hz`.
    pub what: String,
    /// Statistic in standard deviations of its null distribution.
    pub z: f64,
    /// p-value of this test alone.
    pub p_value: f64,
    /// Smallest false discovery rate at which the test is significant.
    pub q_value: f64,
}

impl Aspect {
    /// Name of the aspect for reports.
    pub fn text(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::Moments => "skewness and kurtosis",
            Self::Spectrum => "power in bands",
            Self::Time => "power over time",
            Self::Order => "lines at orders of the shaft",
            Self::Envelope => "lines of the envelope",
            Self::ShaftAngle => "power over the shaft's angle",
            Self::CageAngle => "power over the balls' position",
            Self::Displacement => "power over position",
            Self::Velocity => "power over velocity",
            Self::Load => "dependence on load",
            Self::Speed => "dependence on speed",
            Self::Comb => "comb of a local defect",
            Self::Force => "forces",
        }
    }
}

impl Test {
    /// Whether the test is significant at [`FDR_LEVEL`].
    pub fn is_significant(&self) -> bool {
        self.q_value <= FDR_LEVEL
    }
}

/// False discovery rate of significant tests.
pub const FDR_LEVEL: f64 = 0.01;

/// Unknown parameter of the rig that was fitted: name, value, 95 % interval.
pub type Fitted = (String, f64, [f64; 2]);

/// Diagnosis with corrected rig, held-out traces, tests and caveats.
#[derive(Clone, Debug)]
pub struct DiagnosisResult {
    /// Content of `diagnosis.json`.
    pub diagnosis: Diagnosis,
    /// Corrected rig.
    pub rig: Rig,
    /// Held-out recordings.
    pub held_out: Vec<HeldOut>,
    /// Tests of the residual without causes, the most significant first.
    pub tests: Vec<Test>,
    /// Unknown parameters of the rig, fitted.
    pub fitted: Vec<Fitted>,
    /// Caveats, a sentence each.
    pub caveats: Vec<String>,
    /// Settings of each stage.
    pub settings: serde_json::Value,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_told_with_its_quantity_and_unit() {
        let said = |kind: EffectKind, key: &'static str, place: Option<(ParameterKey, &str)>| {
            let named = place.map(|(key, name)| (key.name().to_owned(), Parameter::Name(name.to_owned())));
            let cause = Cause { name: kind.to_string(), parameters: named.into_iter().collect(), ..Cause::default() };
            cause.key_with_unit(key)
        };
        assert_eq!(said(EffectKind::DampingChange, "value", None), "damping_n_s_per_m");
        let of = |component| said(EffectKind::StiffnessChange, "value", Some((ParameterKey::Component, component)));
        assert_eq!(["inner-x", "bearing"].map(of), ["stiffness_n_per_m", "contact_stiffness_n_per_m1_5"]);
        let on = |channel| said(EffectKind::SensorBias, "value", Some((ParameterKey::Channel, channel)));
        assert_eq!(["ay", "q", "all"].map(on), ["offset_m_per_s2", "offset_m", "offset"]);
        assert_eq!(said(EffectKind::SensorGain, "value", None), "gain");
        assert_eq!(said(EffectKind::OuterRaceDefect, "depth_m", None), "depth_m");
    }
}
