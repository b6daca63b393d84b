//! Healthy level of a model's residual by the device's own monitor, theory (85) and (86).

use ballrace_core::input_check::ScreenConfig;
use ballrace_core::monitor::MonitorConfig;
use ballrace_firmware_sim::event::Event;
use ballrace_firmware_sim::runner::{Recording, Runner};
use ballrace_firmware_sim::source::in_memory;

use super::report::MonitorReport;
use super::settings::MonitorSettings;
use super::single_fit::SingleFit;
use super::{FitConfig, FitError, score};
use crate::model::OwnedModel;
use crate::recording::input::Series;

const SETTINGS: MonitorSettings = MonitorSettings::DEFAULT;

/// Model with its monitor calibrated on the healthy recordings.
///
/// # Errors
/// [`FitError::Diverged`] if the calibrated parts are no valid model.
pub fn monitor(
    once: &SingleFit,
    recordings: &[Series],
    sample_rate_hz: f64,
    config: &FitConfig,
) -> Result<(OwnedModel, MonitorReport), FitError> {
    let warm_up = config.spec.warm_up();
    let rows: usize = recordings.iter().map(|s| (s.samples.len() + 1).saturating_sub(warm_up)).sum();
    let block = config.block.unwrap_or_else(|| {
        let usual = (sample_rate_hz / SETTINGS.blocks_per_second) as usize;
        usual.min(rows / SETTINGS.min_blocks).max(SETTINGS.min_block) as u32
    });
    let longest_run = recordings.iter().map(|s| longest_equal_run(&s.samples)).max().unwrap_or(1);
    // Bounded by the block, or a stretch of equal samples in the healthy recordings would switch the check off.
    let shortest = SETTINGS.min_stuck_run;
    let longest = (block / SETTINGS.stuck_block_divisor).max(shortest);
    let stuck_after = (SETTINGS.stuck_run_factor * longest_run).max(shortest).min(longest);
    let screen = ScreenConfig { full_scale: config.full_scale, stuck_after };

    let mut parts = once.parts.clone();
    parts.screen = screen;
    parts.residual_spread = score::residual_spread(&once.model.view(), recordings);
    parts.monitor = MonitorConfig::new(block, 1.0, 1.0);
    let provisional = parts.assemble().map_err(FitError::Diverged)?;
    let levels = levels(&provisional, recordings, sample_rate_hz);
    let count = levels.len().max(1) as f64;
    let mean = levels.iter().sum::<f64>() / count;
    let variance = levels.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
    // Never below what independent Gaussian residuals would scatter.
    let floor = mean * (2.0 / (f64::from(block) * config.spec.dimension as f64)).sqrt();
    let spread = variance.sqrt().max(floor);
    parts.monitor = MonitorConfig::new(block, mean as f32, spread as f32);
    let model = parts.assemble().map_err(FitError::Diverged)?;
    let report = MonitorReport { block, healthy_blocks: levels.len(), healthy_mean: mean, healthy_spread: spread };
    Ok((model, report))
}

fn levels(model: &OwnedModel, recordings: &[Series], sample_rate_hz: f64) -> Vec<f64> {
    let model = model.view();
    let mut scratch = vec![0.0; Runner::scratch_len(&model)];
    let mut runner = Runner::new(&model, &mut scratch).expect("virtual states, and as much scratch as it asks for");
    let mut levels = Vec::new();
    for series in recordings {
        let recording = Recording { name: &series.name, sample_rate_hz };
        runner.run(&recording, in_memory(&series.samples), |event| {
            if let Event::Block(block) = event {
                levels.push(f64::from(block.statistics.level));
            }
        });
    }
    levels.retain(|l| l.is_finite());
    levels
}

fn longest_equal_run(samples: &[f32]) -> u32 {
    samples.chunk_by(|a, b| a == b).map(|run| run.len() as u32).max().unwrap_or(0)
}
