//! Monitor of the residuals, theory (85) to (89): healthy, anomalous, or blind.
//!
//! The residual of each derivative is divided by its healthy spread; its square, averaged over the
//! derivatives and over a block of samples, is the block's level, 1 for a healthy machine. The level's
//! distance from the healthy mean in healthy spreads, u, feeds a slow statistic (EWMA, Roberts 1959)
//! and a fast one (CUSUM, Page 1954). A block in which either is over its limit votes; k votes among
//! the last n blocks raise the anomaly, and only n blocks in a row below the release limits clear it.
//!
//! A level far *below* the healthy one (a loose sensor, a lost gain) is an anomaly as well, so both
//! statistics are two-sided. A block with too few good samples has no level and no vote, and the status becomes
//! [`Status::Blind`].

use serde::{Deserialize, Serialize};

/// Greatest number of blocks that votes are counted over.
pub const MAX_VOTES: u32 = 32;
/// Clamp of u, so that one block can neither dominate the slow statistic nor overflow.
const U_LIMIT: f32 = 10.0;
/// Clamp of a squared normalised residual, so that a block's sum cannot overflow.
const SQUARE_LIMIT: f32 = 1e12;

/// Settings of the monitor. The units of the limits are healthy spreads of a block's level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MonitorConfig {
    /// Evaluated samples in a block.
    pub block: u32,
    /// Mean level of healthy blocks.
    pub healthy_mean: f32,
    /// Standard deviation of the level of healthy blocks.
    pub healthy_spread: f32,
    /// Weight of the newest block in the EWMA, 0 to 1.
    pub ewma_weight: f32,
    /// Limit of the EWMA.
    pub ewma_limit: f32,
    /// Slack of the CUSUM: deviation that counts as healthy drift.
    pub cusum_slack: f32,
    /// Limit of the CUSUM.
    pub cusum_limit: f32,
    /// Votes k among the last n blocks that raise the anomaly.
    pub votes: u32,
    /// Number n of blocks that votes are counted over.
    pub of_blocks: u32,
    /// Share of the limits below which both statistics must stay for n blocks to clear the anomaly.
    pub release: f32,
}

impl MonitorConfig {
    /// Textbook settings for a block length and a healthy level (Montgomery, *Introduction to
    /// Statistical Quality Control*: EWMA λ = 0.2 and limit near 3), but a CUSUM slack of 2: the textbook's 0.5 is for
    /// uncorrelated levels, and those of a machine are correlated from block to block.
    pub const fn new(block: u32, healthy_mean: f32, healthy_spread: f32) -> Self {
        Self {
            block,
            healthy_mean,
            healthy_spread,
            ewma_weight: 0.2,
            ewma_limit: 3.0,
            cusum_slack: 2.0,
            cusum_limit: 8.0,
            votes: 2,
            of_blocks: 3,
            release: 0.5,
        }
    }

    /// Whether every number is usable.
    pub fn is_valid(&self) -> bool {
        let positive = [self.healthy_spread, self.ewma_weight, self.ewma_limit, self.cusum_limit];
        self.block > 0
            && positive.iter().all(|v| v.is_finite() && *v > 0.0)
            && self.ewma_weight <= 1.0
            && [self.healthy_mean, self.cusum_slack].iter().all(|v| v.is_finite() && *v >= 0.0)
            && self.release > 0.0
            && self.release <= 1.0
            && (1..=self.of_blocks).contains(&self.votes)
            && self.of_blocks <= MAX_VOTES
    }
}

/// Status of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// Too few blocks so far.
    Starting,
    /// Residual of the healthy machine.
    Healthy,
    /// Residual that differs from the healthy machine's.
    Anomalous,
    /// Too many broken samples.
    Blind,
}

/// Statistics after a block.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BlockReport {
    /// Blocks so far, this one included; saturating.
    pub block: u32,
    /// Mean squared normalised residual; NaN for a blind block.
    pub level: f32,
    /// Distance from the healthy mean in healthy spreads, clamped to ±10; NaN for a blind block.
    pub deviation: f32,
    /// Slow statistic, EWMA of the deviation.
    pub ewma: f32,
    /// Fast statistic, CUSUM: the larger of the sums above and below.
    pub cusum: f32,
    /// Whether this block votes for an anomaly.
    pub vote: bool,
    /// Status after this block.
    pub status: Status,
    /// Status before this block; a change is an event.
    pub was: Status,
}

/// Residual monitor; a few dozen bytes.
#[derive(Clone, Debug)]
pub struct Monitor {
    config: MonitorConfig,
    sum: f32,
    good: u32,
    broken: u32,
    /// Good samples that the model could not be evaluated for.
    idle: u32,
    blocks: u32,
    ewma: f32,
    above: f32,
    below: f32,
    /// One bit for each block with a level, newest lowest.
    votes: u32,
    /// Blocks with a level since the start or since blindness, saturating at [`MAX_VOTES`].
    seen: u32,
    /// Blocks in a row below the release limits.
    calm: u32,
    anomalous: bool,
    status: Status,
}

