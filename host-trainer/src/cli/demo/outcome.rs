//! Truth and result of the demo.

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
use crate::stats::format::significant;
use crate::stats::units::in_words;

/// Truth and result of the demo, with the device's residuals.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DemoResult {
    /// Seed of everything random.
    pub seed: u64,
    /// Count of recordings.
    pub recordings: usize,
    /// Length of each, s.
    pub seconds: f64,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Hidden effect.
    pub truth: Truth,
    /// First alarm of the device with the model of the nominal rig.
    pub first_alarm: Option<Alarm>,
    /// Count of alarms with that model.
    pub alarms: u32,
    /// Whether the first alarm came before the effect.
    pub false_alarm: bool,
    /// Indices of the diagnosed recordings, from 0.
    pub diagnosed: Vec<usize>,
    /// Verdict of the diagnosis.
    pub diagnosis: Diagnosed,
    /// Causes named by the diagnosis.
    pub causes: Vec<Cause>,
    /// Whether the causes are exactly the hidden effect.
    pub rightly_named: bool,
    /// Terms that the causes added to the library.
    pub entered: Vec<Entered>,
    /// Residual of the device on held-out recordings.
    pub residual: Residual,
    /// Count of alarms on the held-out recordings with the corrected model.
    pub alarms_after: u32,
    /// Four scores of the corrected model, on simulations of the corrected rig.
    pub scores: Scores,
    /// Verdict of the scores.
    pub verdict: Verdict,
    /// Memory and operations of the corrected model on the device.
    pub sizes: Sizes,
}

/// Share of variance that the device's next-sample prediction does not explain, mean over held-out recordings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Residual {
    /// Count of held-out recordings.
    pub recordings: usize,
    /// Model of the nominal rig, on simulations of that rig.
    pub own: f64,
    /// Model of the nominal rig, on the machine.
    pub before: f64,
    /// Corrected model.
    pub after: f64,
    /// Corrected model without the added terms; `None` if there are none.
    pub without_terms: Option<f64>,
    /// Model fitted to the held-out recordings themselves by the same training.
    pub floor: f64,
    /// Count of recordings in which the corrected model is better than the first.
    pub lower_in: usize,
    /// Count of recordings in which the added terms improve the corrected model.
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

    /// Share of the reduction due to the added terms; the rest is due to the corrected rig's simulation.
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
            seed: config.scenario.seed,
            recordings: found.input.series.len(),
            seconds: config.scenario.seconds,
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

    /// Hidden effect as a sentence.
    pub fn put_in(&self) -> String {
        match self.truth.first_affected {
            Some(first) => format!(
                "Hidden effect: {} at {} Hz, damping ratio {}, from {} on.",
                self.truth.effect,
                significant(self.truth.frequency_hz, 5),
                significant(self.truth.damping_ratio, 3),
                self.place(first)
            ),
            None => "Hidden effect: none, the machine equals the nominal rig.".to_owned(),
        }
    }

    /// First alarm of the device as a sentence.
    pub fn raised(&self) -> String {
        match (&self.first_alarm, self.truth.first_affected) {
            (Some(alarm), Some(first)) if !self.false_alarm => {
                let index = alarm.recording_index as usize;
                let later = match index - first {
                    0 => "the first one with the effect".to_owned(),
                    1 => "the next one".to_owned(),
                    n => format!("{n} recordings later"),
                };
                format!("The device raised the alarm in {}, {later}.", self.place(index))
            }
            (Some(alarm), _) => {
                let place = self.place(alarm.recording_index as usize);
                format!("The device raised a false alarm in {place}, before any effect.")
            }
            (None, Some(_)) => "The device raised no alarm: it missed the effect.".to_owned(),
            (None, None) => "The device raised no alarm, which is correct.".to_owned(),
        }
    }

    /// Result of the diagnosis as a sentence.
    pub fn named(&self) -> String {
        let of = |cause: &Cause| {
            let number = |(name, value): (&String, &Parameter)| match value {
                Parameter::Number(v) => in_words(name, *v, cause.interval95.get(name).copied()),
                Parameter::Name(text) => format!("{name} {text}"),
            };
            let numbers: Vec<String> = cause.parameters.iter().map(number).collect();
            format!("{} ({})", cause.name, numbers.join(", "))
        };
        let names: Vec<String> = self.causes.iter().map(of).collect();
        match (self.diagnosis, self.rightly_named) {
            (Diagnosed::NoMismatch, true) => "The diagnosis finds no mismatch, which is correct.".into(),
            (Diagnosed::NoMismatch, false) => "The diagnosis finds no mismatch, which is wrong.".into(),
            (Diagnosed::Unexplained, _) => "The diagnosis finds a mismatch without a named cause.".into(),
            (Diagnosed::Mismatch, true) => format!("The diagnosis names the cause: {}.", names.join(" and ")),
            (Diagnosed::Mismatch, false) => format!("The diagnosis is wrong: it names {}.", names.join(" and ")),
        }
    }

    /// Effect of the correction on the device's residual as a sentence.
    pub fn fell(&self) -> String {
        let r = &self.residual;
        let [before, after, floor, own] = [r.before, r.after, r.floor, r.own].map(|v| significant(v, 3));
        if self.causes.is_empty() {
            return format!(
                "Nothing is corrected: on {} held-out recordings the device's residual is {before}, {after} with a refitted \
                 model, {floor} with a model fitted to these recordings.",
                r.recordings
            );
        }
        format!(
            "With the corrected model the device's residual on the {} held-out recordings falls from {before} to {after}, \
             lower in {}; with a model fitted to these recordings it is {floor}. On simulations of the nominal rig the \
             residual of the first model is {own}.",
            r.recordings, r.lower_in
        )
    }

    /// Effect of the added terms as a sentence; `None` if there are none.
    pub fn terms(&self) -> Option<String> {
        let r = &self.residual;
        let without = r.without_terms?;
        Some(format!(
            "Without the terms added to the library the residual of the corrected model is {}: {:.0} % of the reduction is \
             due to the terms, which lower it in {} of {} recordings, the rest to the fit to the corrected rig's simulation.",
            significant(without, 3),
            100.0 * r.share_of_terms()?,
            r.terms_lower_in?,
            r.recordings
        ))
    }

    fn place(&self, index: usize) -> String {
        format!("recording {} of {}", index + 1, self.recordings)
    }

    /// Complete result as text for a terminal.
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
