//! What `ballrace diagnose` says of real recordings, beside what their source says: README.md's table, row for row.
//!
//! `cargo bench -p ballrace --bench real_recordings [-- cwru | mfpt | femto | emps]`. The recordings are those of
//! `$BALLRACE_DATA`, else of `../shared/data` beside the workspace; a set that is not there is skipped and said to be.
//!
//! The rigs beside this file state what the sources state of the machines; the rest of them is guessed and says so. Nothing
//! is asserted, neither what is found nor in what time: the seconds are those of reading and diagnosing on whatever
//! machine this runs on.

mod cases;

use std::{fs, path::Path, time::Instant};

use ballrace::{
    diagnose::{
        Task, diagnose,
        result::{Cause, DiagnosisResult, Fit, Parameter, Verdict},
    },
    recording::{Recording, load_all, manifest},
    rig::Rig,
    stats::format::significant,
};

use cases::Case;

/// The command's default.
const SEED: u64 = 0;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Result<()> {
    let chosen: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let cases = cases::all(|set| chosen.is_empty() || chosen.iter().any(|c| c == set))?;
    if cases.is_empty() {
        return Ok(());
    }
    println!("| recordings | says | the source says | held out, before → after | seconds |");
    println!("|---|---|---|---|---|");
    let mut metrics = Vec::new();
    for case in &cases {
        let start = Instant::now();
        let outcome = run(case)?;
        let seconds = start.elapsed().as_secs_f64();
        let (said, gain) = (said(&outcome), gain(&outcome.diagnosis.fit, &mut metrics));
        println!("| {} | {said} | {} | {gain} | {seconds:.1} |", case.name, case.source_says);
    }
    for (index, metric) in metrics.iter().enumerate() {
        println!("\n[{}] {metric}", index + 1);
    }
    Ok(())
}

/// A diagnosis of recordings as their manifests have them.
fn run(case: &Case) -> Result<DiagnosisResult> {
    let rig = Rig::parse(case.rig, Path::new("the bench's rig"))?;
    let folder = tempfile::tempdir()?;
    let read = |name: &str, text: &str| -> Result<Vec<Recording>> {
        let folder = folder.path().join(name);
        fs::create_dir(&folder)?;
        fs::write(folder.join(manifest::FILE_NAME), text)?;
        Ok(load_all(&folder)?)
    };
    let recordings = read("recordings", &case.recordings)?;
    let baseline = case.baseline.as_deref().map(|text| read("baseline", text)).transpose()?;
    let progress = |what: &str| eprintln!("{}: {what}", case.name);
    let task = Task { rig: &rig, baseline: baseline.as_deref(), recordings: &recordings, seed: SEED };
    Ok(diagnose(&task, &progress)?)
}

/// The causes with their parameters, or the verdict where there are none.
fn said(outcome: &DiagnosisResult) -> String {
    let diagnosis = &outcome.diagnosis;
    match diagnosis.verdict {
        Verdict::Mismatch => diagnosis.causes.iter().map(cause).collect::<Vec<_>>().join("; "),
        other => other.name().into(),
    }
}

fn cause(cause: &Cause) -> String {
    let mut out = cause.name.clone();
    for (key, value) in &cause.parameters {
        let (value, digits) = match value {
            Parameter::Number(value) => (significant(*value, 4), 3),
            Parameter::Name(name) => (name.clone(), 0),
        };
        out += &format!(", {key} {value}");
        if let Some([low, high]) = cause.interval95.get(key) {
            out += &format!(" ({} to {})", significant(*low, digits), significant(*high, digits));
        }
    }
    out
}

/// The error on what took no part, with the number of its metric.
fn gain(fit: &Fit, metrics: &mut Vec<String>) -> String {
    // Nothing was corrected.
    if fit.before == fit.after {
        return "–".into();
    }
    let index = metrics.iter().position(|m| *m == fit.metric).unwrap_or_else(|| {
        metrics.push(fit.metric.clone());
        metrics.len() - 1
    });
    format!("{} → {} [{}]", significant(fit.before, 3), significant(fit.after, 3), index + 1)
}
