//! Report of `ballrace monitor`.

use serde_json::{Value, json};

use super::settings::ReportSettings;
use super::signal::Comparison;
use super::{Cell, Document, Section, Tone, model};
use crate::model::OwnedModel;
use crate::model::export;
use crate::model::replay::Replayed;
use crate::recording::input::{Input, Series};
use crate::report::plot::time_axis::TimeAxis;
use crate::report::plot::{self, DrawError, trend};
use crate::signal::indicators::{Indicators, IsoClass};
use crate::stats::format::significant;
use ballrace_core::monitor::{MonitorConfig, Status};

const SETTINGS: ReportSettings = ReportSettings::DEFAULT;

/// Vibration indicators of the recordings, and the class of the machine as its user states it.
#[derive(Clone, Copy, Debug)]
pub struct Vibration<'i> {
    /// Indicators, one a recording.
    pub indicators: &'i [Indicators],
    /// Group and support of the machine.
    pub class: Option<IsoClass>,
}

impl Vibration<'_> {
    /// Indicators of a recording as an event, with the monitor's EWMA at its end.
    pub fn event(&self, input: &Input, index: usize, ewma: Option<f32>) -> Value {
        let found = &self.indicators[index];
        let velocity = found.velocity.ok();
        json!({
            "event": "recording",
            "recording": input.series[index].name,
            "recording_index": index,
            "start_s": input.starts_s.as_ref().map(|starts| starts[index]),
            "rms_m_per_s2": found.rms,
            "peak_m_per_s2": found.peak,
            "crest_factor": found.crest_factor(),
            "kurtosis": found.kurtosis,
            "velocity_mm_per_s": velocity,
            "no_velocity": found.velocity.err().map(|why| why.to_string()),
            "zone": self.class.zip(velocity).map(|(class, velocity)| class.zone(velocity)),
            "ewma": ewma,
        })
    }
}

/// Report of a run of the device over recordings.
///
/// # Errors
/// Errors of the drawing library.
pub fn document(
    device: &OwnedModel,
    input: &Input,
    replayed: &Replayed,
    vibration: &Vibration<'_>,
) -> Result<Document, DrawError> {
    let view = device.view();
    let (tone, verdict) = verdict(replayed);
    let about = format!("{} recordings, channel {}, {} Hz", input.series.len(), input.channel, input.sample_rate_hz);
    let mut document = Document::new("The device over the recordings", about, tone, verdict)
        .section(trend(replayed, &view.monitor, &TimeAxis::of(input), None)?)
        .section(indicators(input, vibration)?)
        .section(events(replayed));
    if let Some(comparison) = Comparison::from_input(input, None) {
        document = document.section(comparison.spectra()?).section(comparison.prediction(&view)?);
    }
    Ok(document.section(totals(replayed, input)).section(model::sizes(&export::sizes(&view))))
}

/// Tone and sentence of the device's result.
pub fn verdict(replayed: &Replayed) -> (Tone, String) {
    let s = &replayed.summary;
    let blind = match (s.status, s.faults.total()) {
        (Status::Blind, _) => " The status at the end is blind: too many samples were invalid.",
        (_, 0) => "",
        _ => " Some samples were invalid: see the totals.",
    };
    match &s.first_alarm {
        Some(alarm) => {
            let often = if s.alarms == 1 { String::new() } else { format!(", {} alarms in all", s.alarms) };
            let place = alarm.recording_index + 1;
            let text = format!("Alarm in {}, recording {place} of {}{often}.{blind}", alarm.recording, s.recordings);
            (Tone::Bad, text)
        }
        None if s.status == Status::Blind => (Tone::Open, format!("No alarm.{blind}")),
        None => (Tone::Good, format!("No alarm in {} recordings.{blind}", s.recordings)),
    }
}

/// Section on the statistics over the recordings; `mark` labels the start of one recording.
///
/// # Errors
/// Errors of the drawing library.
pub fn trend(
    replayed: &Replayed,
    limits: &MonitorConfig,
    time: &TimeAxis,
    mark: Option<(usize, &str)>,
) -> Result<Section, DrawError> {
    let svg = trend::svg(&replayed.blocks, limits, time, mark)?;
    Ok(Section::new("The residual over time").figure(
        svg,
        format!(
            "Deviation of the logarithm of the residual's level from the healthy machine's, in healthy standard deviations, block by \
             block ({} samples each), and the EWMA of its running median of three. Dashed, the limit of the EWMA to either side, \
             ±{:.1}{}.",
            limits.block,
            limits.limit,
            match limits.false_alarms_per_day {
                rate if rate > 0.0 => format!(
                    ", for {rate} false alarms a day of {:.0} blocks, from {} healthy blocks",
                    limits.blocks_per_day, limits.healthy_blocks
                ),
                _ => String::new(),
            }
        ),
    ))
}