impl Monitor {
    /// Monitor before the first sample.
    pub fn new(config: MonitorConfig) -> Self {
        Self {
            config,
            sum: 0.0,
            good: 0,
            broken: 0,
            idle: 0,
            blocks: 0,
            ewma: 0.0,
            above: 0.0,
            below: 0.0,
            votes: 0,
            seen: 0,
            calm: 0,
            anomalous: false,
            status: Status::Starting,
        }
    }

    /// Status after the last block.
    pub fn status(&self) -> Status {
        self.status
    }

    /// Takes the normalised residuals of a sample; returns a report at the end of a block. A residual that
    /// is not finite counts as a broken sample.
    pub fn residual(&mut self, residuals: impl ExactSizeIterator<Item = f32>) -> Option<BlockReport> {
        let count = residuals.len().max(1) as f32;
        let sum = residuals.map(square).sum::<f32>();
        if !sum.is_finite() {
            return self.broken(1);
        }
        self.sum += sum / count;
        self.good = self.good.saturating_add(1);
        if self.good >= self.config.block { Some(self.close()) } else { None }
    }

    /// Takes samples that could not be evaluated; returns a report once they are a block.
    pub fn broken(&mut self, count: u32) -> Option<BlockReport> {
        self.broken = self.broken.saturating_add(count);
        self.close_where_lost()
    }

    /// Takes a good sample that the model was not evaluated for while the differences fill: a sensor that breaks again
    /// before they have filled must not keep the last status. Returns a report once such samples are a block.
    pub fn idle(&mut self) -> Option<BlockReport> {
        self.idle = self.idle.saturating_add(1);
        self.close_where_lost()
    }

    fn lost(&self) -> u32 {
        self.broken.saturating_add(self.idle)
    }

    fn close_where_lost(&mut self) -> Option<BlockReport> {
        if self.lost() >= self.config.block { Some(self.close()) } else { None }
    }

    /// Discards the open block's residuals as those of broken samples.
    pub fn discard(&mut self) {
        self.broken = self.broken.saturating_add(self.good);
        self.good = 0;
        self.sum = 0.0;
    }

    /// Ends a recording: a block at least half full is closed, a smaller one stays open.
    pub fn end_of_recording(&mut self) -> Option<BlockReport> {
        let held = self.good.saturating_add(self.lost());
        if held > 0 && held >= self.config.block.div_ceil(2) { Some(self.close()) } else { None }
    }

    fn close(&mut self) -> BlockReport {
        let blind = self.lost() >= self.good;
        let level = if blind { f32::NAN } else { self.sum / self.good as f32 };
        self.sum = 0.0;
        self.good = 0;
        self.broken = 0;
        self.idle = 0;
        self.blocks = self.blocks.saturating_add(1);
        let was = self.status;
        let (deviation, vote) = if blind {
            // The anomaly and its statistics persist.
            self.seen = 0;
            self.calm = 0;
            self.status = Status::Blind;
            (f32::NAN, false)
        } else {
            let deviation = self.deviation(level);
            (deviation, self.judge(deviation))
        };
        BlockReport {
            block: self.blocks,
            level,
            deviation,
            ewma: self.ewma,
            cusum: self.above.max(self.below),
            vote,
            status: self.status,
            was,
        }
    }

    fn deviation(&self, level: f32) -> f32 {
        let u = (level - self.config.healthy_mean) / self.config.healthy_spread;
        u.clamp(-U_LIMIT, U_LIMIT)
    }

    fn judge(&mut self, u: f32) -> bool {
        let c = &self.config;
        self.ewma += c.ewma_weight * (u - self.ewma);
        // Bounded above, or a long anomaly takes as long to clear. Not `clamp`, which panics for a bound below 0.
        let bound = 2.0 * c.cusum_limit;
        self.above = (self.above + u - c.cusum_slack).max(0.0).min(bound);
        self.below = (self.below - u - c.cusum_slack).max(0.0).min(bound);
        let cusum = self.above.max(self.below);
        let vote = self.ewma.abs() > c.ewma_limit || cusum > c.cusum_limit;
        let calm = self.ewma.abs() < c.release * c.ewma_limit && cusum < c.release * c.cusum_limit;
        self.votes = (self.votes << 1) | u32::from(vote);
        self.calm = if calm { self.calm.saturating_add(1) } else { 0 };
        self.seen = (self.seen + 1).min(MAX_VOTES);
        let recent = self.votes & (u32::MAX >> (MAX_VOTES - c.of_blocks.clamp(1, MAX_VOTES)));
        if recent.count_ones() >= c.votes {
            self.anomalous = true;
        } else if self.calm >= c.of_blocks {
            self.anomalous = false;
        }
        self.status = if self.anomalous {
            Status::Anomalous
        } else if self.seen < c.of_blocks {
            Status::Starting
        } else {
            Status::Healthy
        };
        vote
    }
}

