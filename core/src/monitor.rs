//! Monitor of the residuals, theory (85) to (89): healthy, anomalous, or blind.
//!
//! The residual of each derivative is divided by its healthy spread; its square, averaged over the
//! derivatives and over a block of samples, is the block's level. The logarithm of the level has a distance u from its
//! healthy centre, in healthy spreads. The median of the last three u, so that a single wild block does nothing, feeds an
//! EWMA (Roberts 1959). Beyond its limit it raises the anomaly, and only blocks in a row within a share of the limit
//! clear it. The fit sets the limit for a stated rate of false alarms, which the model carries.
//!
//! A level far *below* the healthy one (a loose sensor, a lost gain) is an anomaly as well, so the limit is two-sided. A
//! block with too few good samples has no level, and the status becomes [`Status::Blind`]; but where most of its samples
//! are beyond the sensor's full scale, the vibration is, and the block is far beyond the limit.

use serde::Serialize;

use crate::math;

/// Greatest number of blocks in a row that clear an anomaly.
pub const MAX_CALM: u32 = 32;
/// Clamp of a squared normalised residual, so that a block's sum cannot overflow.
const SQUARE_LIMIT: f32 = 1e12;
/// Greatest magnitude of the healthy centre: beyond the logarithm of any `f32`.
const MAX_CENTRE: f32 = 1e3;
/// Least healthy spread: with the greatest centre no deviation overflows, so the EWMA stays finite.
const MIN_SPREAD: f32 = 1e-6;
/// Blocks of the running median, and of the start.
const MEDIAN: u32 = 3;
/// EWMA after one overloaded block, in limits.
const OVERLOAD: f32 = 2.0;

/// Settings of the monitor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonitorConfig {
    /// Evaluated samples in a block.
    pub block: u32,
    /// Centre of the natural logarithm of a healthy block's level.
    pub healthy_centre: f32,
    /// Standard deviation of that logarithm from block to block.
    pub healthy_spread: f32,
    /// Weight of the newest block in the EWMA, 0 to 1.
    pub ewma_weight: f32,
    /// Limit of the EWMA to both sides, healthy spreads.
    pub limit: f32,
    /// Share of the limit within which the EWMA must stay to clear the anomaly.
    pub release: f32,
    /// Blocks in a row within that share that clear the anomaly.
    pub calm_blocks: u32,
    /// False alarms a day for which the limit was set; 0 where none was stated.
    pub false_alarms_per_day: f32,
    /// Blocks that a day holds; 0 where unstated.
    pub blocks_per_day: f32,
    /// Healthy blocks that the limit rests on; 0 where unstated.
    pub healthy_blocks: u32,
}

impl MonitorConfig {
    /// Settings of a healthy centre and spread of the logarithm of the level, with a limit of 3 spreads and no stated rate.
    pub const fn new(block: u32, healthy_centre: f32, healthy_spread: f32) -> Self {
        Self {
            block,
            healthy_centre,
            healthy_spread,
            ewma_weight: 0.3,
            limit: 3.0,
            release: 0.5,
            calm_blocks: 3,
            false_alarms_per_day: 0.0,
            blocks_per_day: 0.0,
            healthy_blocks: 0,
        }
    }

    /// Settings from the mean and standard deviation of the levels themselves, which models of format versions 1 to 3
    /// hold: ln m, and s / m by the delta method. A mean that is not positive gives settings that are not valid.
    pub fn from_levels(block: u32, mean: f32, spread: f32) -> Self {
        Self::new(block, math::ln(mean), spread / mean)
    }

