//! Common style of all pictures: size, fonts, colours, axes, and a legend above the plot.

use std::ops::Range;

use plotters::backend::SVGBackend;
use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::DrawError;
use super::time_axis::TimeAxis;

/// Width of every picture, pixels.
pub const WIDTH: u32 = 1000;
/// Height of a picture of one panel, pixels.
pub const HEIGHT: u32 = 380;

/// Blue of early curves: distinct from [`LATE`] for colour-blind eyes and, by lightness, in print.
pub const EARLY: RGBColor = RGBColor(31, 111, 180);
/// Orange of late curves.
pub const LATE: RGBColor = RGBColor(214, 106, 16);
/// Grey of measured curves.
pub const MEASURED: RGBColor = RGBColor(120, 130, 145);
/// Purple of predicted curves.
pub const PREDICTED: RGBColor = RGBColor(150, 40, 120);
/// Red of alarms and marks.
pub const ALARM: RGBColor = RGBColor(200, 30, 45);
/// Dark grey of text and axes.
pub const INK: RGBColor = RGBColor(45, 52, 64);
const GRID: RGBColor = RGBColor(222, 226, 232);

const LABEL: u32 = 14;
const LEGEND_HEIGHT: u32 = 26;
/// Width of labels and axis name at the left of the plot, pixels.
const LEFT: u32 = 66;
const EDGE: u32 = 10;
/// Width of a letter over its height: no font is at hand to measure with.
const LETTER: f64 = 0.54;

/// Drawing area of an SVG picture.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Plot with Cartesian axes.
pub type Chart<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Ranges and names of a plot's axes.
#[derive(Clone, Debug)]
pub struct Axes<'t> {
    /// Horizontal range.
    pub x: Range<f64>,
    /// Vertical range.
    pub y: Range<f64>,
    /// Name of the horizontal axis, with its unit.
    pub x_name: &'t str,
    /// Name of the vertical axis, with its unit.
    pub y_name: &'t str,
}

/// SVG of a picture `height` pixels high: white, then what `draw` draws.
///
/// # Errors
/// Errors of the drawing library.
pub fn picture(height: u32, draw: impl FnOnce(&Area<'_>) -> Result<(), DrawError>) -> Result<String, DrawError> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (WIDTH, height)).into_drawing_area();
        root.fill(&WHITE).map_err(DrawError::new)?;
        draw(&root)?;
        root.present().map_err(DrawError::new)?;
    }
    Ok(text)
}

/// Entry of the legend: name and colour.
pub type Entry<'t> = (&'t str, RGBColor);

/// Plot with axes and grid, below its legend.
///
/// # Errors
/// Errors of the drawing library.
pub fn chart<'a>(area: &Area<'a>, axes: &Axes<'_>, legend: &[Entry<'_>]) -> Result<Chart<'a>, DrawError> {
    chart_of(area, axes, legend, None, &tick)
}

/// Plot as [`chart`] over an axis of time.
///
/// # Errors
/// Errors of the drawing library.
pub fn chart_over_time<'a>(
    area: &Area<'a>,
    time: &TimeAxis,
    y: Range<f64>,
    y_name: &str,
    legend: &[Entry<'_>],
) -> Result<Chart<'a>, DrawError> {
    let axes = Axes { x: time.range(), y, x_name: time.name(), y_name };
    chart_of(area, &axes, legend, None, &|place| time.tick(place))
}

/// Plot without grid whose rows of height 1 have names instead of numbers; long names have more room.
///
/// # Errors
/// Errors of the drawing library.
pub fn chart_with_rows<'a>(
    area: &Area<'a>,
    axes: &Axes<'_>,
    legend: &[Entry<'_>],
    rows: &[String],
) -> Result<Chart<'a>, DrawError> {
    chart_of(area, axes, legend, Some(rows), &tick)
}

fn chart_of<'a>(
    area: &Area<'a>,
    axes: &Axes<'_>,
    legend: &[Entry<'_>],
    rows: Option<&[String]>,
    x_tick: &dyn Fn(f64) -> String,
) -> Result<Chart<'a>, DrawError> {
    let (top, below) = area.split_vertically(LEGEND_HEIGHT);
    let font = ("sans-serif", LABEL).into_font().color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
    let mut x = (EDGE + LEFT) as i32 + 4;
    let y = LEGEND_HEIGHT as i32 / 2 + 4;
    for (name, color) in legend {
        top.draw(&PathElement::new([(x, y), (x + 22, y)], color.stroke_width(3))).map_err(DrawError::new)?;
        top.draw(&Text::new(*name, (x + 28, y), font.clone())).map_err(DrawError::new)?;
        x += 28 + (name.chars().count() as f64 * LETTER * f64::from(LABEL)) as i32 + 24;
    }
    let letters = rows.unwrap_or(&[]).iter().map(|name| name.chars().count()).max().unwrap_or(0);
    let left = LEFT.max((letters as f64 * LETTER * f64::from(LABEL)) as u32 + 8);
    let mut chart = ChartBuilder::on(&below)
        .margin_top(6)
        .margin_left(EDGE)
        .margin_right(18)
        .margin_bottom(4)
        .x_label_area_size(44)
        .y_label_area_size(left)
        .build_cartesian_2d(axes.x.clone(), axes.y.clone())
        .map_err(DrawError::new)?;
    let number = |v: &f64| if rows.is_some() { String::new() } else { tick(*v) };
    let x_number = |v: &f64| x_tick(*v);
    let mut mesh = chart.configure_mesh();
    if rows.is_some() {
        mesh.disable_mesh();
    }
    mesh.max_light_lines(0)
        .bold_line_style(GRID)
        .axis_style(INK.mix(0.5))
        .x_labels(11)
        .y_labels(if below.dim_in_pixel().1 < 200 { 5 } else { 7 })
        .x_label_formatter(&x_number)
        .y_label_formatter(&number)
        .x_desc(axes.x_name)
        .y_desc(axes.y_name)
        .label_style(("sans-serif", LABEL, &INK))
        .axis_desc_style(("sans-serif", LABEL + 1, &INK))
        .draw()
        .map_err(DrawError::new)?;
    drop(mesh);
    for (row, name) in rows.unwrap_or(&[]).iter().enumerate() {
        let (x, y) = chart.backend_coord(&(axes.x.start, row as f64 + 0.5));
        let font = ("sans-serif", LABEL).into_font().color(&INK).pos(Pos::new(HPos::Right, VPos::Center));
        // The backend counts from the corner of the whole picture.
        let (left, above) = area.get_base_pixel();
        area.draw(&Text::new(name.clone(), (x - 8 - left, y - above), font)).map_err(DrawError::new)?;
    }
    Ok(chart)
}

