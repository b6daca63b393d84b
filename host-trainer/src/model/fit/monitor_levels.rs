//! Healthy level of a model's residual by the device's own monitor, theory (85) to (87).

use ballrace_core::input_check::ScreenConfig;
use ballrace_core::math;
use ballrace_core::monitor::MonitorConfig;
use ballrace_firmware_sim::event::Event;
use ballrace_firmware_sim::runner::{Recording, Runner};
use ballrace_firmware_sim::source::in_memory;

use super::limits::{HealthyBlocks, Rate, limit};
use super::report::MonitorReport;
use super::settings::{LimitSettings, MonitorSettings};
use super::single_fit::{SingleFit, Split};
use super::{FitConfig, FitError, score};
use crate::model::OwnedModel;
use crate::recording::input::Series;

const SETTINGS: MonitorSettings = MonitorSettings::DEFAULT;
const SECONDS_PER_DAY: f64 = 86_400.0;

/// Model with its monitor calibrated on the healthy recordings.
///
/// # Errors
/// [`FitError::Diverged`] if the calibrated parts are no valid model.
pub fn monitor(
    once: &SingleFit,
    split: &Split,
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
    let screen = ScreenConfig { full_scale: full_scale(config, recordings), stuck_after };

    let mut parts = once.parts.clone();
    parts.screen = screen;
    parts.residual_spread = score::residual_spread(&once.model.view(), recordings);
    parts.monitor = MonitorConfig::new(block, 0.0, 1.0);
    let provisional = parts.assemble().map_err(FitError::Diverged)?;
    let mut blocks = blocks(&provisional, recordings, sample_rate_hz);
    mark_held_out(&mut blocks, split);
    let shift = shift(&blocks);
    let levels: Vec<f64> = blocks.iter().map(|b| b.log_level + if b.held_out { 0.0 } else { shift }).collect();
    let count = levels.len().max(1) as f64;
    let centre = levels.iter().sum::<f64>() / count;
    let held_out = blocks.iter().filter(|b| b.held_out).count();
    let rate = Rate {
        false_alarms_per_day: config.false_alarms_per_day,
        blocks_per_day: match config.interval_s {
            Some(interval) => SECONDS_PER_DAY / interval * (levels.len() as f64 / recordings.len() as f64).max(1.0),
            None => SECONDS_PER_DAY * sample_rate_hz / f64::from(block),
        },
    };
    // Never below what independent Gaussian residuals would scatter.
    let noise_floor = (2.0 / (f64::from(block) * config.spec.dimension as f64)).sqrt();
    let healthy = HealthyBlocks { log_levels: &levels, held_out, noise_floor };
    let weight = LimitSettings::DEFAULT.ewma_weight;
    let limit = limit(&healthy, &rate, weight, config.seed);
    parts.monitor = MonitorConfig {
        ewma_weight: weight,
        limit: (limit.log_power / limit.spread) as f32,
        false_alarms_per_day: rate.false_alarms_per_day as f32,
        blocks_per_day: rate.blocks_per_day as f32,
        healthy_blocks: levels.len() as u32,
        ..MonitorConfig::new(block, centre as f32, limit.spread as f32)
    };
    let model = parts.assemble().map_err(FitError::Diverged)?;
    let report = MonitorReport {
        block,
        healthy_blocks: levels.len(),
        held_out_blocks: held_out,
        healthy_mean: centre.exp(),
        healthy_spread: limit.spread,
        held_out_shift: shift,
        false_alarms_per_day: rate.false_alarms_per_day,
        blocks_per_day: rate.blocks_per_day,
        limit,
    };
    Ok((model, report))
}

/// A block of the healthy machine.
struct HealthyBlock {
    recording: usize,
    log_level: f64,
    held_out: bool,
}

fn blocks(model: &OwnedModel, recordings: &[Series], sample_rate_hz: f64) -> Vec<HealthyBlock> {
    let model = model.view();
    let mut scratch = vec![0.0; Runner::scratch_len(&model)];
    let mut runner = Runner::new(&model, &mut scratch).expect("virtual states, and as much scratch as it asks for");
    let mut blocks = Vec::new();
    for (index, series) in recordings.iter().enumerate() {
        let recording = Recording { name: &series.name, sample_rate_hz };
        runner.run(&recording, in_memory(&series.samples), |event| {
            if let Event::Block(block) = event {
                let log_level = f64::from(math::ln(block.statistics.level.max(f32::MIN_POSITIVE)));
                blocks.push(HealthyBlock { recording: index, log_level, held_out: false });
            }
        });
    }
    blocks.retain(|b| b.log_level.is_finite());
    blocks
}

/// Marks the blocks of held-out recordings, or of the last fifth of the only one.
fn mark_held_out(blocks: &mut [HealthyBlock], split: &Split) {
    if split.within {
        let first = (blocks.len() * 4).div_ceil(5);
        blocks.iter_mut().skip(first).for_each(|b| b.held_out = true);
        return;
    }
    blocks.iter_mut().for_each(|b| b.held_out = split.held_out_places.contains(&b.recording));
}

/// How far held-out blocks are above the others, never below 0: a model leaves less of what it was fitted to, and the device
/// will see only what is new. Each held-out run of blocks is compared with its neighbours, so that a drift cancels.
fn shift(blocks: &[HealthyBlock]) -> f64 {
    let mean = |blocks: &[HealthyBlock]| blocks.iter().map(|b| b.log_level).sum::<f64>() / blocks.len() as f64;
    let runs: Vec<&[HealthyBlock]> = blocks.chunk_by(|a, b| a.held_out == b.held_out).collect();
    let (mut sum, mut weight) = (0.0, 0.0);
    for (n, run) in runs.iter().enumerate().filter(|(_, run)| run[0].held_out) {
        let near = |run: &&[HealthyBlock], from_end: bool, count: usize| {
            let part = if from_end { &run[run.len().saturating_sub(count)..] } else { &run[..count.min(run.len())] };
            mean(part)
        };
        let before = n.checked_sub(1).and_then(|n| runs.get(n)).map(|r| near(r, true, run.len()));
        let after = runs.get(n + 1).map(|r| near(r, false, run.len()));
        let neighbours = match (before, after) {
            (Some(before), Some(after)) => 0.5 * (before + after),
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => continue,
        };
        sum += run.len() as f64 * (mean(run) - neighbours);
        weight += run.len() as f64;
    }
    if weight > 0.0 { (sum / weight).max(0.0) } else { 0.0 }
}

/// Full scale of the sensor, m/s²: as stated, else far above what any machine does, so that only a flipped bit reaches it.
fn full_scale(config: &FitConfig, recordings: &[Series]) -> f32 {
    if config.full_scale > 0.0 {
        return config.full_scale;
    }
    let greatest =
        recordings.iter().flat_map(|s| &s.samples).fold(0.0f32, |greatest, sample| greatest.max(sample.abs()));
    (SETTINGS.full_scale_factor * greatest).min(f32::MAX)
}

fn longest_equal_run(samples: &[f32]) -> u32 {
    samples.chunk_by(|a, b| a == b).map(|run| run.len() as u32).max().unwrap_or(0)
}
