//! A spectrum of lines over frequency or order, with places marked by name.

use plotters::style::text_anchor::HPos;

use super::DrawError;
use super::style::{self, ALARM, Axes, EARLY, HEIGHT};

/// A place with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Where, on the horizontal axis.
    pub at: f64,
    /// Its name; names that would hide one another stand below one another, and from the fifth on are left out.
    pub name: String,
}

/// What a picture shows beside its points.
#[derive(Clone, Debug)]
pub struct Labels<'t> {
    /// Name of the points.
    pub legend: &'t str,
    /// What goes to the right, with its unit.
    pub x_name: &'t str,
    /// What goes up, with its unit.
    pub y_name: &'t str,
}

/// Rows that names stand in.
const ROWS: usize = 4;
/// Share of the height that a row takes, and of the width that a letter takes.
const ROW: f64 = 0.055;
const LETTER: f64 = 0.0086;

/// Values from 0 on up to `up_to`; what is left of the second point is of the mean and not shown.
///
/// # Errors
/// What the drawing library says; no values.
pub fn svg(points: &[(f64, f64)], up_to: f64, labels: &Labels<'_>, marks: &[Mark]) -> Result<String, DrawError> {
    let shown: Vec<(f64, f64)> = points.iter().copied().skip(2).take_while(|(x, _)| *x <= up_to).collect();
    let top = shown.iter().map(|(_, y)| *y).filter(|y| y.is_finite()).fold(0.0, f64::max);
    if top <= 0.0 {
        return Err(DrawError::empty());
    }
    // Room for the names above the lines.
    let top = top * if marks.is_empty() { 1.06 } else { 1.0 / (1.0 - ROW * (ROWS as f64 + 0.6)) };
    style::picture(HEIGHT, |area| {
        let axes = Axes { x: 0.0..up_to, y: 0.0..top, x_name: labels.x_name, y_name: labels.y_name };
        let mut chart = style::chart(area, &axes, &[(labels.legend, EARLY)])?;
        let mut free = [f64::NEG_INFINITY; ROWS];
        for mark in marks.iter().filter(|m| m.at > 0.0 && m.at <= up_to) {
            style::dashed(&mut chart, (mark.at, 0.0), (mark.at, top), ALARM)?;
            let width = LETTER * up_to * (mark.name.chars().count() as f64 + 1.0);
            let fits = mark.at + width < 1.01 * up_to;
            let Some(row) = free.iter().position(|end| *end <= mark.at).filter(|_| fits) else { continue };
            free[row] = mark.at + width;
            let y = top * (1.0 - ROW * (row as f64 + 0.2));
            style::word(&mut chart, &mark.name, (mark.at + 0.003 * up_to, y), HPos::Left, ALARM)?;
        }
        style::line(&mut chart, shown.iter().copied(), style::stroke(EARLY, 1))
    })
}
