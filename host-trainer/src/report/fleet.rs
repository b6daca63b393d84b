//! Page of `ballrace fleet`.

use super::settings::ReportSettings;
use super::{Cell, Document, Section, Tone};
use crate::fleet::machines::{Machine, Verdict};
use crate::fleet::store::Counts;
use crate::report::plot::{DrawError, fleet_trend};
use crate::stats::format::significant;

const SETTINGS: ReportSettings = ReportSettings::DEFAULT;

/// Page of all machines, worst first, with pictures of the first of them.
///
/// # Errors
/// Errors of the drawing library.
pub fn document(machines: &[Machine], counts: &Counts) -> Result<Document, DrawError> {
    let (tone, verdict) = verdict(machines);
    let about = format!("{} machines, {} messages", machines.len(), counts.accepted);
    let mut document = Document::new("The fleet, worst first", about, tone, verdict).section(table(machines));
    for machine in machines.iter().take(SETTINGS.fleet_pictures) {
        document = document.section(section(machine)?);
    }
    if machines.len() > SETTINGS.fleet_pictures {
        let text = format!("Trends of the first {} machines only.", SETTINGS.fleet_pictures);
        document = document.section(Section::new("Further machines").paragraph(text));
    }
    Ok(document.section(messages(counts)))
}

fn verdict(machines: &[Machine]) -> (Tone, String) {
    let count = |status: &str| machines.iter().filter(|m| m.status == status).count();
    let (anomalous, blind) = (count("anomalous"), count("blind"));
    match machines.first() {
        None => (Tone::Open, "No machine has been heard.".into()),
        Some(worst) if anomalous + blind > 0 => {
            let text = format!(
                "{anomalous} of {} machines anomalous, {blind} blind. First: {}, {}.",
                machines.len(),
                worst.machine,
                worst.look_at
            );
            (Tone::Bad, text)
        }
        Some(_) => (Tone::Good, format!("None of {} machines is anomalous or blind.", machines.len())),
    }
}

fn table(machines: &[Machine]) -> Section {
    let rows = machines.iter().map(|m| {
        vec![
            Cell::text(&m.machine),
            Cell::text(&m.status),
            Cell::number(significant(m.share_of_limit, 3)),
            Cell::text(&m.look_at),
            Cell::number(m.slope_per_100_blocks.map_or("–".into(), signed)),
            Cell::number(m.alarms),
            Cell::text(m.diagnosis.as_ref().map_or("–".into(), diagnosis)),
            // No break within a time.
            Cell::text(m.last_heard.replace('-', "\u{2011}").replace(' ', "\u{a0}")),
        ]
    });
    let head = ["machine", "status", "EWMA / limit", "look at", "trend", "alarms", "last verdict", "last heard, UTC"];
    let caption = "EWMA / limit: magnitude of the monitor's statistic over its limit. Trend: its change in 100 blocks, in limits.";
    Section::new("All machines").table(caption, &head, rows.collect())
}

fn signed(value: f64) -> String {
    let text = significant(value, 2);
    if value > 0.0 { format!("+{text}") } else { text }
}

fn diagnosis(diagnosis: &Verdict) -> String {
    let Verdict { verdict, cause, probability } = diagnosis;
    match (cause, probability) {
        (Some(cause), Some(probability)) => format!("{verdict}: {cause}, probability {probability:.2}"),
        (Some(cause), None) => format!("{verdict}: {cause}"),
        _ => verdict.clone(),
    }
}

fn section(machine: &Machine) -> Result<Section, DrawError> {
    let m = machine;
    let heading = format!("{}: {}", m.machine, m.status);
    let verdict = m.diagnosis.as_ref().map_or(String::new(), |d| format!(" Last verdict: {}.", diagnosis(d)));
    let lost = if m.lost > 0 { format!(" {} messages are missing.", m.lost) } else { String::new() };
    let text = format!(
        "Look at: {}.{verdict} Blocks {}, alarms {}, runs of broken samples {}; model {}; last heard {} UTC.{lost}",
        m.look_at, m.blocks, m.alarms, m.faults, m.model, m.last_heard
    );
    let section = Section::new(heading).paragraph(text);
    if m.trend.is_empty() {
        return Ok(section.paragraph("No block yet."));
    }
    let caption = format!(
        "Deviation of each of the last {} blocks and the EWMA, in healthy standard deviations of the logarithm of the level. \
         Dashed, the limit ±{}.",
        m.trend.len(),
        significant(m.ewma_limit, 3)
    );
    Ok(section.figure(fleet_trend::svg(&m.trend, m.ewma_limit)?, caption))
}

fn messages(counts: &Counts) -> Section {
    let row = |name: &str, count: u64| vec![Cell::text(name), Cell::number(count)];
    let rows = vec![
        row("stored", counts.accepted),
        row("dropped: duplicates", counts.duplicates),
        row("dropped: too long", counts.too_long),
        row("dropped: malformed", counts.malformed),
        row("dropped: unknown machine", counts.unknown_machine),
    ];
    Section::new("Messages").table("", &[], rows)
}
