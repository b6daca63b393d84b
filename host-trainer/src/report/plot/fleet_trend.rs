//! Trend of one machine of a fleet.

use super::DrawError;
use super::settings::PlotSettings;
use super::style::{self, ALARM, Axes, EARLY, MEASURED};
use crate::fleet::machines::Point;

const SETTINGS: PlotSettings = PlotSettings::DEFAULT;

/// Picture of deviation and EWMA by block, with the limit to both sides.
///
/// # Errors
/// No block, errors of the drawing library.
pub fn svg(trend: &[Point], limit: f64) -> Result<String, DrawError> {
    let values = trend.iter().flat_map(|p| [Some(p.ewma), p.deviation]).flatten().chain([-1.2 * limit, 1.2 * limit]);
    let y = style::range(values, 0.05).ok_or_else(DrawError::empty)?;
    let end = trend.len() as f64 + 0.5;
    let axes = Axes { x: 0.5..end, y, x_name: "block", y_name: "healthy standard deviations" };
    style::picture(SETTINGS.fleet_height, |area| {
        let legend = [("deviation of a block", MEASURED), ("EWMA", EARLY), ("limit", ALARM)];
        let mut chart = style::chart(area, &axes, &legend)?;
        for limit in [limit, -limit] {
            style::dashed(&mut chart, (0.5, limit), (end, limit), ALARM)?;
        }
        let places = || (1..).map(f64::from);
        let deviation = places().zip(trend).map(|(x, p)| (x, p.deviation.unwrap_or(f64::NAN)));
        style::line(&mut chart, deviation, style::stroke(MEASURED, 1))?;
        style::line(&mut chart, places().zip(trend).map(|(x, p)| (x, p.ewma)), style::stroke(EARLY, 2))
    })
}
