//! Measured and predicted derivatives over a short time.

use super::DrawError;
use super::settings::PlotSettings;
use super::style::{self, Axes, MEASURED, PREDICTED};
use crate::model::trace::Trace;

const SETTINGS: PlotSettings = PlotSettings::DEFAULT;

/// Picture with a panel for each chosen derivative: measured and predicted, in healthy standard
/// deviations of that derivative.
///
/// # Errors
/// Errors of the drawing library.
pub fn svg(window: &Trace, derivatives: &[usize]) -> Result<String, DrawError> {
    let panels = u32::try_from(derivatives.len().max(1)).map_err(DrawError::new)?;
    style::picture(SETTINGS.derivative_panel_height * panels, |area| {
        for (area, d) in area.split_evenly((panels as usize, 1)).iter().zip(derivatives) {
            let (Some(measured), Some(predicted)) = (window.measured.get(*d), window.predicted.get(*d)) else {
                return Err(DrawError::empty());
            };
            let name = window.names.get(*d).map_or("", String::as_str);
            let all = measured.iter().chain(predicted).map(|v| f64::from(*v));
            let axes = Axes {
                x: window.times_ms(),
                y: style::range(all, 0.05).ok_or_else(DrawError::empty)?,
                x_name: "time in the recording, ms",
                y_name: &format!("{name}, scaled"),
            };
            let legend = [("measured", MEASURED), ("predicted", PREDICTED)];
            let mut chart = style::chart(area, &axes, &legend)?;
            style::line(&mut chart, window.points(measured), style::stroke(MEASURED, 4))?;
            style::line(&mut chart, window.points(predicted), style::stroke(PREDICTED, 2))?;
        }
        Ok(())
    })
}