/// Square of a residual, limited; NaN where it is not finite. Not `min`, which calls a function where there is no instruction.
fn square(residual: f32) -> f32 {
    let square = residual * residual;
    if square <= SQUARE_LIMIT {
        square
    } else if residual.is_finite() {
        SQUARE_LIMIT
    } else {
        f32::NAN
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn monitor() -> Monitor {
        Monitor::new(MonitorConfig::new(10, 1.0, 0.1))
    }

    /// Feeds blocks of constant residual √level; statuses after each block.
    fn feed(m: &mut Monitor, levels: impl IntoIterator<Item = f32>) -> Vec<Status> {
        let mut statuses = Vec::new();
        for level in levels {
            for _ in 0..10 {
                let r = crate::math::sqrt(level);
                if let Some(report) = m.residual([r, -r].into_iter()) {
                    statuses.push(report.status);
                }
            }
        }
        statuses
    }

    #[test]
    fn healthy_stays_healthy() {
        let mut m = monitor();
        let statuses = feed(&mut m, (0..500).map(|i| 1.0 + 0.15 * (i as f32 * 0.9).sin()));
        assert_eq!(statuses[..2], [Status::Starting; 2]);
        assert!(statuses[2..].iter().all(|s| *s == Status::Healthy));
    }

    #[test]
    fn rises_on_either_side_and_clears_only_after_calm() {
        for wrong in [1.6, 0.2] {
            let mut m = monitor();
            feed(&mut m, [1.0; 20]);
            let raised = feed(&mut m, [wrong; 10]);
            assert_eq!(raised[0], Status::Healthy, "one block is not enough");
            assert_eq!(*raised.last().unwrap(), Status::Anomalous);
            let cleared = feed(&mut m, [1.0; 30]);
            assert_eq!(cleared[..3], [Status::Anomalous; 3], "hysteresis");
            assert_eq!(*cleared.last().unwrap(), Status::Healthy);
        }
    }

    #[test]
    fn a_single_wild_block_does_not_raise() {
        let mut m = monitor();
        feed(&mut m, [1.0; 20]);
        let statuses = feed(&mut m, [1e9, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
        assert!(statuses.iter().all(|s| *s == Status::Healthy), "{statuses:?}");
    }

    #[test]
    fn broken_samples_blind_and_never_read_as_healthy() {
        let mut m = monitor();
        feed(&mut m, [1.0; 20]);
        let report = m.broken(10).unwrap();
        assert_eq!((report.status, report.was), (Status::Blind, Status::Healthy));
        assert!(report.level.is_nan());
        let after = feed(&mut m, [1.0; 3]);
        assert_eq!(after, [Status::Starting, Status::Starting, Status::Healthy]);
        // Nearly all NaN residuals: blind, and the sums are clean afterwards.
        for _ in 0..10 {
            m.residual([f32::NAN].into_iter());
        }
        assert_eq!(m.status(), Status::Blind);
        assert_eq!(*feed(&mut m, [1.0; 3]).last().unwrap(), Status::Healthy);
        for _ in 0..10 {
            m.residual([f32::INFINITY].into_iter());
        }
        assert_eq!(m.status(), Status::Blind);
        assert_eq!(*feed(&mut m, [1.0; 3]).last().unwrap(), Status::Healthy);
    }

    #[test]
    fn an_anomaly_is_remembered_through_blindness() {
        let mut m = monitor();
        feed(&mut m, [1.0; 5]);
        feed(&mut m, [3.0; 5]);
        m.broken(10);
        assert_eq!(m.status(), Status::Blind);
        // Healthy blocks alone would read as starting.
        assert_eq!(feed(&mut m, [1.0]), [Status::Anomalous]);
    }

    #[test]
    fn wrong_configurations_are_told() {
        let good = MonitorConfig::new(10, 1.0, 0.1);
        assert!(good.is_valid());
        for bad in [
            MonitorConfig { block: 0, ..good },
            MonitorConfig { healthy_spread: 0.0, ..good },
            MonitorConfig { healthy_mean: f32::NAN, ..good },
            MonitorConfig { votes: 4, ..good },
            MonitorConfig { of_blocks: 33, ..good },
            MonitorConfig { ewma_weight: 1.5, ..good },
        ] {
            assert!(!bad.is_valid(), "{bad:?}");
        }
    }
}
