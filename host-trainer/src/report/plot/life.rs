//! Kurtosis and RMS over a machine's life, as in the paper's Figure 8.

use std::ops::Range;

use plotters::style::RGBColor;
use plotters::style::text_anchor::HPos;

use super::DrawError;
use super::style::{self, ALARM, Area, Axes, EARLY, HEIGHT, INK, LATE};
use crate::signal::phases::life::Features;
use crate::signal::phases::{Phases, Rules};

/// Picture of kurtosis with its healthy limits, and of RMS below it; the starts of aging and failure are marked.
///
/// # Errors
/// Errors of the drawing library; no finite feature.
pub fn svg(features: &[Features], phases: &Phases, rules: &Rules) -> Result<String, DrawError> {
    let kurtosis = features.iter().map(|f| f.kurtosis);
    let rms = features.iter().map(|f| f.rms);
    let limits = [-1.0, 1.0].map(|side| phases.mean + side * rules.sigmas * phases.std);
    style::picture(2 * HEIGHT, |area| {
        let (upper, lower) = area.split_vertically(HEIGHT);
        panel(&upper, "kurtosis", ("kurtosis", EARLY), kurtosis.collect(), Some(limits[0]..limits[1]), phases)?;
        panel(&lower, "RMS, m/s²", ("RMS", LATE), rms.collect(), None, phases)
    })
}

fn panel(
    area: &Area<'_>,
    y_name: &str,
    legend: (&str, RGBColor),
    values: Vec<f64>,
    limits: Option<Range<f64>>,
    phases: &Phases,
) -> Result<(), DrawError> {
    let count = values.len() as f64;
    let shown = values.iter().copied().chain(limits.iter().flat_map(|l| [l.start, l.end]));
    let y = style::range(shown, 0.05).ok_or_else(DrawError::empty)?;
    let axes = Axes { x: 0.0..count + 1.0, y: y.clone(), x_name: "recording", y_name };
    let mut entries = vec![legend];
    entries.extend(limits.as_ref().map(|_| ("limits of the healthy recordings", INK)));
    let mut chart = style::chart(area, &axes, &entries)?;
    style::shade(&mut chart, 0.5..phases.healthy as f64 + 0.5, y.clone(), EARLY)?;
    for limit in limits.iter().flat_map(|l| [l.start, l.end]) {
        style::dashed(&mut chart, (0.5, limit), (count + 0.5, limit), INK)?;
    }
    let points = values.iter().enumerate().map(|(n, value)| (n as f64 + 1.0, *value));
    style::line(&mut chart, points, style::stroke(legend.1, 1))?;
    for (start, name, below) in [(phases.aging, "aging", 0.03), (phases.failure, "failure", 0.1)] {
        let Some(start) = start else { continue };
        let x = start as f64 + 0.5;
        style::dashed(&mut chart, (x, y.start), (x, y.end), ALARM)?;
        let (side, gap) = if x > 0.5 * count { (HPos::Right, -0.006) } else { (HPos::Left, 0.006) };
        style::word(&mut chart, name, (x + gap * count, y.end - below * (y.end - y.start)), side, ALARM)?;
    }
    Ok(())
}
