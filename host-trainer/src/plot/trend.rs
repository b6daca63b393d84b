//! The monitor's statistics over recordings.

use ballrace_core::monitor::{MonitorConfig, Status};
use ballrace_firmware_sim::event::Statistics;
use plotters::prelude::*;

use super::DrawError;

/// One block of the monitor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Index of its recording.
    pub recording: usize,
    /// Status after it.
    pub status: Status,
    /// Statistics after it.
    pub statistics: Statistics,
}

const SIZE: (u32, u32) = (1000, 460);
const DEVIATION: RGBColor = RGBColor(150, 160, 175);
const SLOW: RGBColor = RGBColor(31, 111, 180);
const FAST: RGBColor = RGBColor(196, 92, 12);
const ALARM: RGBColor = RGBColor(214, 39, 40);

/// Deviation, EWMA and CUSUM over the recordings, their limits, and where the status is anomalous.
///
/// # Errors
/// What the drawing library says.
pub fn svg(blocks: &[Block], limits: &MonitorConfig) -> Result<String, DrawError> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(DrawError::of)?;
        let last = blocks.iter().map(|b| b.recording + 1).max().unwrap_or(1);
        let x = |n: usize| place(blocks, n);
        let low = blocks.iter().map(|b| b.statistics.deviation.min(b.statistics.ewma)).fold(-4.0f32, f32::min);
        let high = 2.0 * limits.cusum_limit + 1.0;
        let mut chart = ChartBuilder::on(&root)
            .margin(12)
            .x_label_area_size(36)
            .y_label_area_size(52)
            .build_cartesian_2d(0.0..last as f64 + 0.5, f64::from(low - 0.5)..f64::from(high))
            .map_err(DrawError::of)?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .max_light_lines(0)
            .x_label_formatter(&|v| format!("{v:.0}"))
            .y_label_formatter(&|v| format!("{v:.0}"))
            .x_desc("recording")
            .y_desc("healthy spreads")
            .label_style(("sans-serif", 14))
            .axis_desc_style(("sans-serif", 15))
            .draw()
            .map_err(DrawError::of)?;
        for (start, end) in anomalous_runs(blocks) {
            let area = [(x(start) - 0.5, f64::from(low - 0.5)), (x(end) + 0.5, f64::from(high))];
            chart.draw_series([Rectangle::new(area, ALARM.mix(0.12).filled())]).map_err(DrawError::of)?;
        }
        for (limit, color) in [(limits.ewma_limit, SLOW), (limits.cusum_limit, FAST)] {
            let line = [(0.0, f64::from(limit)), (last as f64 + 0.5, f64::from(limit))];
            chart.draw_series(DashedLineSeries::new(line, 6, 5, color.mix(0.7).into())).map_err(DrawError::of)?;
        }
        type Pick = fn(&Statistics) -> f32;
        let series: [(&str, RGBColor, u32, Pick); 3] = [
            ("deviation of the block", DEVIATION, 1, |s| s.deviation),
            ("EWMA (slow)", SLOW, 2, |s| s.ewma),
            ("CUSUM (fast)", FAST, 2, |s| s.cusum),
        ];
        for (name, color, width, pick) in series {
            let points = blocks.iter().enumerate().map(|(n, b)| (x(n), f64::from(pick(&b.statistics))));
            let points: Vec<_> = points.filter(|(_, y)| y.is_finite()).collect();
            chart
                .draw_series(LineSeries::new(points, color.stroke_width(width)))
                .map_err(DrawError::of)?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.2))
            .label_font(("sans-serif", 14))
            .draw()
            .map_err(DrawError::of)?;
        root.present().map_err(DrawError::of)?;
    }
    Ok(text)
}

/// Where block `n` lies: blocks of one recording share its unit of the axis.
fn place(blocks: &[Block], n: usize) -> f64 {
    let recording = blocks[n].recording;
    let first = blocks[..n].iter().rposition(|b| b.recording != recording).map_or(0, |p| p + 1);
    let count = blocks[first..].iter().take_while(|b| b.recording == recording).count();
    recording as f64 + 0.5 + (n - first + 1) as f64 / count as f64
}

/// First and last block of each run of anomalous status.
fn anomalous_runs(blocks: &[Block]) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (n, block) in blocks.iter().enumerate() {
        if block.status != Status::Anomalous {
            continue;
        }
        match runs.last_mut() {
            Some((_, end)) if *end + 1 == n => *end = n,
            _ => runs.push((n, n)),
        }
    }
    runs
}
