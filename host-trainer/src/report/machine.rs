//! Sections of a diagnosis of a machine of unknown structure.

use super::Section;
use super::plot::DrawError;
use super::plot::comparison::{self, Curve, Names};
use super::plot::marks::Mark;
use super::plot::style::{EARLY, LATE, MEASURED, PREDICTED};
use crate::diagnose::Task;
use crate::diagnose::machine::is_unknown;
use crate::diagnose::result::{DiagnosisResult, HeldOut};
use crate::identify::likelihood::observed::{CHANNELS, accelerations};
use crate::recording::Recording;
use crate::rig::Rig;
use crate::signal::envelope::squared_envelope_spectrum;
use crate::stats::format::significant;

/// Sentence of a verdict without mismatch; `None` for a rig whose structure is known.
pub fn quiet(rig: &Rig, before: f64) -> Option<String> {
    let sentence = || {
        format!(
            "No mismatch: no line of the bearing or the shaft stands out, and the held-out recordings differ from what was \
             predicted by no more than healthy machines of one make do ({} dB).",
            significant(before, 3)
        )
    };
    is_unknown(rig).then(sentence)
}

/// Spectra of the squared envelope in the band that convinces, with the bearing's lines: measured, healthy, and synthesised.
///
/// # Errors
/// Errors of the drawing library.
pub fn envelopes(task: &Task, outcome: &DiagnosisResult) -> Result<Option<Section>, DrawError> {
    let location = &outcome.diagnosis.location;
    let ([band], [_, ..]) = (location.frequency_hz.as_slice(), location.order.as_slice()) else { return Ok(None) };
    let is_shown = |held: &&HeldOut| held.name.ends_with(&location.channel);
    let Some(held) = outcome.held_out.iter().find(is_shown).filter(|_| is_unknown(task.rig)) else { return Ok(None) };
    let recording = task.recordings.iter().find(|r| held.name == HeldOut::name_of(&r.name(), &location.channel));
    let Some(shaft_hz) = recording.and_then(|r| r.shaft_hz) else { return Ok(None) };
    let until = 1.15 * shaft_hz * location.order.iter().copied().fold(1.0, f64::max);
    let healthy = healthy(task, shaft_hz, &location.channel, held.sample_rate_hz);
    let signals = [
        ("healthy", healthy, LATE),
        ("measured", Some(held.measured.as_slice()), MEASURED),
        ("with the cause", Some(held.after.as_slice()), EARLY),
        ("without the cause", Some(held.before.as_slice()).filter(|_| healthy.is_none()), PREDICTED),
    ];
    let curve = |(name, samples, color): (&'static str, Option<&[f64]>, _)| {
        let spectrum = squared_envelope_spectrum(&[samples?], held.sample_rate_hz, &(band[0]..band[1]))?;
        let points = spectrum.points().skip(2).map(|(f, v)| (f, 20.0 * v.max(1e-12).log10())).collect();
        Some(Curve { name, points, color })
    };
    let curves: Vec<Curve<'_>> = signals.into_iter().filter_map(curve).collect();
    let mark = |order: &f64| Mark { at: order * shaft_hz, name: significant(*order, 3) };
    let marks: Vec<Mark> = location.order.iter().map(mark).collect();
    let names = Names { x: "frequency of the modulation, Hz", y: "dB re 1 (m/s²)²" };
    let svg = comparison::svg(&curves, 0.0..until, names, &marks)?;
    let caption = format!(
        "{}: squared envelope of {:.0} to {:.0} Hz; dashed, the lines of the cause at their orders of the shaft.",
        held.name, band[0], band[1]
    );
    Ok(Some(Section::new("The band that convinces").figure(svg, caption)))
}

/// Channel of the healthy recording of the nearest speed.
fn healthy<'t>(task: &Task<'t>, shaft_hz: f64, channel: &str, sample_rate_hz: f64) -> Option<&'t [f64]> {
    let away = |r: &Recording| r.shaft_hz.map_or(f64::INFINITY, |hz| (hz / shaft_hz).ln().abs());
    let nearest = task.baseline?.iter().min_by(|a, b| away(a).total_cmp(&away(b)))?;
    let comparable = away(nearest) < 0.05 && (nearest.sample_rate_hz / sample_rate_hz - 1.0).abs() < 1e-6;
    let index = CHANNELS.iter().position(|name| *name == channel).filter(|_| comparable)?;
    accelerations(nearest)[index].map(|c| c.samples.as_slice())
}
