//! Frequencies of lines over those predicted: by the stated speed, and by a cage that slips.

use super::density::Density;
use super::observation::{Observation, Power};
use super::settings::LikelihoodSettings;

const SETTINGS: LikelihoodSettings = LikelihoodSettings::DEFAULT;

/// Frequencies of lines over those predicted, less 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stretch {
    /// Of the balls' passes over the outer race: stated speed less slip of the cage.
    pub outer: f64,
    /// Of the inner race: stated speed and what the slip adds.
    pub inner: f64,
}

impl Stretch {
    /// −ln of the prior of a stretch without lines of the inner race.
    pub fn outer_prior(observation: &Observation, outer: f64) -> f64 {
        let std = SETTINGS.slip_std.hypot(observation.speed_std);
        0.5 * ((outer + SETTINGS.slip_mean) / std).powi(2)
    }

    /// −ln of the prior with such lines; `cage_per_shaft` is the order of the cage.
    pub fn prior(self, observation: &Observation, cage_per_shaft: f64) -> f64 {
        // outer = speed − slip, inner = speed + slip times the cage's speed over that of the shaft against it.
        let slip = (self.inner - self.outer) * (1.0 - cage_per_shaft);
        let speed = self.outer + slip;
        let speed_std = observation.speed_std.max(SETTINGS.least_speed_std);
        0.5 * ((slip - SETTINGS.slip_mean) / SETTINGS.slip_std).powi(2) + 0.5 * (speed / speed_std).powi(2)
    }
}

/// Range of a search for a stretch of the lines.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// Middle.
    pub around: f64,
    /// Half width.
    pub reach: f64,
}

/// Bin of a predicted line.
struct LineBin {
    /// Power over the background.
    ratio: f64,
    channel: usize,
    k: usize,
    /// Density of a power to which the line is moved: the background is nearly the same there.
    density: Density,
}

/// Stretch of `lines` over a `background` of each channel that fits a recording best under a `prior`, −ln, and its gain over no
/// lines at all.
pub fn best_stretch(
    observation: &Observation,
    lines: &Power,
    background: &Power,
    range: Range,
    prior: impl Fn(f64) -> f64,
) -> (f64, f64) {
    let mut bins: Vec<LineBin> = Vec::new();
    let mut without_lines: [Vec<f64>; 2] = Default::default();
    for (channel, without) in without_lines.iter_mut().enumerate() {
        let (Some(power), Some(ln_power)) = (&observation.power[channel], &observation.ln_power[channel]) else {
            continue;
        };
        let (predicted, background) = (&lines[channel], &background[channel]);
        let ratio = |k: usize| predicted[k] / background[k];
        let line =
            |k: usize| LineBin { ratio: ratio(k), channel, k, density: Density::new(background[k], predicted[k]) };
        bins.extend(observation.bins().filter(|k| ratio(*k) > SETTINGS.line_ratio).map(line));
        let each = background.iter().zip(power).zip(ln_power);
        *without = each.map(|((background, p), ln)| Density::new(*background, 0.0).neg_log(*p, *ln)).collect();
    }
    bins.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    bins.truncate(SETTINGS.most_lines);
    let last = bins.iter().map(|line| line.k).max().unwrap_or(1) as f64;
    let step = SETTINGS.stretch[1].max(SETTINGS.stretch_bins / last);
    let steps = (range.reach / step).round() as i32;
    let grid: Vec<f64> = (-steps..=steps).map(|n| range.around + f64::from(n) * step).collect();
    let mut gains = vec![0.0; grid.len()];
    for LineBin { k, channel, density, .. } in bins {
        let (Some(power), Some(ln_power)) = (&observation.power[channel], &observation.ln_power[channel]) else {
            continue;
        };
        let moved =
            |to: usize| without_lines[channel].get(to).map_or(0.0, |w| w - density.neg_log(power[to], ln_power[to]));
        // Neighbouring stretches move a line of low frequency to the same bin.
        let (mut at, mut gain) = (k, moved(k));
        for (sum, stretch) in gains.iter_mut().zip(&grid) {
            let to = ((1.0 + stretch) * k as f64).round() as usize;
            if to != at {
                (at, gain) = (to, moved(to));
            }
            *sum += gain;
        }
    }
    let costs = grid.iter().zip(gains).map(|(stretch, gain)| (prior(*stretch) - gain, *stretch));
    let best = costs.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or((range.around, 0.0), |(cost, stretch)| (stretch, -cost))
}
