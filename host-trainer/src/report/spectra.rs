//! Report of `ballrace spectra`.

use serde_json::{Value, json};

use super::{Cell, Document, Section, Tone};
use crate::report::plot::lines::Labels;
use crate::report::plot::marks::Mark;
use crate::report::plot::{DrawError, cycle, density, kurtogram, lines};
use crate::signal::characteristic::{Characteristic, Family};
use crate::signal::kurtogram::Kurtogram;
use crate::signal::spectra::{Analysis, BandChoice, MarkedLine, SpeedSource};
use crate::stats::format::{by_chance, chance, fixed};

/// Report of the analyses of some recordings.
///
/// # Errors
/// Errors of the drawing library.
pub fn document(analyses: &[Analysis]) -> Result<Document, DrawError> {
    let about = match analyses {
        [one] => format!("{}, channel {}, {:.2} s at {} Hz", one.file, one.channel, one.duration_s, one.sample_rate_hz),
        many => format!("{} recordings", many.len()),
    };
    let verdict: Vec<String> = analyses.iter().map(verdict).collect();
    let mut document = Document::new("Spectra of the recording", about, Tone::Open, verdict.join(" "));
    for analysis in analyses {
        document = document.sections(sections(analysis, analyses.len() > 1)?);
    }
    Ok(document)
}

/// Strongest characteristic line in a sentence. No diagnosis: other explanations are not tested.
pub fn verdict(analysis: &Analysis) -> String {
    match analysis.strongest() {
        Some(found) => format!(
            "{}: strongest line in the envelope of {}: {} at {:.1} Hz, {:.0} dB above the background.",
            analysis.name,
            band(analysis),
            found.characteristic.name,
            found.line.frequency_hz,
            decibels(found)
        ),
        None if analysis.lines.is_empty() => {
            format!("{}: no characteristic frequencies known; envelope of {}.", analysis.name, band(analysis))
        }
        None => {
            format!("{}: no significant characteristic frequency in the envelope of {}.", analysis.name, band(analysis))
        }
    }
}

fn band(analysis: &Analysis) -> String {
    let band = &analysis.band.band_hz;
    format!("{:.0} to {:.0} Hz", band.start, band.end)
}

fn decibels(found: &MarkedLine) -> f64 {
    10.0 * found.line.ratio.max(f64::MIN_POSITIVE).log10()
}

/// Reason for the choice of the band.
fn why(analysis: &Analysis) -> String {
    match (analysis.band.choice, analysis.band.log_p_value) {
        (BandChoice::Stated, _) => "as stated".into(),
        (BandChoice::Lines(family), Some(p)) => format!(
            "chosen because its squared envelope shows {} and its harmonics with the smallest p-value ({})",
            family.name(),
            by_chance(p.exp())
        ),
        (BandChoice::Lines(family), None) => format!("chosen because it shows {}", family.name()),
        (BandChoice::Kurtosis, _) => "chosen for the largest kurtosis".into(),
        (BandChoice::Nothing, _) => "the full band of the converter's filter, as no band is significant".into(),
    }
}

fn sections(analysis: &Analysis, many: bool) -> Result<Vec<Section>, DrawError> {
    let heading = |text: &str| if many { format!("{}: {text}", analysis.name) } else { text.to_owned() };
    let mut out = vec![speed(analysis, Section::new(heading("Speed of the shaft")))];
    let svg = density::svg((&analysis.name, &analysis.density), None, Some(&analysis.band.band_hz))?;
    out.push(Section::new(heading("Spectrum")).figure(
        svg,
        format!(
            "Power spectral density (Welch, {:.1} Hz apart); shaded, the band of the envelope.",
            analysis.density.step_hz
        ),
    ));
    if let Some(tree) = &analysis.kurtogram {
        let best = match tree.best() {
            Some(cell) => format!(
                "The largest is {:.1}, at {:.0} Hz in a band of {:.0} Hz.",
                cell.kurtosis, cell.centre_hz, cell.bandwidth_hz
            ),
            None => "None exceeds that of noise.".into(),
        };
        out.push(Section::new(heading("Kurtogram")).figure(
            kurtogram::svg(tree, Some(&analysis.band.band_hz))?,
            format!(
                "Fast kurtogram (Antoni 2007): kurtosis of the envelope in bands, their number at the left of each row. {best} \
                 Red, the band of the envelope below. A single shock has a large kurtosis as well as repeated impacts."
            ),
        ));
    }
    out.push(envelope(analysis, Section::new(heading("Envelope")))?);
    out.extend(orders(analysis, Section::new(heading("Orders of the shaft")))?);
    if let Some(found) = &analysis.synchronous {
        out.push(Section::new(heading("Synchronous average")).figure(
            cycle::svg(&found.average, found.period_turns)?,
            format!(
                "Average over {} turns by the tachometer's pulses. It explains {:.1} % of the recording's variance, corrected \
                 for noise; bearing frequencies are not in it, as their orders are not integers.",
                found.periods,
                100.0 * found.explained.max(0.0)
            ),
        ));
    }
    Ok(out)
}

