//! Diagnosis of the rig of one degree of freedom by its force balance ([`identify::force_balance`](crate::identify::force_balance)),
//! in the form that both kinds of rig share.

mod acquisition;
mod causes;
mod decide;
mod engine;
mod events;
mod finding;
mod flexible;
mod locate;
mod table;
mod terms;
mod text;

use std::collections::BTreeMap;

use super::faults;
use super::result::{
    Aspect, Cause, Diagnosis, DiagnosisResult, Fit, HeldOut, Left, Location, Parameter, Rejected, SCHEMA, Test, Verdict,
};
use super::{DiagnoseError, Task};
use crate::identify::force_balance::HeldOutTrace;
use crate::recording::Recording;
use crate::rig::EffectEntry;
use crate::stats::significance::false_discovery_rates;
use engine::diagnose_sdof;
use finding::{CauseParameter, Finding, FoundCause, ResidualTest, Where};
use terms::{SoughtBy, sought_by};

/// Explained share of the explainable error below which a caveat is given.
const MOST: f64 = 0.97;

/// Diagnoses a rig of one degree of freedom from at least one recording.
///
/// # Errors
/// As [`diagnose_sdof`].
pub fn diagnose(task: &Task, progress: &dyn Fn(&str)) -> Result<DiagnosisResult, DiagnoseError> {
    let Task { rig, baseline, recordings, seed } = *task;
    progress("selecting causes by the force balance");
    let finding = diagnose_sdof(rig, baseline, recordings, seed)?;
    Ok(outcome(baseline.is_some(), recordings, finding, seed))
}

fn outcome(told: bool, recordings: &[Recording], finding: Finding, seed: u64) -> DiagnosisResult {
    let channel = if recordings.iter().all(|r| r.channel("q").is_some()) { "q" } else { "qdd" };
    let mut held_out: Vec<HeldOut> = finding.traces.iter().map(|trace| held_out_of(trace, recordings)).collect();
    let entries = finding.causes.iter().map(|c| &c.entry);
    let lasting: Vec<&EffectEntry> = entries.filter(|entry| faults::lasts(entry)).collect();
    faults::put_back(&mut held_out, channel, recordings, &lasting);
    let fit = &finding.fit;
    // An acquisition fault alone does not affect the balance, from which it was removed.
    let shown = (lasting.len() == finding.causes.len() && !lasting.is_empty())
        .then(|| faults::fit(&held_out, finding.sensor_noise_std, seed))
        .flatten();
    let diagnosis = Diagnosis {
        schema: SCHEMA.into(),
        verdict: finding.verdict,
        causes: finding.causes.iter().map(cause).collect(),
        rejected: finding.rejected.iter().map(|r| Rejected { name: r.name.clone(), why: r.why.clone() }).collect(),
        location: match finding.verdict {
            // The residual is noise, and so is the location of its maximum.
            Verdict::NoMismatch => Location { channel: channel.into(), ..Location::default() },
            // An acquisition fault is not in the force residual.
            _ if shown.is_some() => faults::location(channel, &lasting),
            _ => location(&finding.location, recordings.len(), channel),
        },
        terms: Vec::new(),
        nuisance: Vec::new(),
        left: Left::default(),
        fit: shown.unwrap_or_else(|| Fit {
            metric: fit.metric.clone(),
            held_out: fit.held_out.clone(),
            before: fit.before,
            after: fit.after,
            noise_floor: fit.noise_floor,
            p_value: fit.p_value,
        }),
    };
    let caveats = caveats(told, &finding);
    let interval = |p: &CauseParameter| p.interval95.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    DiagnosisResult {
        diagnosis,
        held_out,
        tests: tests(finding.tests, channel),
        fitted: finding.own.iter().map(|p| (p.name.clone(), p.value, interval(p))).collect(),
        caveats,
        rig: finding.rig,
    }
}

fn tests(found: Vec<ResidualTest>, channel: &'static str) -> Vec<Test> {
    let p_values: Vec<f64> = found.iter().map(|t| t.p_value).collect();
    let rates = false_discovery_rates(&p_values).into_iter();
    let of = |(t, q_value): (ResidualTest, f64)| {
        let ResidualTest { what, z, p_value } = t;
        Test { aspect: Aspect::Force, channel, at: None, what, z, p_value, q_value }
    };
    found.into_iter().zip(rates).map(of).collect()
}

