//! Curves over one axis, to be compared, with places on the axis marked.

use std::ops::Range;

use plotters::style::RGBColor;
use plotters::style::text_anchor::HPos;

use super::DrawError;
use super::lines::Mark;
use super::style::{self, ALARM, Axes, Entry, HEIGHT};

/// A named curve.
#[derive(Clone, Debug)]
pub struct Curve<'t> {
    /// What it is.
    pub name: &'t str,
    /// Its points, in order.
    pub points: Vec<(f64, f64)>,
    /// Its colour.
    pub color: RGBColor,
}

/// What the axes are called.
#[derive(Clone, Copy, Debug)]
pub struct Names<'t> {
    /// Below.
    pub x: &'t str,
    /// To the left.
    pub y: &'t str,
}

/// All curves within `x`, later ones above earlier ones.
///
/// # Errors
/// What the drawing library says; no points at all.
pub fn svg(curves: &[Curve<'_>], x: Range<f64>, names: Names<'_>, marks: &[Mark]) -> Result<String, DrawError> {
    let inside = |curve: &Curve<'_>| -> Vec<(f64, f64)> {
        curve.points.iter().copied().filter(|(at, _)| x.contains(at)).collect()
    };
    let drawn: Vec<_> = curves.iter().map(|c| (inside(c), c.color)).collect();
    let all = drawn.iter().flat_map(|(points, _)| points.iter().map(|(_, v)| *v));
    let y = style::range(all, 0.08).ok_or_else(DrawError::empty)?;
    let legend: Vec<Entry<'_>> = curves.iter().map(|c| (c.name, c.color)).collect();
    style::picture(HEIGHT, |area| {
        let axes = Axes { x: x.clone(), y: y.clone(), x_name: names.x, y_name: names.y };
        let mut chart = style::chart(area, &axes, &legend)?;
        let width = x.end - x.start;
        for Mark { name, at } in marks.iter().filter(|m| x.contains(&m.at)) {
            style::dashed(&mut chart, (*at, y.start), (*at, y.end), ALARM)?;
            let top = y.end - 0.015 * (y.end - y.start);
            style::word(&mut chart, name, (at + 0.004 * width, top), HPos::Left, ALARM)?;
        }
        for (points, color) in drawn {
            style::line(&mut chart, points, style::stroke(color, 2))?;
        }
        Ok(())
    })
}
