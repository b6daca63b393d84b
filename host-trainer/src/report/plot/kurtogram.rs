//! Picture of a kurtogram: levels downwards, frequency to the right, kurtosis as colour.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::DrawError;
use super::settings::PlotSettings;
use super::style::{self, ALARM, Axes, HEIGHT, INK};
use crate::signal::kurtogram::{Cell, Kurtogram};

const SETTINGS: PlotSettings = PlotSettings::DEFAULT;

/// Picture of the bands of a kurtogram; the chosen one is framed.
///
/// # Errors
/// Errors of the drawing library.
pub fn svg(kurtogram: &Kurtogram, chosen: Option<&std::ops::Range<f64>>) -> Result<String, DrawError> {
    let mut levels: Vec<f64> = kurtogram.cells.iter().map(|c| c.level).collect();
    levels.dedup();
    let rows = levels.len() as f64;
    let khz = 1e-3;
    let end = khz * kurtogram.nyquist_hz;
    // A negative kurtosis is that of a tone, no impact.
    let most = kurtogram.cells.iter().map(|c| c.kurtosis).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let row = |cell: &Cell| levels.iter().position(|l| *l == cell.level).unwrap_or(0) as f64;
    style::picture(HEIGHT, |area| {
        let axes = Axes { x: 0.0..end, y: rows..0.0, x_name: "frequency, kHz", y_name: "bands" };
        let names: Vec<String> = levels.iter().map(|l| format!("{:.0}", l.exp2())).collect();
        let entries = format!("kurtosis from 0 (pale) to {most:.1} (dark)");
        let mut chart = style::chart_with_rows(area, &axes, &[(&entries, shade(0.8))], &names)?;
        let boxes = kurtogram.cells.iter().map(|cell| {
            let (top, band) = (row(cell), cell.band_hz());
            let corners = [(khz * band.start, top), (khz * band.end, top + 1.0)];
            let share = (cell.kurtosis / most).clamp(0.0, 1.0);
            // In steps, so that the file stays small and neighbours of one colour look like one.
            let share = (share * SETTINGS.colour_steps as f64).round() / SETTINGS.colour_steps as f64;
            Rectangle::new(corners, shade(share).filled())
        });
        chart.draw_series(boxes).map_err(DrawError::new)?;
        let found = chosen.and_then(|band| {
            let near = |c: &&Cell| {
                let tolerance = 1e-3 * c.bandwidth_hz;
                (c.band_hz().start - band.start).abs() < tolerance && (c.band_hz().end - band.end).abs() < tolerance
            };
            kurtogram.cells.iter().find(near)
        });
        let frame = [(0.0, 0.0), (end, 0.0), (end, rows), (0.0, rows), (0.0, 0.0)];
        style::line(&mut chart, frame, style::stroke(INK, 1))?;
        match (found, chosen) {
            (Some(cell), _) => {
                let (top, band) = (row(cell), cell.band_hz());
                let (left, right) = (khz * band.start, khz * band.end);
                let around = [(left, top), (right, top), (right, top + 1.0), (left, top + 1.0), (left, top)];
                style::line(&mut chart, around, style::stroke(ALARM, 3))?;
            }
            (None, Some(band)) => {
                for f in [khz * band.start, khz * band.end] {
                    style::dashed(&mut chart, (f, 0.0), (f, rows), ALARM)?;
                }
                style::word(&mut chart, "band", (khz * band.start + 0.005 * end, 0.1), HPos::Left, ALARM)?;
            }
            (None, None) => {}
        }
        Ok(())
    })
}

/// Colour of a share: from nearly white over blue to nearly black, distinct in grey as well.
fn shade(share: f64) -> RGBColor {
    let anchors = [(246.0, 248.0, 250.0), (120.0, 176.0, 216.0), (31.0, 92.0, 150.0), (10.0, 24.0, 56.0)];
    let place = share * (anchors.len() - 1) as f64;
    let low = (place as usize).min(anchors.len() - 2);
    let part = place - low as f64;
    let mix = |a: f64, b: f64| (a + part * (b - a)).round() as u8;
    let (a, b): ((f64, f64, f64), (f64, f64, f64)) = (anchors[low], anchors[low + 1]);
    RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}
