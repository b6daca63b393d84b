//! Vibration indicators over recordings.

use plotters::style::RGBColor;
use plotters::style::text_anchor::HPos;

use super::DrawError;
use super::settings::PlotSettings;
use super::style::{self, ALARM, Area, EARLY, INK, LATE};
use super::time_axis::TimeAxis;
use crate::signal::indicators::{Indicators, IsoClass};

const SETTINGS: PlotSettings = PlotSettings::DEFAULT;

/// Curve of a panel: name, colour, one value a recording; NaN where there is none.
type Curve<'n> = (&'n str, RGBColor, Vec<f64>);

/// Picture of the indicators, one panel for each unit; the velocity's panel has the zones of `class`, and is left out
/// if no recording has a velocity.
///
/// # Errors
/// Errors of the drawing library.
pub fn svg(indicators: &[Indicators], time: &TimeAxis, class: Option<IsoClass>) -> Result<String, DrawError> {
    let values = |pick: fn(&Indicators) -> f64| indicators.iter().map(pick).collect::<Vec<f64>>();
    let velocity = values(|i| i.velocity.unwrap_or(f64::NAN));
    let boundaries = class.map_or(Vec::new(), |c| c.boundaries_mm_per_s().to_vec());
    let mut panels: Vec<(&str, Vec<Curve<'_>>, &[f64])> = vec![
        ("m/s²", vec![("RMS", EARLY, values(|i| i.rms)), ("peak", LATE, values(|i| i.peak))], &[]),
        (
            "ratio",
            vec![("crest factor", EARLY, values(Indicators::crest_factor)), ("kurtosis", LATE, values(|i| i.kurtosis))],
            &[],
        ),
    ];
    if velocity.iter().any(|v| v.is_finite()) {
        panels.push(("mm/s RMS", vec![("velocity, 10 Hz to 1 kHz", EARLY, velocity)], &boundaries));
    }
    let height = SETTINGS.indicator_panel_height;
    style::picture(height * panels.len() as u32, |area| {
        let areas = area.split_evenly((panels.len(), 1));
        areas.iter().zip(&panels).try_for_each(|(area, (unit, curves, zones))| panel(area, time, unit, curves, zones))
    })
}

fn panel(area: &Area<'_>, time: &TimeAxis, unit: &str, curves: &[Curve<'_>], zones: &[f64]) -> Result<(), DrawError> {
    let all = || curves.iter().flat_map(|(_, _, values)| values.iter().copied());
    let highest = all().filter(|v| v.is_finite()).fold(0.0, f64::max);
    // Zones far beyond the machine's level would press its trend flat.
    let shown: Vec<f64> = zones.iter().copied().take(1 + zones.iter().filter(|z| **z < highest).count()).collect();
    let highest = shown.iter().copied().fold(highest, f64::max);
    let high = if highest > 0.0 { 1.12 * highest } else { 1.0 };
    let legend: Vec<_> = curves.iter().map(|(name, color, _)| (*name, *color)).collect();
    let mut chart = style::chart_over_time(area, time, 0.0..high, unit, &legend)?;
    let range = time.range();
    let mut free = f64::NEG_INFINITY;
    for (zone, name) in shown.iter().zip(["A/B", "B/C", "C/D"]) {
        style::dashed(&mut chart, (range.start, *zone), (range.end, *zone), ALARM)?;
        // The names of boundaries that are close would cover each other.
        if *zone < free {
            continue;
        }
        free = zone + SETTINGS.zone_name * high;
        let at = (range.start + 0.006 * (range.end - range.start), *zone);
        style::word(&mut chart, name, at, HPos::Left, INK)?;
    }
    for (_, color, values) in curves {
        let points = || values.iter().enumerate().map(|(n, v)| (time.at(n, 0.5), *v));
        style::line(&mut chart, points(), style::stroke(*color, 2))?;
        if values.len() <= SETTINGS.dots {
            style::dots(&mut chart, points(), *color)?;
        }
    }
    Ok(())
}