fn speed(analysis: &Analysis, section: Section) -> Section {
    let speed = &analysis.speed;
    let row = |name: &str, value: String| vec![Cell::text(name), Cell::text(value)];
    let mut rows = Vec::new();
    rows.extend(speed.nominal_hz.map(|hz| row("nominal", format!("{hz:.3} Hz"))));
    rows.extend(speed.tachometer_hz.map(|hz| row("by the tachometer", format!("{hz:.4} Hz"))));
    rows.extend(speed.tachometer_error.as_ref().map(|why| row("by the tachometer", why.clone())));
    match (&speed.estimate, &speed.not_determined) {
        (Some(estimate), _) => {
            rows.push(row(
                "by the recording's lines",
                format!(
                    "{:.4} ± {:.4} Hz, from {} lines{}; p at most {:.1} % by randomly shifted combs",
                    estimate.shaft_hz,
                    estimate.standard_error_hz,
                    estimate.lines.len(),
                    estimate.family.map_or(String::new(), |f| format!(" of the shaft and of {}", f.name())),
                    100.0 * estimate.p_value
                ),
            ));
            rows.extend(estimate.slip.map(|(slip, error)| {
                row(
                    "cage behind pure rolling",
                    format!("{:.3} ± {:.3} %", 100.0 * slip, 100.0 * error).replace('-', "−"),
                )
            }));
        }
        (None, Some(why)) => rows.push(row("by the recording's lines", format!("not determinable: {why}"))),
        (None, None) => {}
    }
    let used = match (speed.used_hz, speed.source) {
        (Some(hz), Some(SpeedSource::Tachometer)) => format!("{hz:.4} Hz, by the tachometer"),
        (Some(hz), Some(SpeedSource::Estimate)) => format!("{hz:.4} Hz, by the recording's lines"),
        (Some(hz), _) => format!("{hz:.4} Hz, the nominal one"),
        (None, _) => "none: no frequencies marked".into(),
    };
    rows.push(row("used below", used));
    section.table("", &[], rows)
}

/// Characteristic frequencies with a mark in pictures: there is no room for the names of sidebands and of the cage's
/// harmonics.
fn own_lines(analysis: &Analysis) -> impl Iterator<Item = &Characteristic> {
    let own = analysis.lines.iter().map(|l| &l.characteristic).filter(|c| c.sideband == 0);
    own.filter(|c| c.family != Family::Cage || c.harmonic == 1)
}

fn envelope(analysis: &Analysis, section: Section) -> Result<Section, DrawError> {
    let up_to = analysis.shown_hz();
    let marks: Vec<Mark> = own_lines(analysis).map(|c| Mark { at: c.frequency_hz, name: c.name.clone() }).collect();
    let points: Vec<(f64, f64)> = analysis.envelope.points().collect();
    let labels = Labels { legend: "envelope spectrum", x_name: "frequency, Hz", y_name: "envelope amplitude, m/s²" };
    let caption = format!(
        "Spectrum of the envelope of {}, {}. Dashed, the characteristic frequencies at the speed used: \
         BPFO and BPFI, ball passes of the outer and inner race; 2×BSF, strikes of a defect on a ball; FTF, turns of the cage.",
        band(analysis),
        why(analysis)
    );
    let mut section = section.figure(lines::svg(&points, up_to, &labels, &marks)?, caption);
    if let Some(coherence) = &analysis.coherence {
        let points: Vec<(f64, f64)> = coherence.points().collect();
        let labels =
            Labels { legend: "cyclic coherence", x_name: "cyclic frequency, Hz", y_name: "mean squared coherence" };
        if let Ok(svg) = lines::svg(&points, up_to.min(points.last().map_or(0.0, |p| p.0)), &labels, &marks) {
            section = section.figure(
                svg,
                "Enhanced envelope spectrum of the same band (Antoni, Xin, Hamzaoui 2017): the share of power modulated at each \
                 cyclic frequency, independent of the spectrum's shape. Strong lines and single shocks weigh no more than weak \
                 ones.",
            );
        }
    }
    let order = |hz: f64| analysis.speed.used_hz.map_or(String::new(), |shaft_hz| format!("{:.3}", hz / shaft_hz));
    let listed = analysis.lines.iter().filter(|l| l.characteristic.sideband == 0 || l.characteristic.harmonic == 1);
    let rows: Vec<Vec<Cell>> = listed
        .map(|l| {
            vec![
                Cell::text(l.characteristic.name.clone()),
                Cell::number(order(l.characteristic.frequency_hz)),
                Cell::number(format!("{:.2}", l.characteristic.frequency_hz)),
                Cell::number(format!("{:.2}", l.line.frequency_hz)),
                Cell::number(format!("{:.4}", l.line.amplitude)),
                Cell::number(fixed(decibels(l), 1)),
                Cell::number(if l.line.p_value < 1e-6 { "< 1e−6".into() } else { chance(l.line.p_value) }),
            ]
        })
        .collect();
    if rows.is_empty() {
        return Ok(section);
    }
    let head = ["line", "order", "expected, Hz", "found, Hz", "amplitude, m/s²", "above background, dB", "p"];
    Ok(section.table("Lines of the envelope spectrum", &head, rows))
}

