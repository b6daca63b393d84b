//! Residuals, early above late on one scale.

use super::DrawError;
use super::settings::PlotSettings;
use super::style::{self, Axes, EARLY, INK, LATE};
use crate::model::trace::Trace;

const SETTINGS: PlotSettings = PlotSettings::DEFAULT;

/// Picture of the residual's RMS over the derivatives, early above late; the dashed line is the healthy
/// level. In dB: a fault's residual may be a hundred times a healthy one's.
///
/// # Errors
/// Errors of the drawing library.
pub fn svg(early: (&str, &Trace), late: (&str, &Trace)) -> Result<String, DrawError> {
    let decibels = |v: &f32| (20.0 * f64::from(*v).log10()).max(SETTINGS.lowest_db);
    let all = early.1.residual.iter().chain(&late.1.residual).map(decibels);
    let y = style::range(all, 0.05).ok_or_else(DrawError::empty)?;
    style::picture(2 * SETTINGS.residual_panel_height, |area| {
        for (area, ((name, window), color)) in area.split_evenly((2, 1)).iter().zip([(early, EARLY), (late, LATE)]) {
            let axes = Axes {
                x: window.times_ms(),
                y: y.clone(),
                x_name: "time in the recording, ms",
                y_name: "dB re healthy",
            };
            let mut chart = style::chart(area, &axes, &[(name, color)])?;
            let levels: Vec<f32> = window.residual.iter().map(|v| decibels(v) as f32).collect();
            style::line(&mut chart, window.points(&levels), style::stroke(color, 1))?;
            style::dashed(&mut chart, (axes.x.start, 0.0), (axes.x.end, 0.0), INK)?;
        }
        Ok(())
    })
}