/// Section on the vibration indicators over the recordings.
fn indicators(input: &Input, vibration: &Vibration<'_>) -> Result<Section, DrawError> {
    let all = vibration.indicators;
    let svg = plot::indicators::svg(all, &TimeAxis::of(input), vibration.class)?;
    let (first, last) = (input.series.first(), input.series.last());
    let name = |series: Option<&Series>| series.map_or(String::new(), |s| s.name.clone());
    let row = |what: &str, pick: &dyn Fn(&Indicators) -> f64| {
        let values: Vec<f64> = all.iter().map(pick).collect();
        let finite = || values.iter().enumerate().filter(|(_, v)| v.is_finite());
        let (place, largest) = finite().max_by(|a, b| a.1.total_cmp(b.1))?;
        let number = |v: Option<&f64>| Cell::number(v.map_or("–".into(), |v| significant(*v, 3)));
        let at = name(input.series.get(place));
        Some(vec![
            Cell::text(what),
            number(values.first()),
            number(values.last()),
            number(Some(largest)),
            Cell::text(at),
        ])
    };
    let rows = [
        row("RMS, m/s²", &|i| i.rms),
        row("peak, m/s²", &|i| i.peak),
        row("crest factor", &Indicators::crest_factor),
        row("kurtosis", &|i| i.kurtosis),
        row("velocity 10 Hz to 1 kHz, mm/s RMS", &|i| i.velocity.unwrap_or(f64::NAN)),
    ];
    let head = ["", "first", "last", "largest", "in"];
    Ok(Section::new("Vibration indicators")
        .figure(
            svg,
            format!(
                "Of each recording about its mean, {} to {}: RMS and peak of the acceleration, crest factor (peak over RMS) and \
                 kurtosis (3 for normal noise).",
                name(first),
                name(last)
            ),
        )
        .table("", &head, rows.into_iter().flatten().collect())
        .paragraph(severity(vibration)))
}

/// Vibration velocity of the last recording and its zone in sentences, or why there is none.
pub fn severity(vibration: &Vibration<'_>) -> String {
    match (vibration.indicators.last().map(|i| i.velocity), vibration.class) {
        (Some(Ok(velocity)), Some(class)) => {
            let zone = class.zone(velocity);
            let [ab, bc, cd] = class.boundaries_mm_per_s();
            format!(
                "The last recording has {velocity:.2} mm/s RMS from 10 Hz to 1 kHz: zone {zone:?} of ISO 20816-3 for {class}, \
                 {} (boundaries A/B {ab}, B/C {bc}, C/D {cd} mm/s).",
                zone.text()
            )
        }
        (Some(Ok(velocity)), None) => format!(
            "The last recording has {velocity:.2} mm/s RMS from 10 Hz to 1 kHz. Zones of ISO 20816-3 need the machine's group \
             and support: --iso-class."
        ),
        (Some(Err(why)), _) => format!("The last recording has no velocity from 10 Hz to 1 kHz: {why}."),
        (None, _) => String::new(),
    }
}

/// Table of the device's events.
pub fn events(replayed: &Replayed) -> Section {
    let text = |event: &Value, key: &str| event.get(key).and_then(Value::as_str).unwrap_or("").to_owned();
    let number = |event: &Value, key: &str, digits: usize| {
        Cell::number(event.get(key).and_then(Value::as_f64).map_or(String::new(), |v| format!("{v:.digits$}")))
    };
    let listed: Vec<&Value> = replayed.events.iter().filter(|e| text(e, "event") != "summary").collect();
    let rows = listed.iter().take(SETTINGS.events).map(|event| {
        let kind = text(event, "kind");
        let name = if kind.is_empty() { text(event, "event") } else { format!("fault: {kind}") };
        vec![
            Cell::text(name),
            Cell::text(text(event, "recording")),
            number(event, "time_s", 4),
            number(event, "deviation", 2),
            number(event, "ewma", 2),
        ]
    });
    let head = ["event", "recording", "time, s", "deviation", "EWMA"];
    let section = Section::new("Events").table("", &head, rows.collect());
    match listed.len().saturating_sub(SETTINGS.events) {
        0 => section,
        more => section.paragraph(format!("… and {more} more.")),
    }
}

fn totals(replayed: &Replayed, input: &Input) -> Section {
    let s = &replayed.summary;
    let row = |name: &str, value: String| vec![Cell::text(name), Cell::number(value)];
    let mut rows = vec![
        row("recordings", s.recordings.to_string()),
        row("samples", s.samples.to_string()),
        row("length", format!("{:.1} s", s.samples as f64 / input.sample_rate_hz)),
        row("evaluated", s.evaluated.to_string()),
        row("blocks", s.blocks.to_string()),
        row("alarms", s.alarms.to_string()),
    ];
    let f = &s.faults;
    let broken = [("non-finite", f.non_finite), ("saturated", f.saturated), ("stuck", f.stuck), ("missing", f.missing)];
    rows.extend(broken.map(|(name, count)| row(&format!("invalid samples, {name}"), count.to_string())));
    Section::new("Totals").table("", &[], rows)
}