/// Line through points; points that are not finite are left out.
///
/// # Errors
/// Errors of the drawing library.
pub fn line(
    chart: &mut Chart<'_>,
    points: impl IntoIterator<Item = (f64, f64)>,
    style: ShapeStyle,
) -> Result<(), DrawError> {
    let points = points.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite());
    chart.draw_series(LineSeries::new(points, style)).map(|_| ()).map_err(DrawError::new)
}

/// Dots at points, for trends of few; points that are not finite are left out.
///
/// # Errors
/// Errors of the drawing library.
pub fn dots(
    chart: &mut Chart<'_>,
    points: impl IntoIterator<Item = (f64, f64)>,
    color: RGBColor,
) -> Result<(), DrawError> {
    let points = points.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite());
    let dots = points.map(|point| Circle::new(point, 3, color.filled()));
    chart.draw_series(dots).map(|_| ()).map_err(DrawError::new)
}

/// Dashed line between two points.
///
/// # Errors
/// Errors of the drawing library.
pub fn dashed(chart: &mut Chart<'_>, from: (f64, f64), to: (f64, f64), color: RGBColor) -> Result<(), DrawError> {
    let series = DashedLineSeries::new([from, to], 6, 5, color.mix(0.75).stroke_width(1));
    chart.draw_series(series).map(|_| ()).map_err(DrawError::new)
}

/// Line style of a colour and a width in pixels.
pub fn stroke(color: RGBColor, width: u32) -> ShapeStyle {
    color.stroke_width(width)
}

/// Light rectangle over two ranges.
///
/// # Errors
/// Errors of the drawing library.
pub fn shade(chart: &mut Chart<'_>, x: Range<f64>, y: Range<f64>, color: RGBColor) -> Result<(), DrawError> {
    let area = Rectangle::new([(x.start, y.start), (x.end, y.end)], color.mix(0.1).filled());
    chart.draw_series([area]).map(|_| ()).map_err(DrawError::new)
}

/// Text at a place in the plot.
///
/// # Errors
/// Errors of the drawing library.
pub fn word(chart: &mut Chart<'_>, text: &str, at: (f64, f64), side: HPos, color: RGBColor) -> Result<(), DrawError> {
    let font = ("sans-serif", LABEL - 1).into_font().color(&color).pos(Pos::new(side, VPos::Top));
    chart.draw_series([Text::new(text.to_owned(), at, font)]).map(|_| ()).map_err(DrawError::new)
}

/// Number of an axis: as few digits as possible, with a typographic minus.
pub fn tick(value: f64) -> String {
    let text = match value.abs() {
        // Rounding error of a sum that should be 0.
        a if a < 1e-9 => "0".to_owned(),
        a if !(1e-3..1e6).contains(&a) => format!("{value:.1e}"),
        _ => {
            let fixed = format!("{value:.5}");
            fixed.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
    };
    text.replace('-', "−")
}

/// Range of the finite values, widened by a share of its width; `None` if there are none.
pub fn range(values: impl IntoIterator<Item = f64>, room: f64) -> Option<Range<f64>> {
    let finite = values.into_iter().filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return None;
    }
    let room = if high > low { room * (high - low) } else { high.abs().max(1.0) };
    Some(low - room..high + room)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_as_short_as_they_can_be() {
        let got = [0.30000000000000004, -10.0, 0.0, -1e-17, 2.5, 0.00002, 1e6].map(tick);
        assert_eq!(got, ["0.3", "−10", "0", "0", "2.5", "2.0e−5", "1.0e6"]);
    }

    #[test]
    fn ranges_hold_their_values() {
        assert_eq!(range([1.0, f64::NAN, 3.0], 0.5), Some(0.0..4.0));
        assert_eq!(range([2.0], 0.1), Some(0.0..4.0));
        assert_eq!(range([f64::NAN], 0.1), None);
    }
}
