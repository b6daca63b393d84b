//! What a diagnosis says, as `diagnosis.json` has it.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::rig::{Rig, Value};

/// Name of the format.
pub const SCHEMA: &str = "ballrace-diagnosis/1";

/// The verdict.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Named causes explain what the rig leaves.
    Mismatch,
    /// The rig, its unknown parameters fitted, explains the recordings.
    NoMismatch,
    /// Something is there that no cause of the vocabulary explains.
    Unexplained,
}

impl Verdict {
    /// As `diagnosis.json` has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mismatch => "mismatch",
            Self::NoMismatch => "no-mismatch",
            Self::Unexplained => "unexplained",
        }
    }
}

/// A parameter: a number in SI units, or a name.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Parameter {
    /// A number.
    Number(f64),
    /// The name of a component or a channel.
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

/// A cause that the tool stands by.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Cause {
    /// Name in the vocabulary.
    pub name: String,
    /// Probability, given that it is one of the vocabulary.
    pub probability: f64,
    /// Parameters in SI units.
    pub parameters: BTreeMap<String, Parameter>,
    /// Intervals of the numbers among them that hold the truth with 95 % probability.
    pub interval95: BTreeMap<String, [f64; 2]>,
    /// One sentence that a person can check.
    pub evidence: String,
    /// The term added, in the rig's symbols.
    pub equation: String,
}

/// An explanation that lost.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Rejected {
    /// Name in the vocabulary.
    pub name: String,
    /// Why it lost.
    pub why: String,
}

/// Where the mismatch is.
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
    /// The channel that shows it most.
    pub channel: String,
}

/// How the fit to recordings that took no part has changed.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Fit {
    /// What is measured.
    pub metric: String,
    /// Which recordings.
    pub held_out: String,
    /// By the rig as it was.
    pub before: f64,
    /// By the corrected rig.
    pub after: f64,
    /// What the right rig would reach.
    pub noise_floor: f64,
    /// Probability of as great an improvement by chance.
    pub p_value: f64,
}

/// `diagnosis.json`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Diagnosis {
    /// [`SCHEMA`].
    pub schema: Cow<'static, str>,
    /// What it comes to.
    pub verdict: Verdict,
    /// Causes, the most probable first; none without a mismatch.
    pub causes: Vec<Cause>,
    /// Explanations that lost.
    pub rejected: Vec<Rejected>,
    /// Where the mismatch is.
    pub location: Location,
    /// What the causes do to the fit.
    pub fit: Fit,
}

/// A recording that took no part, as measured and as simulated; one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// File name without ending; the channel is part of it where there are several.
    pub name: String,
    /// Samples per second.
    pub sample_rate_hz: f64,
    /// As measured.
    pub measured: Vec<f64>,
    /// As the rig gives it.
    pub before: Vec<f64>,
    /// As the corrected rig gives it.
    pub after: Vec<f64>,
}

/// What a test looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Aspect {
    /// The mean.
    Mean,
    /// Skewness and kurtosis.
    Moments,
    /// Power in a band.
    Spectrum,
    /// Power in a stretch of time beside the rest.
    Time,
    /// A line at an order of the shaft beside what is around it.
    Order,
    /// The same in the spectrum of the squared signal.
    Envelope,
    /// Power at an angle of the shaft beside the rest.
    ShaftAngle,
    /// Power at a place of the balls in their pitch beside the rest.
    CageAngle,
    /// Power where the channel's position is in a range, beside the rest.
    Displacement,
    /// The same of its velocity.
    Velocity,
    /// How power goes with the load of recordings.
    Load,
    /// How power goes with their speed.
    Speed,
    /// The comb of lines that a pit gives the envelope.
    Comb,
    /// A force as of a term of the library.
    Force,
}

/// A test: whether, and where.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Test {
    /// What it looks at.
    pub aspect: Aspect,
    /// In which channel; empty where that is not asked.
    pub channel: &'static str,
    /// From where to where: Hz, s, order, rad, m or m/s as its aspect says.
    pub at: Option<[f64; 2]>,
    /// What is tested, such as `ay, power from 3200 to 3600 Hz`.
    pub what: String,
    /// The statistic, in standard deviations of what chance gives.
    pub z: f64,
    /// Probability of as much by chance, before any correction for how many tests there are.
    pub p_value: f64,
    /// The least rate of false discoveries at which it stands out of all tests.
    pub q_value: f64,
}

impl Aspect {
    /// What tests of the aspect look at, in words.
    pub fn text(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::Moments => "skewness and kurtosis",
            Self::Spectrum => "power in bands",
            Self::Time => "power over time",
            Self::Order => "lines at orders of the shaft",
            Self::Envelope => "lines of the envelope",
            Self::ShaftAngle => "power over the shaft's angle",
            Self::CageAngle => "power over the balls' place",
            Self::Displacement => "power over position",
            Self::Velocity => "power over velocity",
            Self::Load => "dependence on load",
            Self::Speed => "dependence on speed",
            Self::Comb => "comb of a pit",
            Self::Force => "forces",
        }
    }
}

impl Test {
    /// Whether it stands out of all tests at [`FDR_LEVEL`].
    pub fn is_significant(&self) -> bool {
        self.q_value <= FDR_LEVEL
    }
}

/// Rate of false discoveries among tests that stand out.
pub const FDR_LEVEL: f64 = 0.01;

/// A parameter of the rig that was fitted along: name, value, 95 % interval.
pub type Fitted = (String, f64, [f64; 2]);

/// A diagnosis with what stands behind it.
#[derive(Clone, Debug)]
pub struct DiagnosisResult {
    /// What it says.
    pub diagnosis: Diagnosis,
    /// The rig with its causes.
    pub rig: Rig,
    /// Recordings that took no part.
    pub held_out: Vec<HeldOut>,
    /// Tests of what the rig leaves without causes, the most telling first.
    pub tests: Vec<Test>,
    /// Unknown parameters of the rig.
    pub fitted: Vec<Fitted>,
    /// Caveats, a sentence each.
    pub caveats: Vec<String>,
}