fn cause(found: &FoundCause) -> Cause {
    let mut parameters: BTreeMap<String, Parameter> =
        found.parameters.iter().map(|p| (p.name.clone(), Parameter::Number(p.value))).collect();
    for parameter in found.entry.definition().parameters.iter().filter(|p| p.in_vocabulary()) {
        if let Some(name) = found.entry.text(parameter.key) {
            parameters.insert(parameter.key.to_string(), Parameter::Name(name.into()));
        }
    }
    Cause {
        name: found.name.clone(),
        probability: found.probability,
        parameters,
        interval95: found.parameters.iter().filter_map(|p| Some((p.name.clone(), p.interval95?))).collect(),
        evidence: found.evidence.clone(),
        // With one coordinate only, "q = q" is left out.
        equation: found.equation.trim_end_matches(", q = q").to_owned(),
    }
}

fn location(found: &Where, recordings: usize, channel: &str) -> Location {
    // Adjoining stretches are one.
    let mut spans: Vec<(&str, [f64; 2])> = Vec::new();
    for (name, [from, to]) in &found.time_s {
        match spans.last_mut() {
            Some((last, span)) if last == name && (span[1] - from).abs() <= 0.01 * (to - from) => span[1] = *to,
            _ => spans.push((name, [*from, *to])),
        }
    }
    let mut state = found.state.clone();
    if recordings > 1 {
        // A time needs its recording.
        let places: Vec<String> =
            spans.iter().map(|(name, [from, to])| format!("{name} from {from:.2} to {to:.2} s")).collect();
        if !places.is_empty() {
            state = format!("{state}; largest in {}", places.join(", "));
        }
    }
    Location {
        time_s: spans.into_iter().map(|(_, span)| span).collect(),
        frequency_hz: vec![found.frequency_hz],
        state,
        channel: channel.into(),
        ..Location::default()
    }
}

fn held_out_of(trace: &HeldOutTrace, recordings: &[Recording]) -> HeldOut {
    HeldOut {
        name: trace.recording.clone(),
        // All have the same rate, or there would be no balance.
        sample_rate_hz: recordings[0].sample_rate_hz,
        measured: trace.measured.clone(),
        before: trace.before.clone(),
        after: trace.after.clone(),
    }
}

fn caveats(told: bool, finding: &Finding) -> Vec<String> {
    let mut out = Vec::new();
    // Acquisition faults do not affect the balance.
    let forces = finding.fit.after < finding.fit.before;
    if finding.verdict == Verdict::Mismatch && forces && finding.fit.explained_share < MOST {
        out.push(format!(
            "The causes explain {:.0} % of the residual that a flexible model explains; the rest is outside the vocabulary.",
            100.0 * finding.fit.explained_share
        ));
    }
    let unknown: Vec<&str> = finding.own.iter().map(|p| p.name.as_str()).collect();
    if !unknown.is_empty() && !told {
        out.push(format!(
            "Unknown, and so fitted to these recordings: {}. A change of these parameters would show only in comparison with \
             recordings of the healthy machine (--baseline).",
            unknown.join(", ")
        ));
    }
    for cause in finding.causes.iter().filter(|c| c.parameters.iter().all(|p| p.interval95.is_none())) {
        out.push(format!("{} was read from the samples, not fitted: its parameters have no intervals.", cause.name));
    }
    for cause in finding.causes.iter().filter(|c| sought_by(c.entry.kind) == Some(SoughtBy::Events)) {
        out.push(format!(
            "{} is a single event: it is not in the corrected rig, and the held-out errors exclude it.",
            cause.entry.kind
        ));
    }
    if finding.causes.iter().any(|c| c.name == "mains-interference") {
        out.push("The phase of the mains interference was fitted to each held-out recording itself.".into());
    }
    if finding.traces.is_empty() {
        out.push("The recordings are too short for a held-out part; the errors are cross-validated only.".into());
    } else {
        out.push(
            "Held-out curves are free simulations of the whole stretch, driven by the recorded input alone from the initial \
             state of the smallest residual: small errors of force add up in them."
                .into(),
        );
    }
    out
}