    /// Whether every number is usable.
    pub fn is_valid(&self) -> bool {
        let positive = [self.healthy_spread, self.ewma_weight, self.limit, self.release];
        let stated = [self.false_alarms_per_day, self.blocks_per_day];
        self.block > 0
            && positive.iter().all(|v| v.is_finite() && *v > 0.0)
            && stated.iter().all(|v| v.is_finite() && *v >= 0.0)
            && self.healthy_centre.abs() <= MAX_CENTRE
            && self.healthy_spread >= MIN_SPREAD
            && self.ewma_weight <= 1.0
            && self.release <= 1.0
            && (1..=MAX_CALM).contains(&self.calm_blocks)
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
    /// Mean squared normalised residual; NaN for a blind or an overloaded block.
    pub level: f32,
    /// Distance of the level's logarithm from its healthy centre in healthy spreads, not clamped; NaN for a blind block,
    /// one that alone takes the EWMA beyond its limit for an overloaded block.
    pub deviation: f32,
    /// EWMA of the running median of the deviation, not clamped.
    pub ewma: f32,
    /// Whether the EWMA is beyond its limit.
    pub beyond: bool,
    /// Status after this block.
    pub status: Status,
    /// Status before this block; a change is an event.
    pub was: Status,
}

/// EWMA of the running median of three, the statistic that the limit judges. The fit simulates it to set the limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistic {
    /// Last two values, the newest first.
    last: [f32; 2],
    ewma: f32,
    /// Values since the start or the last restart, at most [`MEDIAN`].
    seen: u32,
}

impl Statistic {
    /// Takes a value with the weight of the EWMA; the EWMA, or `None` before the third value.
    pub fn push(&mut self, u: f32, weight: f32) -> Option<f32> {
        let [first, second] = self.last;
        self.last = [u, first];
        self.seen = (self.seen + 1).min(MEDIAN);
        if self.seen < MEDIAN {
            return None;
        }
        let median = u.min(first).max(u.max(first).min(second));
        self.ewma += weight * (median - self.ewma);
        Some(self.ewma)
    }

    /// EWMA after the last value.
    pub fn ewma(&self) -> f32 {
        self.ewma
    }

    /// Starts the median anew, as after blindness; the EWMA persists.
    pub fn restart(&mut self) {
        self.seen = 0;
    }
}

/// Residual monitor; a few dozen bytes.
#[derive(Clone, Debug)]
pub struct Monitor {
    config: MonitorConfig,
    sum: f32,
    good: u32,
    broken: u32,
    /// Those of the broken samples that are at or beyond full scale.
    overload: u32,
    /// Good samples that the model could not be evaluated for.
    idle: u32,
    blocks: u32,
    statistic: Statistic,
    /// Blocks in a row within the release limit.
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
            overload: 0,
            idle: 0,
            blocks: 0,
            statistic: Statistic::default(),
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

    /// Takes a sample at or beyond the sensor's full scale; returns a report once such samples are a block.
    pub fn overload(&mut self) -> Option<BlockReport> {
        self.overload = self.overload.saturating_add(1);
        self.broken(1)
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
        let lost = self.lost();
        let overloaded = self.overload > self.good.saturating_add(lost) / 2;
        let blind = lost >= self.good;
        let level = if blind { f32::NAN } else { self.sum / self.good as f32 };
        self.sum = 0.0;
        self.good = 0;
        self.broken = 0;
        self.overload = 0;
        self.idle = 0;
        self.blocks = self.blocks.saturating_add(1);
        let was = self.status;
        let (deviation, beyond) = if overloaded {
            let deviation = OVERLOAD * self.config.limit / self.config.ewma_weight;
            (deviation, self.judge(deviation))
        } else if blind {
            // The anomaly and its statistic persist.
            self.statistic.restart();
            self.calm = 0;
            self.status = Status::Blind;
            (f32::NAN, false)
        } else {
            let deviation = self.deviation(level);
            (deviation, self.judge(deviation))
        };
        let ewma = self.statistic.ewma();
        BlockReport { block: self.blocks, level, deviation, ewma, beyond, status: self.status, was }
    }

    fn deviation(&self, level: f32) -> f32 {
        // Residuals of zero, as of a sensor that repeats itself, are far below but finite, or the EWMA would never recover.
        (math::ln(level.max(f32::MIN_POSITIVE)) - self.config.healthy_centre) / self.config.healthy_spread
    }

