//! Line spectrum over frequency or order, with named marks.

use plotters::style::text_anchor::HPos;

use super::DrawError;
use super::settings::PlotSettings;
use super::style::{self, ALARM, Axes, EARLY, HEIGHT};

/// Named place on the horizontal axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Place on the horizontal axis, in its unit.
    pub at: f64,
    /// Name; names that would overlap are stacked in rows, and left out beyond the last row.
    pub name: String,
}

/// Texts of a picture.
#[derive(Clone, Debug)]
pub struct Labels<'t> {
    /// Name of the points.
    pub legend: &'t str,
    /// Name of the horizontal axis, with its unit.
    pub x_name: &'t str,
    /// Name of the vertical axis, with its unit.
    pub y_name: &'t str,
}

const SETTINGS: PlotSettings = PlotSettings::DEFAULT;

/// Picture of the points from 0 to `up_to`; the first two belong to the mean and are left out.
///
/// # Errors
/// Errors of the drawing library; no values.
pub fn svg(points: &[(f64, f64)], up_to: f64, labels: &Labels<'_>, marks: &[Mark]) -> Result<String, DrawError> {
    let shown: Vec<(f64, f64)> = points.iter().copied().skip(2).take_while(|(x, _)| *x <= up_to).collect();
    let top = shown.iter().map(|(_, y)| *y).filter(|y| y.is_finite()).fold(0.0, f64::max);
    if top <= 0.0 {
        return Err(DrawError::empty());
    }
    // Room for the names above the lines.
    let top =
        top * if marks.is_empty() { 1.06 } else { 1.0 / (1.0 - SETTINGS.name_row * (SETTINGS.name_rows as f64 + 0.6)) };
    style::picture(HEIGHT, |area| {
        let axes = Axes { x: 0.0..up_to, y: 0.0..top, x_name: labels.x_name, y_name: labels.y_name };
        let mut chart = style::chart(area, &axes, &[(labels.legend, EARLY)])?;
        let mut free = [f64::NEG_INFINITY; SETTINGS.name_rows];
        for mark in marks.iter().filter(|m| m.at > 0.0 && m.at <= up_to) {
            style::dashed(&mut chart, (mark.at, 0.0), (mark.at, top), ALARM)?;
            let width = SETTINGS.letter * up_to * (mark.name.chars().count() as f64 + 1.0);
            let fits = mark.at + width < 1.01 * up_to;
            let Some(row) = free.iter().position(|end| *end <= mark.at).filter(|_| fits) else { continue };
            free[row] = mark.at + width;
            let y = top * (1.0 - SETTINGS.name_row * (row as f64 + 0.2));
            style::word(&mut chart, &mark.name, (mark.at + 0.003 * up_to, y), HPos::Left, ALARM)?;
        }
        style::line(&mut chart, shown.iter().copied(), style::stroke(EARLY, 1))
    })
}
