//! The residual of two times of a machine's life, one above the other on one scale.

use super::DrawError;
use super::style::{self, Axes, EARLY, INK, LATE};
use crate::model::trace::Trace;

/// Height of a panel.
const PANEL: u32 = 210;
/// What is less than this is drawn here.
const LOWEST_DB: f64 = -20.0;

/// Root mean square over the derivatives of the residual, early above late; the dashed line is the
/// healthy level. In dB: a fault's residual is a hundred times a healthy one's, and both should be seen.
///
/// # Errors
/// What the drawing library says.
pub fn svg(early: (&str, &Trace), late: (&str, &Trace)) -> Result<String, DrawError> {
    let decibels = |v: &f32| (20.0 * f64::from(*v).log10()).max(LOWEST_DB);
    let all = early.1.residual.iter().chain(&late.1.residual).map(decibels);
    let y = style::range(all, 0.05).ok_or_else(DrawError::empty)?;
    style::picture(2 * PANEL, |area| {
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
