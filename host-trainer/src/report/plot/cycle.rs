//! Synchronous average over the shaft's angle.

use super::DrawError;
use super::settings::PlotSettings;
use super::style::{self, Axes, EARLY, INK};

const SETTINGS: PlotSettings = PlotSettings::DEFAULT;

/// Picture of one period of so many turns.
///
/// # Errors
/// Errors of the drawing library; no values.
pub fn svg(average: &[f64], turns: usize) -> Result<String, DrawError> {
    let y = style::range(average.iter().copied(), 0.08).ok_or_else(DrawError::empty)?;
    let end = 360.0 * turns as f64;
    style::picture(SETTINGS.cycle_height, |area| {
        let axes = Axes { x: 0.0..end, y, x_name: "angle after the tachometer's pulse, °", y_name: "average, m/s²" };
        let mut chart = style::chart(area, &axes, &[("synchronous average", EARLY)])?;
        style::dashed(&mut chart, (0.0, 0.0), (end, 0.0), INK)?;
        let step = end / average.len() as f64;
        let points = average.iter().enumerate().map(|(k, v)| (k as f64 * step, *v));
        style::line(&mut chart, points, style::stroke(EARLY, 1))
    })
}
