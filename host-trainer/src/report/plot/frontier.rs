//! Scores of models against what they cost on a device.

use plotters::element::Circle;
use plotters::style::text_anchor::HPos;
use plotters::style::{Color, RGBColor};

use super::DrawError;
use super::style::{self, ALARM, Area, Axes, EARLY, HEIGHT, LATE};

/// A model.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Name.
    pub name: String,
    /// Cycles of the most expensive sample.
    pub cycles: f64,
    /// Mean R² of the derivatives, held out.
    pub held_out: f64,
    /// R² of the next sample; `None` without a causal fit.
    pub next_sample: Option<f64>,
}

/// Picture of held-out R² and, below, of the next sample's R², over the logarithm of the cycles; the cycles between two samples
/// are marked.
///
/// # Errors
/// Errors of the drawing library; no finite score.
pub fn svg(points: &[Point], period_cycles: f64) -> Result<String, DrawError> {
    style::picture(2 * HEIGHT, |area| {
        let (upper, lower) = area.split_vertically(HEIGHT);
        let of = |score: fn(&Point) -> Option<f64>| -> Vec<(&Point, f64)> {
            points.iter().filter_map(|point| Some((point, score(point).filter(|score| score.is_finite())?))).collect()
        };
        panel(&upper, ("R², held out", EARLY), &of(|point| Some(point.held_out)), period_cycles)?;
        panel(&lower, ("R² of the next sample", LATE), &of(|point| point.next_sample), period_cycles)
    })
}

fn panel(
    area: &Area<'_>,
    (name, color): (&str, RGBColor),
    scores: &[(&Point, f64)],
    period_cycles: f64,
) -> Result<(), DrawError> {
    let cycles = scores.iter().map(|(point, _)| point.cycles).chain([period_cycles]);
    let x = style::range(cycles.map(f64::log10), 0.1).ok_or_else(DrawError::empty)?;
    let y = style::range(scores.iter().map(|(_, score)| *score), 0.2).ok_or_else(DrawError::empty)?;
    let axes = Axes { x: x.clone(), y: y.clone(), x_name: "log₁₀ of the cycles of the worst sample", y_name: name };
    let mut chart = style::chart(area, &axes, &[(name, color), ("cycles between two samples", ALARM)])?;
    let period = period_cycles.log10();
    style::dashed(&mut chart, (period, y.start), (period, y.end), ALARM)?;
    for (n, (point, score)) in scores.iter().enumerate() {
        let at = (point.cycles.log10(), *score);
        chart.draw_series([Circle::new(at, 5, color.mix(0.85).filled())]).map_err(DrawError::new)?;
        // Neighbours' names above and below in turn.
        let above = if n % 2 == 0 { 0.11 } else { -0.03 };
        style::word(&mut chart, &point.name, (at.0, at.1 + above * (y.end - y.start)), HPos::Center, color)?;
    }
    Ok(())
}
