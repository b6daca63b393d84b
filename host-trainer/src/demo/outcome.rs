//! What was put in beside what was found.

use std::fmt::Write;

use ballrace_firmware_sim::event::Alarm;
use serde::Serialize;

use super::generator::{Machine, Made, Truth};
use super::{Config, Found};
use crate::export::Sizes;
use crate::fit::score::Scores;
use crate::fit::verdict::Verdict;
use crate::fit::words;

/// What a demo found, and what it was.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Seed.
    pub seed: u64,
    /// Recordings made.
    pub recordings: usize,
    /// Length of each, s.
    pub seconds: f64,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// The machine.
    pub machine: Machine,
    /// What was put in.
    pub truth: Truth,
    /// Recordings taken for healthy.
    pub healthy: usize,
    /// Where the device raised its first alarm.
    pub first_alarm: Option<Alarm>,
    /// Alarms raised.
    pub alarms: u32,
    /// Whether the first alarm came before there was anything to raise it for.
    pub false_alarm: bool,
    /// The four scores.
    pub scores: Scores,
    /// What they say.
    pub verdict: Verdict,
    /// What the model takes on the device.
    pub sizes: Sizes,
}

impl Outcome {
    pub(super) fn of(config: &Config, made: &Made, found: &Found) -> Self {
        let first_alarm = found.watched.summary.first_alarm.clone();
        let alarm = first_alarm.as_ref().map(|a| a.recording_index as usize);
        Self {
            seed: config.plan.seed,
            recordings: found.input.series.len(),
            seconds: config.plan.seconds,
            sample_rate_hz: found.input.sample_rate_hz,
            machine: made.machine,
            truth: made.truth,
            healthy: config.healthy,
            alarms: found.watched.summary.alarms,
            false_alarm: alarm.is_some_and(|a| made.truth.first_affected.is_none_or(|first| a < first)),
            first_alarm,
            scores: found.fitted.report.scores.clone(),
            verdict: found.fitted.report.verdict.clone(),
            sizes: found.sizes,
        }
    }

    /// What was put in, as a sentence.
    pub fn put_in(&self) -> String {
        match self.truth.first_affected {
            Some(first) => {
                format!("Put in: {}, growing from {} on.", self.truth.effect, self.place(first))
            }
            None => "Put in: nothing, the machine stays healthy.".to_owned(),
        }
    }

    /// When the device raised the alarm, as a sentence.
    pub fn raised(&self) -> String {
        match (&self.first_alarm, self.truth.first_affected) {
            (Some(alarm), Some(first)) if !self.false_alarm => {
                let index = alarm.recording_index as usize;
                let later = match index - first {
                    0 => "the very one in which it begins".to_owned(),
                    1 => "the next one".to_owned(),
                    n => format!("{n} recordings later"),
                };
                format!("The device raised the alarm in {}, {later}.", self.place(index))
            }
            (Some(alarm), _) => {
                let place = self.place(alarm.recording_index as usize);
                format!("The device raised a false alarm in {place}, when there was nothing to raise it for.")
            }
            (None, Some(_)) => "The device raised no alarm: the fault was missed.".to_owned(),
            (None, None) => "The device raised no alarm, and rightly so.".to_owned(),
        }
    }

    fn place(&self, index: usize) -> String {
        format!("recording {} of {}", index + 1, self.recordings)
    }

    /// Everything in words, for a terminal.
    pub fn words(&self) -> String {
        let mut out = String::new();
        let s = &self.sizes;
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "{} recordings of {} s at {} Hz; the model knows the first {} as healthy\n{}\n{}",
            self.recordings,
            self.seconds,
            self.sample_rate_hz,
            self.healthy,
            self.put_in(),
            self.raised()
        );
        out += &words::scores(&self.scores);
        let _ = writeln!(out, "\nverdict: {}", self.verdict.words);
        let _ = write!(
            out,
            "\non the device: {} bytes of flash, {} bytes of RAM, {} multiply-adds and {} sigmoids a sample",
            s.flash_bytes, s.ram_bytes, s.multiply_adds, s.sigmoids
        );
        out
    }
}
