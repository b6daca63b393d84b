//! Limit of the monitor for a stated rate of false alarms, theory (88) and (89).
//!
//! The logarithm of a healthy block's level is noise about a drift. Forty blocks say little about the drift of the next
//! four hundred, so the drift is not estimated but averaged over: each of many machines that the healthy blocks allow runs
//! on, and the limit is the one that so many of them cross in the stated time.

use ballrace_core::monitor::Statistic;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::settings::LimitSettings;

const SETTINGS: LimitSettings = LimitSettings::DEFAULT;

/// Greatest standard deviation of a healthy machine's drift that a limit allows for, natural logarithm of power.
pub const MAX_DRIFT: f64 = SETTINGS.max_drift;

/// Blocks of the healthy machine.
#[derive(Clone, Copy, Debug)]
pub struct HealthyBlocks<'a> {
    /// Natural logarithm of each block's level, in order of time.
    pub log_levels: &'a [f64],
    /// Number of blocks that the centre rests on: those that the model was not fitted to.
    pub held_out: usize,
    /// Least standard deviation of the noise: that of independent Gaussian residuals.
    pub noise_floor: f64,
}

/// Rate of false alarms wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rate {
    /// False alarms a day.
    pub false_alarms_per_day: f64,
    /// Blocks that a day holds.
    pub blocks_per_day: f64,
}

impl Rate {
    /// Mean number of blocks between false alarms.
    pub fn mean_blocks(&self) -> f64 {
        self.blocks_per_day / self.false_alarms_per_day
    }
}

/// Limit with what it rests on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Limit {
    /// Limit of the statistic to both sides, natural logarithm of power.
    pub log_power: f64,
    /// Limit that the rate alone asks for; greater than `log_power` where that stops at what no drift reaches.
    pub asked_log_power: f64,
    /// Standard deviation of the noise from block to block, posterior mean.
    pub spread: f64,
    /// Standard deviation of the drift, posterior mean.
    pub drift: f64,
    /// Number of independent blocks that tell as much of the mean as the healthy ones do.
    pub effective_blocks: f64,
    /// Number of healthy blocks without an alarm that would show the rate with 95 % confidence, free of any model.
    pub needed_blocks: f64,
    /// Whether the limit is beyond the simulated machines, extrapolated by a Gumbel tail as far as drift goes.
    pub extrapolated: bool,
}

/// Limit for a rate. The seed chooses the simulated machines.
pub fn limit(healthy: &HealthyBlocks<'_>, rate: &Rate, ewma_weight: f32, seed: u64) -> Limit {
    let posterior = Posterior::new(healthy);
    let mean_blocks = rate.mean_blocks().max(1.0);
    let n = healthy.log_levels.len();
    let horizon = (SETTINGS.correlation_factor * n).clamp(SETTINGS.min_horizon, SETTINGS.max_horizon);
    let horizon = (horizon as f64).min(mean_blocks.ceil().max(SETTINGS.shortest_horizon as f64)) as usize;
    let run = |k| posterior.machine(healthy, k, horizon, ewma_weight, seed);
    let mut greatest: Vec<f64> = (0..SETTINGS.machines as u64).into_par_iter().map(run).collect();
    greatest.sort_by(f64::total_cmp);
    // Waiting times of rare alarms are exponential: so many machines have none within the horizon.
    let p = (-(horizon as f64) / mean_blocks).exp();
    let seen = 1.0 - SETTINGS.min_exceedances as f64 / SETTINGS.machines as f64;
    let asked = if p <= seen { quantile(&greatest, p) } else { gumbel(&greatest, seen, p) };
    let beyond_drift = SETTINGS.max_drift_deviations * SETTINGS.max_drift;
    let log_power = if p <= seen { asked } else { asked.min(beyond_drift.max(quantile(&greatest, seen))) };
    Limit {
        log_power: log_power.max(posterior.spread),
        asked_log_power: asked.max(posterior.spread),
        spread: posterior.spread,
        drift: posterior.drift,
        effective_blocks: effective(healthy.log_levels),
        needed_blocks: 3.0 * mean_blocks,
        extrapolated: p > seen,
    }
}

