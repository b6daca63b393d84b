//! Line spectrum over frequency or order, with named marks.

use super::DrawError;
use super::marks::{self, Mark};
use super::style::{self, Axes, EARLY, HEIGHT};

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
    let (x, y) = (0.0..up_to, marks::with_room(0.0..top, marks));
    // A little room where there are no names.
    let y = y.start..y.end.max(1.06 * top);
    style::picture(HEIGHT, |area| {
        let axes = Axes { x: x.clone(), y: y.clone(), x_name: labels.x_name, y_name: labels.y_name };
        let mut chart = style::chart(area, &axes, &[(labels.legend, EARLY)])?;
        marks::draw(&mut chart, marks, &x, &y)?;
        style::line(&mut chart, shown.iter().copied(), style::stroke(EARLY, 1))
    })
}
