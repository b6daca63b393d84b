//! Report of `ballrace phases`.

use super::{Cell, Document, Section, Tone};
use crate::report::plot::{DrawError, life};
use crate::signal::phases::life::Timeline;
use crate::signal::phases::machine::{Filter, Lives, Machine};
use crate::signal::phases::{Phases, Rules};

/// Report of the phases of machines.
///
/// # Errors
/// Errors of the drawing library.
pub fn document(machines: &[Machine], rules: &Rules) -> Result<Document, DrawError> {
    let names: Vec<&str> = machines.iter().map(|machine| machine.name.as_str()).collect();
    let verdict: Vec<String> = machines.iter().map(verdict).collect();
    let mut document = Document::new("Aging phases", names.join(", "), Tone::Open, verdict.join(" "));
    for machine in machines {
        document = document.section(section(machine, rules)?);
    }
    Ok(document)
}

/// Start of aging of each raw channel in a sentence.
pub fn verdict(machine: &Machine) -> String {
    let Machine { name, lives, phases } = machine;
    let raw = lives.channels.iter().zip(phases).filter(|(life, _)| life.filter == Filter::Raw);
    let each = raw.map(|(life, phases)| match phases.and_then(|phases| phases.aging) {
        Some(start) => format!("{} ages from {}", life.channel, place(&lives.timeline, start)),
        None => format!("{} shows no aging", life.channel),
    });
    format!("{name}: {}.", each.collect::<Vec<_>>().join(", "))
}

/// Name of a recording with its time.
pub fn place(timeline: &Timeline, index: usize) -> String {
    let name = &timeline.names[index];
    timeline.times_s.as_ref().map_or_else(|| name.clone(), |times| format!("{name} ({:.0} s)", times[index]))
}

/// Name of the signal of which features are taken.
pub fn filter_name(filter: Filter) -> &'static str {
    match filter {
        Filter::Raw => "raw",
        Filter::Wavelet => "denoised",
    }
}

/// Names of the columns of [`row`].
pub const HEAD: [&str; 7] =
    ["channel", "signal", "healthy kurtosis", "aging from", "in a row", "failure from", "recordings between"];

/// Phases of a channel as words.
pub fn row(lives: &Lives, index: usize, phases: &Phases) -> [String; 7] {
    let life = &lives.channels[index];
    let start = |index: Option<usize>| index.map_or("none".into(), |index| place(&lives.timeline, index));
    [
        life.channel.clone(),
        filter_name(life.filter).into(),
        format!("{:.2} ± {:.2}", phases.mean, phases.std),
        start(phases.aging),
        phases.aging.map_or(String::new(), |_| phases.in_a_row.to_string()),
        start(phases.failure),
        phases.between(life.features.len()).map_or(String::new(), |count| count.to_string()),
    ]
}

fn section(machine: &Machine, rules: &Rules) -> Result<Section, DrawError> {
    let lives = &machine.lives;
    let rows = machine.phases.iter().enumerate().filter_map(|(n, phases)| Some(row(lives, n, phases.as_ref()?)));
    let rows = rows.map(|row| row.into_iter().map(Cell::text).collect()).collect();
    pictures(Section::new(&machine.name).table("", &HEAD, rows), machine, rules)
}

/// Section with a picture of each channel of a machine.
///
/// # Errors
/// Errors of the drawing library.
pub fn pictures(mut section: Section, machine: &Machine, rules: &Rules) -> Result<Section, DrawError> {
    for (life, phases) in machine.lives.channels.iter().zip(&machine.phases) {
        let Some(phases) = phases else { continue };
        let Ok(svg) = life::svg(&life.features, phases, rules) else { continue };
        let caption = format!(
            "Channel {}, {}. Shaded, the {} healthy recordings; dashed, {} standard deviations of their kurtosis.",
            life.channel,
            filter_name(life.filter),
            phases.healthy,
            rules.sigmas
        );
        section = section.figure(svg, caption);
    }
    Ok(section)
}