/// Quantile of sorted values, linearly interpolated.
fn quantile(sorted: &[f64], p: f64) -> f64 {
    let at = p * (sorted.len() - 1) as f64;
    let (low, share) = (at as usize, at.fract());
    sorted[low] + share * (sorted[(low + 1).min(sorted.len() - 1)] - sorted[low])
}

/// Quantile of the Gumbel distribution through the median and the quantile `seen` of sorted values.
fn gumbel(sorted: &[f64], seen: f64, p: f64) -> f64 {
    let reduced = |p: f64| -(-p.ln()).ln();
    let (median, high) = (quantile(sorted, 0.5), quantile(sorted, seen));
    high + (high - median) * (reduced(p) - reduced(seen)) / (reduced(seen) - reduced(0.5))
}

/// Effective number of blocks by their lag-one correlation ρ, n (1 − ρ) / (1 + ρ).
fn effective(levels: &[f64]) -> f64 {
    let n = levels.len() as f64;
    let mean = levels.iter().sum::<f64>() / n.max(1.0);
    let power = levels.iter().map(|l| (l - mean).powi(2)).sum::<f64>();
    let product = levels.windows(2).map(|w| (w[0] - mean) * (w[1] - mean)).sum::<f64>();
    let rho = if power > 0.0 { (product / power).clamp(0.0, 1.0) } else { 0.0 };
    (n * (1.0 - rho) / (1.0 + rho)).max(n.min(1.0))
}

/// Posterior over the drift's and the noise's standard deviation on a grid, theory (88).
struct Posterior {
    /// Drift, noise and the probability of this cell and all before.
    cells: Vec<(f64, f64, f64)>,
    drift: f64,
    spread: f64,
    /// Correlation time of the drift, blocks.
    time: f64,
}

impl Posterior {
    fn new(healthy: &HealthyBlocks<'_>) -> Self {
        let levels = healthy.log_levels;
        let steps = levels.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>();
        let noise = (steps / (2.0 * (levels.len().max(2) - 1) as f64)).sqrt().max(healthy.noise_floor);
        let time = (SETTINGS.correlation_factor * levels.len().max(1)) as f64;
        let (drifts, noises) = (SETTINGS.drifts, SETTINGS.noises);
        let mut cells: Vec<(f64, f64, f64)> = (0..drifts * noises)
            .map(|cell| {
                let drift = SETTINGS.max_drift * ((cell / noises) as f64 + 0.5) / drifts as f64;
                let share = (cell % noises) as f64 / (noises - 1) as f64;
                let (low, high) = SETTINGS.noise_range;
                (drift, noise * low * (high / low).powf(share), 0.0)
            })
            .collect();
        cells.par_iter_mut().for_each(|(drift, noise, probability)| {
            *probability = log_likelihood(&innovations(levels, step(*drift, time) / *noise), *noise);
        });
        let best = cells.iter().map(|c| c.2).fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = cells.iter().map(|c| (c.2 - best).exp()).sum();
        let (mut sum, mut drift, mut spread) = (0.0, 0.0, 0.0);
        for cell in &mut cells {
            let probability = (cell.2 - best).exp() / total;
            drift += probability * cell.0;
            spread += probability * cell.1;
            sum += probability;
            cell.2 = sum;
        }
        Self { cells, drift, spread: spread.max(healthy.noise_floor), time }
    }

