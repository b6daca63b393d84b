//! Statistics of the monitor over recordings.

use ballrace_core::monitor::{MonitorConfig, Status};
use ballrace_firmware_sim::event::Statistics;
use plotters::style::text_anchor::HPos;

use super::DrawError;
use super::settings::PlotSettings;
use super::style::{self, ALARM, EARLY, INK, MEASURED};
use super::time_axis::TimeAxis;
use crate::model::replay::Block;

const SETTINGS: PlotSettings = PlotSettings::DEFAULT;

/// Picture of deviation and EWMA with its limit; anomalous stretches are shaded, and `mark` labels the start of one
/// recording.
///
/// # Errors
/// Errors of the drawing library.
pub fn svg(
    blocks: &[Block],
    limits: &MonitorConfig,
    time: &TimeAxis,
    mark: Option<(usize, &str)>,
) -> Result<String, DrawError> {
    let places = places(blocks, time);
    let (start, end) = (time.range().start, time.range().end);
    let all = || blocks.iter().flat_map(|b| [b.statistics.deviation, b.statistics.ewma]);
    let low = f64::from(all().fold(-1.2 * limits.limit, f32::min) - 0.5);
    let high = f64::from(all().fold(1.2 * limits.limit, f32::max) + 0.5);
    style::picture(SETTINGS.trend_height, |area| {
        let legend = [("deviation of a block", MEASURED), ("EWMA", EARLY), ("status anomalous", ALARM)];
        let mut chart = style::chart_over_time(area, time, low..high, "healthy standard deviations", &legend)?;
        for (first, last) in anomalous_runs(blocks) {
            let at = |n: usize| places.get(n).copied().unwrap_or(end);
            // From the block that raised the alarm to the one that cleared it.
            style::shade(&mut chart, at(first)..places.get(last + 1).copied().unwrap_or(end), low..high, ALARM)?;
        }
        for limit in [limits.limit, -limits.limit] {
            style::dashed(&mut chart, (start, limit.into()), (end, limit.into()), EARLY)?;
        }
        type Pick = fn(&Statistics) -> f32;
        let series: [(_, u32, Pick); 2] = [(MEASURED, 1, |s| s.deviation), (EARLY, 2, |s| s.ewma)];
        for (color, width, pick) in series {
            let points = places.iter().zip(blocks).map(|(x, b)| (*x, f64::from(pick(&b.statistics))));
            style::line(&mut chart, points, style::stroke(color, width))?;
        }
        let Some((recording, words)) = mark else { return Ok(()) };
        let x = time.at(recording, 0.0);
        style::dashed(&mut chart, (x, low), (x, high), INK)?;
        // On the side with room for it.
        let (side, gap) = if x > 0.5 * (start + end) { (HPos::Right, -0.006) } else { (HPos::Left, 0.006) };
        style::word(&mut chart, words, (x + gap * (end - start), high - 0.03 * (high - low)), side, INK)
    })
}

/// End of each block on the axis: the blocks of a recording share its length.
fn places(blocks: &[Block], time: &TimeAxis) -> Vec<f64> {
    blocks
        .chunk_by(|a, b| a.recording == b.recording)
        .flat_map(|run| run.iter().enumerate().map(|(k, b)| time.at(b.recording, (k + 1) as f64 / run.len() as f64)))
        .collect()
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
