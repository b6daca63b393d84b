//! Parser of the written form of faults, with errors that state where, what was found and what was expected.

use std::fmt;
use std::str::FromStr;

use super::{Fault, FaultPlan};

/// Greatest run, samples: guards against typing errors.
const MAX_RUN: u32 = 1_000_000_000;

/// Error of a text that is no list of faults.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlanError {
    /// Place of the fault in the list, from 1.
    pub place: usize,
    /// Characters of the text before the error.
    pub column: usize,
    /// Text found.
    pub found: String,
    /// Form expected.
    pub problem: Problem,
}

/// Form expected in place of an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Problem {
    /// A fault with a name and a value.
    Form,
    /// One of the names.
    Name,
    /// A probability.
    Probability,
    /// A run after a probability.
    Run,
    /// A probability alone.
    NoRun,
    /// A level.
    Level,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Form => "NAME:VALUE, as in nan:0.001",
            Self::Name => "drop, gap, stuck, saturate, nan or flip",
            Self::Probability => "a probability per sample, 0 to 1",
            Self::Run => "PROBABILITYxSAMPLES with 1 to 1000000000 samples, as in 1e-4x50",
            Self::NoRun => "a probability alone, since this fault breaks single samples",
            Self::Level => "a level in m/s^2, a number above 0",
        })
    }
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { place, column, found, problem } = self;
        write!(f, "faults: entry {place}, character {}: found {found:?}, expected {problem}", column + 1)
    }
}

impl std::error::Error for PlanError {}

impl FromStr for FaultPlan {
    type Err = PlanError;

    fn from_str(text: &str) -> Result<Self, PlanError> {
        if text.trim().is_empty() {
            return Ok(Self::default());
        }
        let faults = text.split(',').zip(1..).map(|(entry, place)| {
            fault(entry).map_err(|(found, problem)| {
                // Both are slices of `text`, so their distance is the error's offset.
                let bytes = found.as_ptr() as usize - text.as_ptr() as usize;
                let column = text.get(..bytes).map_or(0, |before| before.chars().count());
                PlanError { place, column, found: found.to_owned(), problem }
            })
        });
        faults.collect::<Result<_, _>>().map(Self)
    }
}

/// Fault of one entry, or the wrong part of it.
fn fault(entry: &str) -> Result<Fault, (&str, Problem)> {
    let entry = entry.trim();
    let (name, value) = entry.split_once(':').ok_or((entry, Problem::Form))?;
    Ok(match name {
        "drop" => Fault::Drop { probability: alone(value)? },
        "nan" => Fault::Nan { probability: alone(value)? },
        "flip" => Fault::Flip { probability: alone(value)? },
        "gap" => {
            let (probability, run) = with_run(value)?;
            Fault::Gap { probability, run }
        }
        "stuck" => {
            let (probability, run) = with_run(value)?;
            Fault::Stuck { probability, run }
        }
        "saturate" => {
            let level = value.parse().ok().filter(|level: &f32| *level > 0.0 && level.is_finite());
            Fault::Saturate { level: level.ok_or((value, Problem::Level))? }
        }
        _ => return Err((name, Problem::Name)),
    })
}

fn alone(value: &str) -> Result<f64, (&str, Problem)> {
    match value.split_once('x') {
        Some((before, _)) if probability(before).is_ok() => Err((value, Problem::NoRun)),
        _ => probability(value),
    }
}

fn with_run(value: &str) -> Result<(f64, u32), (&str, Problem)> {
    let (chance, run) = value.split_once('x').ok_or((value, Problem::Run))?;
    let chance = probability(chance)?;
    let samples = run.parse().ok().filter(|run| (1..=MAX_RUN).contains(run));
    Ok((chance, samples.ok_or((run, Problem::Run))?))
}

fn probability(value: &str) -> Result<f64, (&str, Problem)> {
    value.parse().ok().filter(|p| (0.0..=1.0).contains(p)).ok_or((value, Problem::Probability))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documented_form_is_read() {
        let plan: FaultPlan = " nan:0.001,stuck:1e-4x50, saturate:30,flip:1e-5,drop:1e-3,gap:1e-5x200".parse().unwrap();
        let expected = [
            Fault::Nan { probability: 0.001 },
            Fault::Stuck { probability: 1e-4, run: 50 },
            Fault::Saturate { level: 30.0 },
            Fault::Flip { probability: 1e-5 },
            Fault::Drop { probability: 1e-3 },
            Fault::Gap { probability: 1e-5, run: 200 },
        ];
        assert_eq!(plan.0, expected);
        assert_eq!(" ".parse(), Ok(FaultPlan::default()));
    }

    #[test]
    fn errors_say_where_what_and_what_instead() {
        for (text, place, column, found, problem) in [
            ("nan", 1, 0, "nan", Problem::Form),
            ("nan:0.1,", 2, 8, "", Problem::Form),
            ("nan:0.1, lost:1", 2, 9, "lost", Problem::Name),
            ("NaN:0.1", 1, 0, "NaN", Problem::Name),
            ("nan:2", 1, 4, "2", Problem::Probability),
            ("flip:-0.1", 1, 5, "-0.1", Problem::Probability),
            ("drop:NaN", 1, 5, "NaN", Problem::Probability),
            ("drop:0x1f", 1, 5, "0x1f", Problem::NoRun),
            ("ö,gap:0.1", 1, 0, "ö", Problem::Form),
            ("gap:0.1", 1, 4, "0.1", Problem::Run),
            ("gap:0.1x0", 1, 8, "0", Problem::Run),
            ("stuck:zx5", 1, 6, "z", Problem::Probability),
            ("stuck:0.5x1.5", 1, 10, "1.5", Problem::Run),
            ("saturate:inf", 1, 9, "inf", Problem::Level),
            ("saturate:0", 1, 9, "0", Problem::Level),
        ] {
            let error = text.parse::<FaultPlan>().unwrap_err();
            assert_eq!(error, PlanError { place, column, found: found.into(), problem }, "{text}");
        }
        let error = "nan:0.1,gap:0.1".parse::<FaultPlan>().unwrap_err().to_string();
        let expected = "faults: entry 2, character 13: found \"0.1\", expected PROBABILITYxSAMPLES with 1 to \
                        1000000000 samples, as in 1e-4x50";
        assert_eq!(error, expected);
    }
}
