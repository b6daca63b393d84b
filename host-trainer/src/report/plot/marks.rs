//! Named places on the horizontal axis, their names in rows so that none covers another.

use std::ops::Range;

use plotters::style::text_anchor::HPos;

use super::DrawError;
use super::settings::PlotSettings;
use super::style::{self, ALARM, Chart};

const SETTINGS: PlotSettings = PlotSettings::DEFAULT;

/// Named place on the horizontal axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Place on the horizontal axis, in its unit.
    pub at: f64,
    /// Name; names that would overlap are stacked in rows, and left out beyond the last row.
    pub name: String,
}

/// Vertical range with room above it for the names.
pub fn with_room(y: Range<f64>, marks: &[Mark]) -> Range<f64> {
    let share = SETTINGS.name_row * (SETTINGS.name_rows as f64 + 0.6);
    let end = if marks.is_empty() { y.end } else { y.start + (y.end - y.start) / (1.0 - share) };
    y.start..end
}

/// Draws a dashed line at each place in `x`, in order, and its name at the top of `y`.
///
/// # Errors
/// Errors of the drawing library.
pub fn draw(chart: &mut Chart<'_>, marks: &[Mark], x: &Range<f64>, y: &Range<f64>) -> Result<(), DrawError> {
    let (width, height) = (x.end - x.start, y.end - y.start);
    let mut free = [f64::NEG_INFINITY; SETTINGS.name_rows];
    for mark in marks.iter().filter(|m| x.contains(&m.at) && m.at > x.start) {
        style::dashed(chart, (mark.at, y.start), (mark.at, y.end), ALARM)?;
        let end = mark.at + SETTINGS.letter * width * (mark.name.chars().count() as f64 + 1.0);
        let fits = end < x.end + 0.01 * width;
        let Some(row) = free.iter().position(|end| *end <= mark.at).filter(|_| fits && !mark.name.is_empty()) else {
            continue;
        };
        free[row] = end;
        let at = (mark.at + 0.003 * width, y.end - height * SETTINGS.name_row * (row as f64 + 0.2));
        style::word(chart, &mark.name, at, HPos::Left, ALARM)?;
    }
    Ok(())
}
