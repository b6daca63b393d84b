//! Check of every raw sample before any arithmetic: broken samples are counted and never evaluated.
//!
//! Afterwards is too late: `NaN.max(0.0)` is 0, and a NaN in a difference is in all later ones.

use serde::{Deserialize, Serialize};

/// Quality of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(rename_all = "kebab-case")]
pub enum Quality {
    /// Good: is evaluated.
    Good,
    /// NaN or infinite.
    NonFinite,
    /// Saturated: at or beyond the sensor's full scale.
    Saturated,
    /// Equal to too many samples before it.
    Stuck,
    /// Not received.
    Missing,
}

/// Limits of the sensor and its converter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScreenConfig {
    /// Full scale, m/s²: a magnitude at or above it is saturated; 0 if unknown.
    pub full_scale: f32,
    /// Number of equal samples in a row that are stuck; 0 never.
    pub stuck_after: u32,
}

/// Broken samples so far, saturating counters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FaultCounts {
    /// NaN or infinite samples.
    pub non_finite: u32,
    /// Samples at or beyond full scale.
    pub saturated: u32,
    /// Samples in stuck runs, counted from the one that made the run too long.
    pub stuck: u32,
    /// Samples not received.
    pub missing: u32,
}

impl FaultCounts {
    /// Number of all broken samples.
    pub fn total(&self) -> u32 {
        [self.non_finite, self.saturated, self.stuck, self.missing].iter().fold(0, |sum, &n| sum.saturating_add(n))
    }
}

/// Check of a stream of samples.
#[derive(Clone, Debug)]
pub struct Screen {
    config: ScreenConfig,
    counts: FaultCounts,
    last: f32,
    run: u32,
}

impl Screen {
    /// Screen before the first sample.
    pub fn new(config: ScreenConfig) -> Self {
        Self { config, counts: FaultCounts::default(), last: f32::NAN, run: 0 }
    }

    /// Quality of the next sample, counted.
    pub fn check(&mut self, sample: f32) -> Quality {
        // NaN equals nothing, so a run never survives one.
        self.run = if sample == self.last { self.run.saturating_add(1) } else { 1 };
        self.last = sample;
        let full_scale = self.config.full_scale;
        let quality = if !sample.is_finite() {
            Quality::NonFinite
        } else if self.config.stuck_after > 0 && self.run >= self.config.stuck_after {
            // At full scale too: a sensor at its rail says nothing of the machine.
            Quality::Stuck
        } else if full_scale > 0.0 && sample.abs() >= full_scale {
            Quality::Saturated
        } else {
            return Quality::Good;
        };
        self.count(quality);
        quality
    }

    /// Counts a sample of a quality.
    pub(crate) fn count(&mut self, quality: Quality) {
        let count = match quality {
            Quality::Good => return,
            Quality::NonFinite => &mut self.counts.non_finite,
            Quality::Saturated => &mut self.counts.saturated,
            Quality::Stuck => &mut self.counts.stuck,
            Quality::Missing => &mut self.counts.missing,
        };
        *count = count.saturating_add(1);
    }

    /// Ends a recording: the next sample begins a new run of equal ones.
    pub fn end_of_recording(&mut self) {
        self.run = 0;
        self.last = f32::NAN;
    }

    /// Counts samples not received.
    pub fn missing(&mut self, count: u32) {
        self.end_of_recording();
        self.counts.missing = self.counts.missing.saturating_add(count);
    }

    /// Broken samples so far.
    pub fn counts(&self) -> FaultCounts {
        self.counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_is_told_and_counted() {
        let mut screen = Screen::new(ScreenConfig { full_scale: 50.0, stuck_after: 3 });
        let samples = [1.0, 1.0, 1.0, 1.0, f32::NAN, f32::INFINITY, 49.9, -50.0, 51.0, 2.0];
        let expected = [
            Quality::Good,
            Quality::Good,
            Quality::Stuck,
            Quality::Stuck,
            Quality::NonFinite,
            Quality::NonFinite,
            Quality::Good,
            Quality::Saturated,
            Quality::Saturated,
            Quality::Good,
        ];
        for (sample, expected) in samples.into_iter().zip(expected) {
            assert_eq!(screen.check(sample), expected, "{sample}");
        }
        screen.missing(7);
        let counts = FaultCounts { non_finite: 2, saturated: 2, stuck: 2, missing: 7 };
        assert_eq!(screen.counts(), counts);
        assert_eq!(counts.total(), 13);
    }

    #[test]
    fn zero_limits_switch_the_checks_off() {
        let mut screen = Screen::new(ScreenConfig { full_scale: 0.0, stuck_after: 0 });
        assert!((0..1000).all(|_| screen.check(1e30) == Quality::Good));
        assert_eq!(screen.check(f32::NAN), Quality::NonFinite);
    }
}
