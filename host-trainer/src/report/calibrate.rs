//! Report of `ballrace calibrate` for a bearing rig.

use super::settings::ReportSettings;
use super::{Cell, Document, Section, Tone};
use crate::identify::calibrate::bearing::{Calibration, prediction};
use crate::identify::likelihood::observed::{CHANNELS, accelerations};
use crate::recording::{Channel, Recording};
use crate::report::plot::DrawError;
use crate::report::plot::comparison::{self, Curve, Names};
use crate::report::plot::marks::Mark;
use crate::report::plot::style::{EARLY, LATE, MEASURED};
use crate::rig::Rig;
use crate::signal::spectrum::welch;
use crate::stats::format::share;
use crate::stats::units::NamedUnit;

const SETTINGS: ReportSettings = ReportSettings::DEFAULT;

/// Error of drawing the report of a calibration.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// Error of the drawing library.
    #[error(transparent)]
    Draw(#[from] DrawError),
    /// Error of the rig or its simulation.
    #[error(transparent)]
    Calibrate(#[from] crate::identify::calibrate::CalibrateError),
}

/// Report of a calibration; its pictures show the last recording.
///
/// # Errors
/// Errors of the drawing library or of the simulation.
pub fn document(
    before: &Rig,
    done: &Calibration,
    recordings: &[Recording],
    seed: u64,
) -> Result<Document, ReportError> {
    let about = format!("{} recordings; held out: {}", recordings.len(), done.held_out_recordings);
    let (tone, verdict) = verdict(done);
    let mut document = Document::new("A rig calibrated to a healthy machine", about, tone, verdict);
    if let Some(last) = recordings.last() {
        document = document.section(pictures(before, &done.rig, last, seed)?);
    }
    Ok(document.section(held_out(done)).section(parameters(done)))
}

fn verdict(done: &Calibration) -> (Tone, String) {
    let mean = |of: fn(&crate::identify::calibrate::bearing::HeldOut) -> f64| {
        done.held_out.iter().map(of).sum::<f64>() / done.held_out.len().max(1) as f64
    };
    let (before, after, floor) = (mean(|h| h.before_db), mean(|h| h.after_db), mean(|h| h.floor_db));
    let what = if done.path_poles.is_empty() { "the calibrated rig" } else { "the rig with its transfer path" };
    let tone = if after < before { Tone::Good } else { Tone::Open };
    let text = format!(
        "On held-out recordings the log-spectral distance of {what} to the measurement is {after:.1} dB; before it was \
         {before:.1} dB, and two runs of the same rig are {floor:.1} dB apart."
    );
    (tone, text)
}

fn pictures(before: &Rig, after: &Rig, recording: &Recording, seed: u64) -> Result<Section, ReportError> {
    let mut section = Section::new(format!("{}, measured and simulated", recording.name()));
    let (old, new) = (prediction(before, recording, seed)?, prediction(after, recording, seed)?);
    let rate = recording.sample_rate_hz;
    let marks = marks(after, recording);
    let pass_hz = marks.first().map_or(rate / 20.0, |mark| mark.at);
    for (channel, measured) in accelerations(recording).into_iter().enumerate() {
        let Some(measured) = measured else { continue };
        let of = |r: &Recording| r.channel(CHANNELS[channel]).cloned().unwrap_or_default();
        let signals = [
            ("measured", measured.clone(), MEASURED),
            ("rig before", of(&old), LATE),
            ("rig calibrated", of(&new), EARLY),
        ];
        let narrow_segment = (recording.len() / 2).clamp(8, 16 * SETTINGS.segment);
        let (broad, narrow) =
            (spectra(&signals, rate, SETTINGS.segment.min(recording.len())), spectra(&signals, rate, narrow_segment));
        let names = Names { x: "frequency, Hz", y: "density, dB re 1 (m/s²)²/Hz" };
        section = section
            .figure(
                comparison::svg(&broad, 0.0..0.5 * rate, names, &[])?,
                format!("{}: power spectral density.", measured.name),
            )
            .figure(
                comparison::svg(&narrow, 0.0..(SETTINGS.ball_pass_harmonics + 0.5) * pass_hz, names, &marks)?,
                format!("{}: low frequencies at finer resolution; harmonics of the BPFO are marked.", measured.name),
            );
        if after.paths.is_empty() {
            let until = SETTINGS.turns / recording.shaft_hz.unwrap_or(1.0).max(1e-3);
            let over_time = |(name, channel, color): &(&'static str, Channel, _)| Curve {
                name,
                points: channel.samples.iter().enumerate().map(|(i, v)| (i as f64 / rate, *v)).collect(),
                color: *color,
            };
            let shown: Vec<Curve<'_>> = [&signals[0], &signals[2]].into_iter().map(over_time).collect();
            let names = Names { x: "time, s", y: "acceleration, m/s²" };
            section = section.figure(
                comparison::svg(&shown, 0.0..until, names, &[])?,
                format!(
                    "{}: the first {:.0} shaft revolutions; the initial angles are fitted, the noise is not.",
                    measured.name, SETTINGS.turns
                ),
            );
        }
    }
    Ok(section)
}

fn spectra(
    signals: &[(&'static str, Channel, plotters::style::RGBColor)],
    rate: f64,
    segment: usize,
) -> Vec<Curve<'static>> {
    let curve = |(name, channel, color): &(&'static str, Channel, _)| {
        let spectrum = welch(&[&channel.samples], rate, segment)?;
        // The mean was subtracted: its two bins hold nothing of the machine.
        let points = spectrum.points().skip(2).map(|(f, v)| (f, 10.0 * v.max(1e-30).log10())).collect();
        Some(Curve { name, points, color: *color })
    };
    signals.iter().filter_map(curve).collect()
}

fn marks(rig: &Rig, recording: &Recording) -> Vec<Mark> {
    let (Some(machine), Some(shaft_hz)) = (rig.bearing(), recording.shaft_hz) else { return Vec::new() };
    let pass = machine.bearing.geometry().orders().bpfo * shaft_hz;
    let name = |k: i32| if k == 1 { format!("BPFO {pass:.1} Hz") } else { format!("{k}×") };
    (1..=SETTINGS.ball_pass_harmonics as i32).map(|k| Mark { name: name(k), at: f64::from(k) * pass }).collect()
}

fn held_out(done: &Calibration) -> Section {
    let row = |h: &crate::identify::calibrate::bearing::HeldOut| {
        let numbers = [h.before_db, h.after_db, h.floor_db].map(|v| Cell::number(format!("{v:.2}")));
        [Cell::text(&h.recording), Cell::text(h.channel)].into_iter().chain(numbers).collect()
    };
    Section::new("Held-out recordings")
        .paragraph(
            "Log-spectral distance between measurement and simulation, mean over eight runs with independent noise; the \
             floor is the distance of two runs of the calibrated rig.",
        )
        .table("", &["recording", "channel", "before, dB", "calibrated, dB", "floor, dB"], done.held_out.iter().map(row).collect())
}

fn parameters(done: &Calibration) -> Section {
    let mut section = Section::new("Parameters");
    for (channel, poles) in &done.path_poles {
        section = section.paragraph(format!(
            "The rig alone does not fit {channel}: an all-pole transfer path of {poles} poles between rig and sensor was \
             identified, its order chosen on recordings that it was not fitted to. A signal through an unknown structure \
             does not determine the rig's own parameters; they are unchanged."
        ));
    }
    if !done.parameters.is_empty() {
        let row = |p: &crate::identify::calibrate::estimate::Estimate| {
            let [name, numbers @ ..] = NamedUnit::new(&p.key.to_string(), p.value).row(p.before, p.value, p.interval95);
            let note = Cell::text(if p.determined { "" } else { "not determined" });
            [Cell::text(name)].into_iter().chain(numbers.map(Cell::number)).chain([note]).collect()
        };
        let rows = done.parameters.iter().map(row).collect();
        section = section.table("", &["parameter", "before", "calibrated", "95 % interval", ""], rows);
    }
    for free in &done.undetermined {
        section = section.paragraph(format!("The recordings do not determine {}.", free.free));
    }
    for e in &done.explained {
        section = section.paragraph(format!(
            "{}: the deterministic part, fixed by the initial angles, is {} of the power; the power of the residual is \
             within {:.2} dB of that of process force and sensor noise (RMS over bands).",
            e.channel,
            share(e.deterministic),
            e.residual_db
        ));
    }
    section
}