fn orders(analysis: &Analysis, section: Section) -> Result<Option<Section>, DrawError> {
    let (Some(spectrum), Some(shaft_hz)) = (&analysis.orders, analysis.speed.used_hz) else { return Ok(None) };
    let marks: Vec<Mark> =
        own_lines(analysis).map(|c| Mark { at: c.frequency_hz / shaft_hz, name: c.name.clone() }).collect();
    let inner = own_lines(analysis).find(|c| c.family == Family::Inner && c.harmonic == 1);
    let up_to = inner.map_or(20.0, |c| 2.2 * c.frequency_hz / shaft_hz);
    let last = spectrum.points().last().map_or(up_to, |(order, _)| order);
    let points: Vec<(f64, f64)> = spectrum.points().collect();
    let labels = Labels { legend: "order spectrum", x_name: "order of the shaft", y_name: "amplitude, m/s²" };
    let Ok(svg) = lines::svg(&points, up_to.min(last), &labels, &marks) else { return Ok(None) };
    let by = match analysis.speed.source {
        Some(SpeedSource::Tachometer) => "by the tachometer's pulses",
        _ => "at the constant speed used",
    };
    Ok(Some(section.figure(
        svg,
        format!(
            "The recording resampled at equal shaft angles, {by}; amplitudes over orders, {:.3} apart. \
             Dashed, the shaft's harmonics and the bearing's orders.",
            spectrum.step
        ),
    )))
}

/// JSON document of an analysis.
pub fn value(analysis: &Analysis) -> Value {
    let best = analysis.kurtogram.as_ref().and_then(Kurtogram::best).map(|cell| {
        json!({ "centre_hz": cell.centre_hz, "bandwidth_hz": cell.bandwidth_hz, "level": cell.level,
                "kurtosis": cell.kurtosis, "significance": cell.significance() })
    });
    let same = |cell: &&crate::signal::kurtogram::Cell| {
        (cell.band_hz().start - analysis.band.band_hz.start).abs() < 1e-3 * cell.bandwidth_hz
            && (cell.band_hz().end - analysis.band.band_hz.end).abs() < 1e-3 * cell.bandwidth_hz
    };
    let own = analysis.kurtogram.as_ref().and_then(|k| k.cells.iter().find(same)).map(|cell| cell.kurtosis);
    let lines: Vec<Value> = analysis
        .lines
        .iter()
        .map(|found| {
            let (c, l) = (&found.characteristic, &found.line);
            json!({ "name": c.name, "family": c.family, "harmonic": c.harmonic, "sideband": c.sideband,
                    "expected_hz": c.frequency_hz, "frequency_hz": l.frequency_hz, "amplitude_m_per_s2": l.amplitude,
                    "background_m_per_s2": l.background, "signal_to_background": l.ratio, "p_value": l.p_value })
        })
        .collect();
    json!({
        "name": analysis.name, "file": analysis.file, "channel": analysis.channel,
        "sample_rate_hz": analysis.sample_rate_hz, "duration_s": analysis.duration_s,
        "speed": analysis.speed,
        "band": { "low_hz": analysis.band.band_hz.start, "high_hz": analysis.band.band_hz.end,
                  "chosen_by": analysis.band.choice, "kurtosis": own,
                  "log10_p_value": analysis.band.log_p_value.map(|p| p / std::f64::consts::LN_10) },
        "kurtogram_best": best,
        "lines": lines,
        "synchronous": analysis.synchronous.as_ref().map(|s| json!({ "turns": s.periods, "explained": s.explained })),
    })
}
