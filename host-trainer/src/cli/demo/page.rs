//! Report of the demo: hidden effect, diagnosis and corrected model.

use super::DemoResult;
use super::job::{DIAGNOSIS, JobResult};
use crate::model::fit::report::Report;
use crate::report::diagnosis::parameter;
use crate::report::plot::DrawError;
use crate::report::plot::comparison::{self, Curve, Names};
use crate::report::plot::marks::Mark;
use crate::report::plot::style::{EARLY, LATE, MEASURED, PREDICTED};
use crate::report::plot::time_axis::TimeAxis;
use crate::report::signal::Comparison;
use crate::report::{Cell, Document, Section, Tone, model, monitor};
use crate::stats::format::significant;

/// Name of the hidden effect in pictures.
const HIDDEN: &str = "hidden effect";

/// Report of the demo.
pub(super) fn document(outcome: &DemoResult, found: &JobResult) -> Result<Document, DrawError> {
    let about = format!(
        "A simulated machine: {} recordings of {} s at {} Hz, seed {}. The diagnosis knows only the nominal rig of 5 degrees \
         of freedom; the hidden effect is compared with its result only in this report.",
        outcome.recordings, outcome.seconds, outcome.sample_rate_hz, outcome.seed
    );
    let sentences = [outcome.put_in(), outcome.raised(), outcome.named(), outcome.fell()];
    let view = found.before.model.view();
    let mark = outcome.truth.first_affected.map(|first| (first, HIDDEN));
    let mut document = Document::new("ballrace demo", about, tone(outcome), sentences.join(" "))
        .section(residual(outcome, found)?)
        .section(cause(outcome))
        .section(monitor::trend(&found.watched, &view.monitor, &TimeAxis::of(&found.input), mark)?);
    if let Some(comparison) = Comparison::from_input(&found.input, None) {
        document = document.section(comparison.spectra()?);
    }
    let report = &found.after.report;
    Ok(document.sections([
        model::equations(report),
        model::sizes(&outcome.sizes),
        scores(outcome, report),
        steps(outcome),
        monitor::events(&found.watched),
        model::training(report),
    ]))
}

fn tone(outcome: &DemoResult) -> Tone {
    let changed = outcome.truth.first_affected.is_some();
    let alarmed = outcome.first_alarm.is_some() == changed && !outcome.false_alarm;
    let fell = !changed || outcome.residual.after < outcome.residual.before;
    if alarmed && fell && outcome.rightly_named { Tone::Good } else { Tone::Bad }
}

/// Picture and table of the device's residual over the recordings.
fn residual(outcome: &DemoResult, found: &JobResult) -> Result<Section, DrawError> {
    let residuals = &found.residuals;
    let all = |values: &[f64]| values.iter().enumerate().map(|(n, v)| ((n + 1) as f64, *v)).collect::<Vec<_>>();
    let floor = found.judged.iter().zip(&residuals.floor).map(|(n, v)| ((n + 1) as f64, *v)).collect();
    let mut curves = vec![Curve { name: "model of the nominal rig", points: all(&residuals.before), color: EARLY }];
    if let Some(without) = &residuals.without_terms {
        curves.push(Curve { name: "corrected, without the new terms", points: all(without), color: PREDICTED });
    }
    curves.push(Curve { name: "corrected", points: all(&residuals.after), color: LATE });
    curves.push(Curve { name: "fitted to these recordings", points: floor, color: MEASURED });
    let marks: Vec<Mark> =
        outcome.truth.first_affected.iter().map(|n| Mark { at: *n as f64 + 0.5, name: HIDDEN.into() }).collect();
    let names = Names { x: "recording", y: "unexplained variance" };
    let svg = comparison::svg(&curves, 0.5..outcome.recordings as f64 + 0.5, names, &marks)?;
    let r = &outcome.residual;
    let row = |model: &str, value: f64| vec![Cell::text(model), Cell::number(significant(value, 3))];
    let mut rows = vec![row("of the nominal rig", r.before)];
    rows.extend(r.without_terms.map(|v| row("of the corrected rig, without the added terms", v)));
    rows.push(row("of the corrected rig: model.bin", r.after));
    rows.push(row("fitted to these recordings: attainable minimum", r.floor));
    let alarms = match outcome.alarms_after {
        0 => "no alarm".to_owned(),
        1 => "an alarm".to_owned(),
        n => format!("{n} alarms"),
    };
    let section = Section::new("The device's residual, before and after")
        .figure(
            svg,
            "Share of each recording's variance that the next-sample prediction by the device's own code does not explain. 0 is \
             a perfect prediction.",
        )
        .table(
            format!("Mean over the {} held-out recordings.", r.recordings),
            &["model", "unexplained variance"],
            rows,
        );
    let section = match outcome.terms() {
        Some(sentence) => section.paragraph(sentence),
        None => section,
    };
    Ok(section.paragraph(format!(
        "Over these recordings the monitor raises {alarms} with the corrected model, whose healthy level is that of the corrected \
         rig's simulation."
    )))
}

