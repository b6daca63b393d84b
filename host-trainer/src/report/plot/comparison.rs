//! Comparison of curves over one axis, with marks on the axis.

use std::ops::Range;

use plotters::style::RGBColor;

use super::DrawError;
use super::marks::{self, Mark};
use super::style::{self, Axes, Entry, HEIGHT};

/// A named curve.
#[derive(Clone, Debug)]
pub struct Curve<'t> {
    /// Name in the legend.
    pub name: &'t str,
    /// Points in order of x.
    pub points: Vec<(f64, f64)>,
    /// Colour.
    pub color: RGBColor,
}

/// Names of the axes, with units.
#[derive(Clone, Copy, Debug)]
pub struct Names<'t> {
    /// Name of the horizontal axis.
    pub x: &'t str,
    /// Name of the vertical axis.
    pub y: &'t str,
}

/// Picture of all curves within `x`, later ones drawn above earlier ones.
///
/// # Errors
/// Errors of the drawing library; no points at all.
pub fn svg(curves: &[Curve<'_>], x: Range<f64>, names: Names<'_>, marks: &[Mark]) -> Result<String, DrawError> {
    let inside = |curve: &Curve<'_>| -> Vec<(f64, f64)> {
        curve.points.iter().copied().filter(|(at, _)| x.contains(at)).collect()
    };
    let drawn: Vec<_> = curves.iter().map(|c| (inside(c), c.color)).collect();
    let all = drawn.iter().flat_map(|(points, _)| points.iter().map(|(_, v)| *v));
    let y = marks::with_room(style::range(all, 0.08).ok_or_else(DrawError::empty)?, marks);
    let legend: Vec<Entry<'_>> = curves.iter().map(|c| (c.name, c.color)).collect();
    style::picture(HEIGHT, |area| {
        let axes = Axes { x: x.clone(), y: y.clone(), x_name: names.x, y_name: names.y };
        let mut chart = style::chart(area, &axes, &legend)?;
        marks::draw(&mut chart, marks, &x, &y)?;
        for (points, color) in drawn {
            style::line(&mut chart, points, style::stroke(color, 2))?;
        }
        Ok(())
    })
}