    fn judge(&mut self, u: f32) -> bool {
        let c = &self.config;
        let ewma = self.statistic.push(u, c.ewma_weight).map(f32::abs);
        let beyond = ewma.is_some_and(|ewma| ewma > c.limit);
        let calm = ewma.is_some_and(|ewma| ewma < c.release * c.limit);
        self.calm = if calm { self.calm.saturating_add(1) } else { 0 };
        if beyond {
            self.anomalous = true;
        } else if self.calm >= c.calm_blocks {
            self.anomalous = false;
        }
        self.status = if self.anomalous {
            Status::Anomalous
        } else if ewma.is_some() {
            Status::Healthy
        } else {
            Status::Starting
        };
        beyond
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
        Monitor::new(MonitorConfig::new(10, 0.0, 0.1))
    }

    #[test]
    fn a_signal_beyond_full_scale_is_anomalous_and_a_few_such_samples_are_not() {
        let mut m = monitor();
        assert_eq!(feed(&mut m, [1.0; 6]).last(), Some(&Status::Healthy));
        // A flipped bit now and then.
        for _ in 0..6 {
            assert_eq!(m.overload(), None);
            assert_eq!(feed(&mut m, [1.0]), [Status::Healthy]);
        }
        let reports: Vec<BlockReport> = (0..40).filter_map(|_| m.overload()).collect();
        assert!(reports.iter().all(|r| r.level.is_nan() && r.deviation.is_finite() && r.ewma.is_finite()));
        let statuses: Vec<Status> = reports.iter().map(|r| r.status).collect();
        assert_eq!(statuses, [Status::Healthy, Status::Anomalous, Status::Anomalous, Status::Anomalous]);
        // The machine is well again.
        assert_eq!(feed(&mut m, [1.0; 40]).last(), Some(&Status::Healthy));
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
    fn the_statistic_grows_with_the_fault_after_the_alarm_and_clears_from_any_height() {
        let mut m = monitor();
        feed(&mut m, [1.0; 5]);
        let mut last = 0.0;
        for k in 1..=27 {
            for _ in 0..10 {
                if let Some(report) = m.residual([crate::math::exp(0.5 * k as f32)].into_iter()) {
                    assert!(k < 3 || report.ewma > last, "{report:?}");
                    last = report.ewma;
                }
            }
        }
        assert_eq!(m.status(), Status::Anomalous);
        assert_eq!(*feed(&mut m, [1.0; 30]).last().unwrap(), Status::Healthy);
        // Residuals of exactly zero are finite to the statistic.
        assert_eq!(*feed(&mut m, [0.0; 5]).last().unwrap(), Status::Anomalous);
        assert_eq!(*feed(&mut m, [1.0; 40]).last().unwrap(), Status::Healthy);
    }

    #[test]
    fn the_median_is_of_the_last_three() {
        let values = [1.0_f32, 2.0, 3.0];
        for [i, j, k] in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let mut statistic = Statistic::default();
            assert_eq!([values[i], values[j], values[k]].map(|v| statistic.push(v, 1.0)), [None, None, Some(2.0)]);
        }
    }

    #[test]
    fn wrong_configurations_are_told() {
        let good = MonitorConfig::new(10, 0.0, 0.1);
        assert!(good.is_valid() && MonitorConfig::from_levels(10, 0.5, 0.1).is_valid());
        for bad in [
            MonitorConfig { block: 0, ..good },
            MonitorConfig { healthy_spread: 0.0, ..good },
            MonitorConfig { healthy_spread: 1e-30, ..good },
            MonitorConfig { healthy_centre: 1e30, ..good },
            MonitorConfig { healthy_centre: f32::NAN, ..good },
            MonitorConfig { calm_blocks: 0, ..good },
            MonitorConfig { calm_blocks: 33, ..good },
            MonitorConfig { ewma_weight: 1.5, ..good },
            MonitorConfig { false_alarms_per_day: -1.0, ..good },
            MonitorConfig::from_levels(10, 0.0, 0.1),
        ] {
            assert!(!bad.is_valid(), "{bad:?}");
        }
    }
}