/// Diagnosed causes next to the hidden effect.
fn cause(outcome: &DemoResult) -> Section {
    let truth = |name: &str| match (outcome.truth.first_affected, name) {
        (Some(_), "frequency_hz") => significant(outcome.truth.frequency_hz, 5),
        (Some(_), "damping_ratio") => significant(outcome.truth.damping_ratio, 3),
        _ => "–".to_owned(),
    };
    let mut section = Section::new("Diagnosed cause");
    for cause in &outcome.causes {
        let rows = cause.parameters.iter().map(|(name, value)| {
            let mut row = parameter(cause, name, value);
            row.push(Cell::number(truth(name)));
            row
        });
        section = section
            .table(cause.name.clone(), &["parameter", "found", "95 % interval", "unit", "true"], rows.collect())
            .equations([cause.equation.clone()].into())
            .paragraph(cause.evidence.clone());
    }
    for entered in &outcome.entered {
        section = section.paragraph(format!("Library, {}.", entered.line()));
    }
    if outcome.causes.is_empty() {
        section = section.paragraph(outcome.named());
    }
    let numbers: Vec<String> = outcome.diagnosed.iter().map(|n| (n + 1).to_string()).collect();
    section
        .paragraph(format!("Recordings {} were diagnosed.", numbers.join(", ")))
        .link(format!("{DIAGNOSIS}/report.html"), "Report of the diagnosis, with all rejected causes.")
}

fn scores(outcome: &DemoResult, report: &Report) -> Section {
    let section = model::scores(report).paragraph(format!("Verdict on the fit: {}.", outcome.verdict.words));
    if outcome.verdict.beyond_null {
        return section;
    }
    section.paragraph(
        "So the model has learnt no more than the spectrum, as expected of a machine driven by noise. It still serves as a \
         reference: the device evaluates how far the residual departs from that expected of the rig.",
    )
}

fn steps(outcome: &DemoResult) -> Section {
    let row = |file: &str, what: &str| vec![Cell::text(file), Cell::text(what)];
    let rows = vec![
        row(
            "recordings/, rig.toml",
            "recordings with recordings.toml, and the nominal rig: the input of the diagnosis",
        ),
        row("before.json, before.bin", "model of the nominal rig"),
        row("events.jsonl", "events of the device with that model, over all recordings"),
        row("diagnosis/", "diagnosis.json, rig.corrected.toml, report.html, heldout/"),
        row("model.json", "model of the corrected rig with its scores and equations"),
        row("model.bin, model.h, model.rs", "that model for the device: binary for use in place from flash, C, Rust"),
    ];
    let states = |n: usize| format!("{n} states");
    let dimension = outcome.scores.in_sample.derivatives.len();
    Section::new("Steps")
        .paragraph(format!(
            "The nominal rig was simulated at the speeds and loads of all recordings (predict), a model was fitted to the \
             simulation (fit), exported and run by the device's own code over the recordings (export, monitor). Some recordings \
             from the alarm on were diagnosed (diagnose). The corrected rig was simulated in the same way, a model of {} with \
             the cause's terms in its library was fitted (fit --diagnosis), exported, and run over the held-out recordings.",
            states(dimension)
        ))
        .table("Files of this folder", &[], rows)
}
