//! Score of one case: diagnosis against truth.

use serde::Serialize;

use super::Ran;
use super::calibration::Said;
use crate::diagnose::result::{Cause, Diagnosis, Left, Parameter};
use crate::evaluate::cases::case_spec::{CaseSpec, Hidden, Kind};
use crate::evaluate::cases::{HiddenEffect, Truth};

/// One case, scored.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Score {
    /// Name of the case.
    pub case: String,
    /// Kind of case.
    pub kind: &'static str,
    /// Severity of a single effect.
    pub severity: Option<&'static str>,
    /// Whether the noise was several times the usual.
    pub loud: bool,
    /// Whether a tachometer was recorded.
    pub tachometer: bool,
    /// Whether some parameters of the rig were guesses.
    pub guessed: bool,
    /// Hidden causes.
    pub truth: Truth,
    /// Names of the diagnosed causes; empty for a verdict without a cause.
    pub said: Vec<String>,
    /// The same with their probabilities.
    pub probabilities: Vec<Said>,
    /// Verdict, or the error of the diagnosis.
    pub verdict: String,
    /// Whether the diagnosed causes are exactly the hidden ones.
    pub right: bool,
    /// Whether the first diagnosed cause is a hidden one.
    pub first_right: bool,
    /// Whether a hidden cause is named and no other; `None` where none is named.
    pub nothing_beside: Option<bool>,
    /// Parameters of right causes.
    pub parameters: Vec<Checked>,
    /// Held-out error before and after, if a cause was diagnosed.
    pub held_out: Option<[f64; 2]>,
    /// Log-spectral distance of the held-out signals, dB, before and after, if a cause was diagnosed.
    pub distance: Option<[f64; 2]>,
    /// Share of the mismatch that the diagnosis says is left.
    pub left: Option<f64>,
    /// Wall time, s.
    pub seconds: f64,
}

/// Diagnosis of a case, and what its held-out signals show.
#[derive(Clone, Copy, Debug)]
pub struct Outcome<'a> {
    /// The diagnosis; `None` if it ended with an error.
    pub said: Option<&'a Diagnosis>,
    /// Log-spectral distance of the held-out signals, dB, before and after.
    pub distance: Option<[f64; 2]>,
    /// The run.
    pub ran: &'a Ran,
}

/// Estimate of a parameter against its true value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Checked {
    /// Cause and key.
    pub key: String,
    /// True value.
    pub truth: f64,
    /// Estimated value.
    pub found: f64,
    /// Whether the 95 % interval holds the truth; `None` without an interval.
    pub held: Option<bool>,
}

impl Score {
    /// Score of a case.
    pub fn new(case: String, spec: &CaseSpec, truth: Truth, outcome: &Outcome) -> Self {
        let Outcome { said, distance, ran } = *outcome;
        let names: Vec<String> = said.map_or(Vec::new(), |s| s.causes.iter().map(|c| c.name.clone()).collect());
        let verdict = match (said, &ran.error) {
            (Some(said), _) => said.verdict.name().to_owned(),
            (None, error) => format!("error: {}", error.as_deref().unwrap_or("none stated")),
        };
        let counts = |name: &String| truth.causes.contains(name) || truth.accept.contains(name);
        let named: Vec<Said> = said.map_or(Vec::new(), |s| {
            let cause = |c: &Cause| Said { name: c.name.clone(), probability: c.probability, right: counts(&c.name) };
            s.causes.iter().map(cause).collect()
        });
        let nothing_beside = named.iter().any(|s| s.right).then(|| named.iter().all(|s| s.right));
        let (right, first_right) = match spec.kind() {
            Kind::Control => (verdict == "no-mismatch", verdict == "no-mismatch"),
            Kind::Outside => (verdict == "unexplained", verdict == "unexplained"),
            Kind::Single | Kind::Pair => {
                let named = |cause: &String| names.contains(cause) || truth.accept.iter().any(|a| names.contains(a));
                let all = names.iter().all(counts) && truth.causes.iter().all(named);
                (all, names.first().is_some_and(counts))
            }
        };
        let severity = match &spec.hidden {
            Hidden::Effects(names) if names.len() == 1 => Some(names[0].1.name()),
            _ => None,
        };
        Self {
            case,
            kind: spec.kind().name(),
            severity,
            loud: spec.loud,
            tachometer: spec.tachometer,
            guessed: spec.guessed,
            said: names.clone(),
            probabilities: named,
            nothing_beside,
            verdict,
            right,
            first_right,
            parameters: said.map_or(Vec::new(), |s| checked(&truth, s)),
            held_out: said.filter(|s| !s.causes.is_empty()).map(|s| [s.fit.before, s.fit.after]),
            distance: distance.filter(|_| said.is_some_and(|s| !s.causes.is_empty())),
            left: said.filter(|s| !s.causes.is_empty() && s.left != Left::default()).map(|s| s.left.share),
            seconds: ran.seconds,
            truth,
        }
    }
}

fn checked(truth: &Truth, said: &Diagnosis) -> Vec<Checked> {
    let mut out = Vec::new();
    for cause in &said.causes {
        // A value at another place is not the same quantity.
        let elsewhere = |(key, name): (&String, &String)| matches!(cause.parameters.get(key), Some(Parameter::Name(found)) if found != name);
        let here = |e: &&HiddenEffect| e.name == cause.name && !e.names.iter().any(elsewhere);
        let effects: Vec<_> = truth.effects.iter().filter(here).collect();
        for (key, found) in &cause.parameters {
            let Parameter::Number(found) = found else { continue };
            // An event of several recordings has several true values, of which the diagnosis states one.
            let values = effects.iter().filter_map(|e| e.numbers.get(key).copied());
            let Some(truth) = values.min_by(|a, b| (a - found).abs().total_cmp(&(b - found).abs())) else { continue };
            let held = cause.interval95.get(key).map(|[low, high]| (*low..=*high).contains(&truth));
            out.push(Checked { key: format!("{} {key}", cause.name), truth, found: *found, held });
        }
    }
    out
}
