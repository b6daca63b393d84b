//! What was put in beside what was found.

use std::fmt::Write;

use ballrace_firmware_sim::event::Alarm;
use serde::Serialize;

use super::Config;
use super::generator::{Made, Truth};
use super::job::JobResult;
use crate::diagnose::result::{Cause, Parameter, Verdict as Diagnosed};
use crate::model::export::Sizes;
use crate::model::fit::score::Scores;
use crate::model::fit::terms::Entered;
use crate::model::fit::text;
use crate::model::fit::verdict::Verdict;
use crate::stats::format::{significant, with_interval};

/// What a demo found, and what it was.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DemoResult {
    /// Seed.
    pub seed: u64,
    /// Recordings made.
    pub recordings: usize,
    /// Length of each, s.
    pub seconds: f64,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// What was put in.
    pub truth: Truth,
    /// Where the device raised its first alarm, with the model of the machine as drawn.
    pub first_alarm: Option<Alarm>,
    /// Alarms raised.
    pub alarms: u32,
    /// Whether the first alarm came before there was anything to raise it for.
    pub false_alarm: bool,
    /// Recordings that were diagnosed, from 0.
    pub diagnosed: Vec<usize>,
    /// The diagnosis' verdict.
    pub diagnosis: Diagnosed,
    /// The causes that it names.
    pub causes: Vec<Cause>,
    /// Whether these are what was put in, no more and no less.
    pub rightly_named: bool,
    /// What they brought into the library.
    pub entered: Vec<Entered>,
    /// The device's residual on recordings that took no part in the diagnosis.
    pub residual: Residual,
    /// Alarms that the device raised on those with the corrected model.
    pub alarms_after: u32,
    /// The four scores of the corrected model, on simulations of the corrected rig.
    pub scores: Scores,
    /// What they say.
    pub verdict: Verdict,
    /// What the corrected model takes on the device.
    pub sizes: Sizes,
}

/// The share of variance that the device's prediction of the next sample leaves, mean over the recordings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Residual {
    /// Recordings.
    pub recordings: usize,
    /// Of the model of the machine as drawn, on what is drawn.
    pub own: f64,
    /// Of that model on the machine.
    pub before: f64,
    /// Of the corrected model.
    pub after: f64,
    /// Of the corrected model without the terms that entered; `None` where none did.
    pub without_terms: Option<f64>,
    /// Of a model fitted to these very recordings by the same training.
    pub floor: f64,
    /// In how many recordings the corrected model leaves less than the first.
    pub lower_in: usize,
    /// In how many it leaves less than itself without the terms.
    pub terms_lower_in: Option<usize>,
}

impl Residual {
    fn from_found(found: &JobResult) -> Self {
        let residuals = &found.residuals;
        let judged = |values: &[f64]| -> Vec<f64> { found.judged.iter().map(|n| values[*n]).collect() };
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let (before, after) = (judged(&residuals.before), judged(&residuals.after));
        let lower = |than: &[f64]| after.iter().zip(than).filter(|(a, b)| a < b).count();
        let without = residuals.without_terms.as_deref().map(judged);
        Self {
            recordings: found.judged.len(),
            own: residuals.own,
            before: mean(&before),
            after: mean(&after),
            without_terms: without.as_deref().map(mean),
            floor: mean(&residuals.floor),
            lower_in: lower(&before),
            terms_lower_in: without.as_deref().map(lower),
        }
    }

    /// Share of the fall that comes of the terms alone, the corrected rig's simulation doing the rest.
    pub fn share_of_terms(&self) -> Option<f64> {
        Some((self.without_terms? - self.after) / (self.before - self.after))
    }
}

impl DemoResult {
    pub(super) fn new(config: &Config, made: &Made, found: &JobResult) -> Self {
        let first_alarm = found.watched.summary.first_alarm.clone();
        let alarm = first_alarm.as_ref().map(|a| a.recording_index as usize);
        let causes = found.diagnosis.diagnosis.causes.clone();
        let names: Vec<&str> = causes.iter().map(|cause| cause.name.as_str()).collect();
        let there: Vec<&str> = made.truth.first_affected.iter().map(|_| made.truth.effect).collect();
        Self {
            seed: config.plan.seed,
            recordings: found.input.series.len(),
            seconds: config.plan.seconds,
            sample_rate_hz: found.input.sample_rate_hz,
            truth: made.truth.clone(),
            alarms: found.watched.summary.alarms,
            false_alarm: alarm.is_some_and(|a| made.truth.first_affected.is_none_or(|first| a < first)),
            first_alarm,
            diagnosed: found.diagnosed.clone(),
            diagnosis: found.diagnosis.diagnosis.verdict,
            rightly_named: names == there && found.diagnosis.diagnosis.verdict != Diagnosed::Unexplained,
            causes,
            entered: found.entered.clone(),
            residual: Residual::from_found(found),
            alarms_after: found.watched_after.summary.alarms,
            scores: found.after.report.scores.clone(),
            verdict: found.after.report.verdict.clone(),
            sizes: found.sizes,
        }
    }

