//! Scores of sets as dots in named rows: one colour for each bearing, the mean in ink with its interval.

use std::ops::Range;

use plotters::element::Circle;
use plotters::style::{Color, RGBColor};

use super::DrawError;
use super::settings::PlotSettings;
use super::style::{self, ALARM, Axes, EARLY, Entry, INK, LATE, MEASURED, PREDICTED};

const SETTINGS: PlotSettings = PlotSettings::DEFAULT;
/// Colours of bearings; further ones share the last.
const COLORS: [RGBColor; 4] = [EARLY, LATE, PREDICTED, MEASURED];

/// Row of dots.
#[derive(Clone, Debug)]
pub struct Rating {
    /// Name of the row.
    pub name: String,
    /// Score of each bearing.
    pub scores: Vec<f64>,
    /// Mean.
    pub mean: f64,
    /// Its interval.
    pub interval: [f64; 2],
}

/// Picture of rows, the first on top; `chance` is marked. Without names of bearings all dots have one colour.
///
/// # Errors
/// Errors of the drawing library.
pub fn svg(
    rows: &[Rating],
    bearings: &[String],
    x: Range<f64>,
    x_name: &str,
    chance: f64,
) -> Result<String, DrawError> {
    let names: Vec<String> = rows.iter().rev().map(|row| row.name.clone()).collect();
    let mut legend: Vec<Entry<'_>> = vec![("mean, interval of 95 %", INK)];
    legend.extend(bearings.iter().map(String::as_str).zip(COLORS));
    legend.push(("chance", ALARM));
    let count = rows.len() as f64;
    let height = SETTINGS.rating_height * rows.len() as u32 + SETTINGS.rating_margin;
    style::picture(height, |area| {
        let axes = Axes { x: x.clone(), y: 0.0..count, x_name, y_name: "" };
        let mut chart = style::chart_with_rows(area, &axes, &legend, &names)?;
        style::dashed(&mut chart, (chance, 0.0), (chance, count), ALARM)?;
        for (n, row) in rows.iter().rev().enumerate() {
            let y = n as f64 + 0.5;
            style::line(&mut chart, row.interval.map(|x| (x, y)), style::stroke(INK, 2))?;
            let ends = [(row.mean, y - 0.3), (row.mean, y + 0.3)];
            style::line(&mut chart, ends, style::stroke(INK, 3))?;
            for (b, score) in row.scores.iter().enumerate() {
                let color = if bearings.is_empty() { MEASURED } else { COLORS[b.min(COLORS.len() - 1)] };
                let dot = Circle::new((*score, y), 5, color.mix(0.85).filled());
                chart.draw_series([dot]).map_err(DrawError::new)?;
            }
        }
        Ok(())
    })
}