    /// Greatest magnitude of the statistic over a horizon of a machine that the healthy blocks allow.
    fn machine(&self, healthy: &HealthyBlocks<'_>, k: u64, horizon: usize, weight: f32, seed: u64) -> f64 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(k + 1);
        let u: f64 = rng.random();
        let cell = self.cells.partition_point(|c| c.2 < u).min(self.cells.len() - 1);
        let (drift, noise, _) = self.cells[cell];
        let n = healthy.log_levels.len();
        let increment = step(drift, self.time);
        let residuals = standardised(&innovations(healthy.log_levels, increment / noise));
        // The machine's own healthy record first: the centre is its mean, known as well as the held-out blocks say.
        let mut path = Drift { value: drift * normal(&mut rng), decay: (-1.0 / self.time).exp(), increment };
        let mean = (0..n).map(|_| path.next(&mut rng)).sum::<f64>() / n.max(1) as f64;
        let centre = mean + noise * normal(&mut rng) / (healthy.held_out.max(1) as f64).sqrt();
        let mut noises = StationaryBootstrap { residuals: &residuals, at: 0 };
        let mut statistic = Statistic::default();
        (0..horizon)
            .filter_map(|_| {
                let level = path.next(&mut rng) + noise * noises.next(&mut rng) - centre;
                statistic.push(level as f32, weight)
            })
            .fold(0.0, |greatest, ewma| f64::from(ewma.abs()).max(greatest))
    }
}

fn normal(rng: &mut impl Rng) -> f64 {
    rng.sample(StandardNormal)
}

/// Standard deviation of a drift's increment from block to block.
fn step(drift: f64, time: f64) -> f64 {
    drift * (2.0 / time).sqrt()
}

/// Mean-reverting drift, an Ornstein–Uhlenbeck process.
struct Drift {
    value: f64,
    decay: f64,
    increment: f64,
}

impl Drift {
    fn next(&mut self, rng: &mut impl Rng) -> f64 {
        self.value = self.decay * self.value + self.increment * normal(rng);
        self.value
    }
}

/// Innovations of the local-level model with their variances, both in units of the noise's variance; `ratio` is the drift's
/// increment over the noise. Over the healthy blocks, a tenth of its correlation time, the drift is a random walk.
fn innovations(levels: &[f64], ratio: f64) -> Vec<(f64, f64)> {
    let Some((first, rest)) = levels.split_first() else { return Vec::new() };
    let (mut level, mut variance) = (*first, 1.0);
    rest.iter()
        .map(|value| {
            variance += ratio * ratio;
            let (innovation, of) = (value - level, variance + 1.0);
            level += variance / of * innovation;
            variance /= of;
            (innovation, of)
        })
        .collect()
}

fn log_likelihood(innovations: &[(f64, f64)], noise: f64) -> f64 {
    // Scale-free prior of the noise, flat in its logarithm as the grid is; flat prior of the drift.
    innovations.iter().map(|(e, f)| -0.5 * (e * e / (f * noise * noise) + (f * noise * noise).ln())).sum()
}

/// Innovations of mean 0 and standard deviation 1: they keep the heavy tails and the short correlation of the blocks.
fn standardised(innovations: &[(f64, f64)]) -> Vec<f64> {
    if innovations.len() < SETTINGS.min_residuals {
        return Vec::new();
    }
    let n = innovations.len() as f64;
    let mut values: Vec<f64> = innovations.iter().map(|(e, f)| e / f.sqrt()).collect();
    let mean = values.iter().sum::<f64>() / n;
    let spread = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
    if spread <= 0.0 {
        return Vec::new();
    }
    values.iter_mut().for_each(|v| *v = (*v - mean) / spread);
    values
}

/// Stationary bootstrap of residuals (Politis, Romano 1994), or Gaussian noise where there are too few.
struct StationaryBootstrap<'a> {
    residuals: &'a [f64],
    at: usize,
}

impl StationaryBootstrap<'_> {
    fn next(&mut self, rng: &mut impl Rng) -> f64 {
        let n = self.residuals.len();
        if n == 0 {
            return normal(rng);
        }
        self.at = if rng.random_range(0..SETTINGS.mean_run) == 0 { rng.random_range(0..n) } else { (self.at + 1) % n };
        self.residuals[self.at]
    }
}

#[cfg(test)]
mod tests;