    /// What was put in, as a sentence.
    pub fn put_in(&self) -> String {
        match self.truth.first_affected {
            Some(first) => format!(
                "Put in: {} at {} Hz, damping ratio {}, from {} on.",
                self.truth.effect,
                significant(self.truth.frequency_hz, 5),
                significant(self.truth.damping_ratio, 3),
                self.place(first)
            ),
            None => "Put in: nothing, the machine stays as it was drawn.".to_owned(),
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
            (None, Some(_)) => "The device raised no alarm: the change was missed.".to_owned(),
            (None, None) => "The device raised no alarm, and rightly so.".to_owned(),
        }
    }

    /// What the diagnosis said, as a sentence.
    pub fn named(&self) -> String {
        let of = |cause: &Cause| {
            let number = |(name, value): (&String, &Parameter)| match value {
                Parameter::Number(v) => {
                    format!("{name} {}", with_interval(*v, cause.interval95.get(name).copied()).0)
                }
                Parameter::Name(text) => format!("{name} {text}"),
            };
            let numbers: Vec<String> = cause.parameters.iter().map(number).collect();
            format!("{} ({})", cause.name, numbers.join(", "))
        };
        let names: Vec<String> = self.causes.iter().map(of).collect();
        match (self.diagnosis, self.rightly_named) {
            (Diagnosed::NoMismatch, true) => "The diagnosis finds nothing, and rightly so.".into(),
            (Diagnosed::NoMismatch, false) => "The diagnosis finds nothing, and is wrong.".into(),
            (Diagnosed::Unexplained, _) => "The diagnosis sees a mismatch and cannot name it.".into(),
            (Diagnosed::Mismatch, true) => format!("The diagnosis names it: {}.", names.join(" and ")),
            (Diagnosed::Mismatch, false) => format!("The diagnosis is wrong: it names {}.", names.join(" and ")),
        }
    }

    /// What the correction does to the device's residual, as a sentence.
    pub fn fell(&self) -> String {
        let r = &self.residual;
        let [before, after, floor, own] = [r.before, r.after, r.floor, r.own].map(|v| significant(v, 3));
        if self.causes.is_empty() {
            return format!(
                "So nothing is corrected: on {} recordings that took no part the device's residual is {before}, {after} \
                 with a model fitted anew, {floor} with one fitted to these very recordings.",
                r.recordings
            );
        }
        format!(
            "With the corrected model the device's residual on the {} recordings that took no part goes from {before} to \
             {after}, lower in {}; a model fitted to these very recordings leaves {floor}. On simulations of the drawing \
             itself the first model leaves {own}.",
            r.recordings, r.lower_in
        )
    }

    /// What the terms alone did, as a sentence; nothing where none entered.
    pub fn terms(&self) -> Option<String> {
        let r = &self.residual;
        let without = r.without_terms?;
        Some(format!(
            "Without the terms that entered the library the corrected model leaves {}: {:.0} % of the fall come of the terms, \
             which leave less in {} of {} recordings, and the rest of fitting to what the corrected rig gives.",
            significant(without, 3),
            100.0 * r.share_of_terms()?,
            r.terms_lower_in?,
            r.recordings
        ))
    }

    fn place(&self, index: usize) -> String {
        format!("recording {} of {}", index + 1, self.recordings)
    }

    /// Everything in words, for a terminal.
    pub fn text(&self) -> String {
        let mut out = String::new();
        let s = &self.sizes;
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{} recordings of {} s at {} Hz", self.recordings, self.seconds, self.sample_rate_hz);
        for sentence in [self.put_in(), self.raised(), self.named()] {
            let _ = writeln!(out, "{sentence}");
        }
        for entered in &self.entered {
            let _ = writeln!(out, "{}", entered.line());
        }
        let _ = writeln!(out, "{}", self.fell());
        if let Some(sentence) = self.terms() {
            let _ = writeln!(out, "{sentence}");
        }
        out += &text::scores(&self.scores);
        let _ = writeln!(out, "\nverdict: {}", self.verdict.words);
        let _ = write!(
            out,
            "\non the device: {} bytes of flash, {} bytes of RAM, {} multiply-adds and {} sigmoids a sample",
            s.flash_bytes, s.ram_bytes, s.multiply_adds, s.sigmoids
        );
        out
    }
}
