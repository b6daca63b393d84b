//! The residual of two times of a machine's life, one above the other on one scale.

use super::DrawError;
use super::style::{self, Axes, EARLY, INK, LATE};
use crate::window::Window;

/// Height of a panel.
const PANEL: u32 = 210;

/// Root mean square over the derivatives of the residual in healthy spreads, early above late; the
/// dashed line is the healthy level.
///
/// # Errors
/// What the drawing library says.
pub fn svg(early: (&str, &Window), late: (&str, &Window)) -> Result<String, DrawError> {
    let all = early.1.residual.iter().chain(&late.1.residual).map(|v| f64::from(*v));
    let top = style::range(all, 0.05).ok_or_else(DrawError::empty)?.end;
    style::picture(2 * PANEL, |area| {
        for (area, ((name, window), color)) in area.split_evenly((2, 1)).iter().zip([(early, EARLY), (late, LATE)]) {
            let axes = Axes {
                x: window.times_ms(),
                y: 0.0..top,
                x_name: "time in the recording, ms",
                y_name: "residual, healthy spreads",
            };
            let mut chart = style::chart(area, &axes, &[(name, color)])?;
            style::line(&mut chart, window.points(&window.residual), style::stroke(color, 1))?;
            style::dashed(&mut chart, (axes.x.start, 1.0), (axes.x.end, 1.0), INK)?;
        }
        Ok(())
    })
}
