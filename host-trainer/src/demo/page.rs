//! The demo's report: what was put in, what was found, and why.

use super::{Found, Outcome};
use crate::fit::report::Report;
use crate::plot::DrawError;
use crate::report::signal::Comparison;
use crate::report::{Cell, Document, Section, Tone, model, monitor};

/// The report.
pub(super) fn document(outcome: &Outcome, found: &Found) -> Result<Document, DrawError> {
    let (view, report) = (found.fitted.model.view(), &found.fitted.report);
    let about = format!(
        "A simulated machine: {} recordings of {} s at {} Hz, seed {}; the model knows the first {} as healthy.",
        outcome.recordings, outcome.seconds, outcome.sample_rate_hz, outcome.seed, outcome.healthy
    );
    let (tone, verdict) = verdict(outcome);
    let mark = outcome.truth.first_affected.map(|first| (first, "fault put in"));
    let mut document = Document::new("ballrace demo", about, tone, verdict)
        .section(story(outcome))
        .section(monitor::trend(&found.watched, &view.monitor, mark)?);
    if let Some(comparison) = Comparison::of(&found.input, Some(outcome.machine.ball_pass_hz)) {
        document = document.section(comparison.spectra()?).section(comparison.prediction(&view)?);
    }
    Ok(document.sections([
        scores(outcome, report),
        model::equations(report),
        model::sizes(&outcome.sizes),
        monitor::events(&found.watched),
        model::training(report),
    ]))
}

fn scores(outcome: &Outcome, report: &Report) -> Section {
    let section = model::scores(report).paragraph(format!("Verdict on the fit: {}.", outcome.verdict.words));
    if outcome.verdict.beyond_null {
        return section;
    }
    section.paragraph(
        "So the healthy machine's spectrum is all that the model has learnt of it. Its model still serves as a yardstick: what the device judges is how much the residual differs from the \
         healthy machine's.",
    )
}

fn verdict(outcome: &Outcome) -> (Tone, String) {
    let tone = match (&outcome.first_alarm, outcome.truth.first_affected) {
        (Some(_), Some(_)) if !outcome.false_alarm => Tone::Good,
        (None, None) => Tone::Good,
        _ => Tone::Bad,
    };
    (tone, format!("{} {}", outcome.put_in(), outcome.raised()))
}

fn story(outcome: &Outcome) -> Section {
    let row = |file: &str, what: &str| vec![Cell::text(file), Cell::text(what)];
    let rows = vec![
        row("recordings/", "the recordings, with recordings.toml"),
        row("model.json", "the fitted model with its scores and equations"),
        row("model.bin, model.h, model.rs", "the same for the device: in place from flash, as C, as Rust"),
        row("events.jsonl", "what the device's own code told of, over all recordings"),
    ];
    Section::new("What was done")
        .paragraph(format!(
            "Recordings were made with the 5-degree-of-freedom rig: a bearing that turns at {} Hz, its housing, and a resonator \
             that carries the sensor; and, from some recording on, a growing pit in its outer race, which {:.1} balls pass a \
             second. A model was fitted to the \
             first {} recordings and exported; then the device's own code ran over all of them. Neither the fit nor the device \
             was told that there is a fault, or where it starts.",
            outcome.machine.shaft_hz, outcome.machine.ball_pass_hz, outcome.healthy
        ))
        .table("Beside this report", &[], rows)
}
