//! Runner of the device over arrivals: an application's main loop, with events for its actions.

use std::fmt;

use ballrace_core::device::{Device, ScratchTooSmall};
use ballrace_core::input_check::Quality;
use ballrace_core::model::{Input, Model};
use ballrace_core::monitor::{BlockReport, Status};

use crate::batch::Evaluated;
use crate::event::{Alarm, BlockEnd, Event, FaultStart, Place, StatusChange, Summary};
use crate::source::{Arrival, SampleSource};

/// Error of a model that the device cannot run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunnerError {
    /// Model whose states are given directly; a device has only samples of one acceleration.
    StatesGiven {
        /// Number of states.
        states: usize,
    },
    /// Too little scratch memory.
    Scratch(ScratchTooSmall),
}

impl fmt::Display for RunnerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StatesGiven { states } => {
                write!(f, "model takes {states} states directly, expected virtual states of one acceleration channel")
            }
            Self::Scratch(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for RunnerError {}

/// Name and sample rate of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recording<'n> {
    /// Name of the recording in events.
    pub name: &'n str,
    /// Sample rate, Hz, for the times of events.
    pub sample_rate_hz: f64,
}

/// What the device made of an arrival.
struct Taken {
    arrival: Arrival,
    quality: Quality,
    evaluated: bool,
    block: Option<BlockReport>,
}

/// Runner of one device over recordings, with its totals.
#[derive(Debug)]
pub struct Runner<'a, 's> {
    device: Device<'a, 's>,
    recordings: u32,
    samples: u64,
    evaluated: u64,
    blocks: u32,
    alarms: u32,
    first_alarm: Option<Alarm>,
    /// Whether an anomaly was raised and not cleared since; blindness does not clear it.
    alarmed: bool,
}

impl<'a, 's> Runner<'a, 's> {
    /// Number of floats of scratch that a model needs.
    pub fn scratch_len(model: &Model<'_>) -> usize {
        Device::scratch_len(model)
    }

    /// Runner before the first recording. The device's memory is `scratch`, as on the microcontroller.
    ///
    /// # Errors
    /// [`RunnerError`]: a model with directly given states, or too little scratch.
    pub fn new(model: &'a Model<'a>, scratch: &'s mut [f32]) -> Result<Self, RunnerError> {
        if let Input::Direct(states) = model.input {
            return Err(RunnerError::StatesGiven { states });
        }
        let device = Device::new(model, scratch).map_err(RunnerError::Scratch)?;
        Ok(Self {
            device,
            recordings: 0,
            samples: 0,
            evaluated: 0,
            blocks: 0,
            alarms: 0,
            first_alarm: None,
            alarmed: false,
        })
    }

    /// Runs one recording from start to end; the device keeps its state between recordings.
    pub fn run(
        &mut self,
        recording: &Recording<'_>,
        source: impl SampleSource,
        on_event: impl FnMut(Event<'_>),
    ) -> &mut Self {
        let mut arrivals = source;
        let next = |device: &mut Device<'_, '_>| {
            let arrival = arrivals.find(|arrival| *arrival != Arrival::Missing(0))?;
            let (quality, evaluated, block) = match arrival {
                Arrival::Sample(sample) => {
                    let outcome = device.push(sample);
                    (outcome.quality, outcome.step.is_some(), outcome.block)
                }
                Arrival::Missing(count) => (Quality::Missing, false, device.missing(count)),
            };
            Some(Taken { arrival, quality, evaluated, block })
        };
        self.take(recording, next, on_event)
    }

    /// Runs one recording that [`Batch::evaluate`](crate::batch::Batch::evaluate) has evaluated by the same model: the events
    /// are those of [`run`](Self::run).
    pub fn run_evaluated(
        &mut self,
        recording: &Recording<'_>,
        evaluated: &Evaluated,
        on_event: impl FnMut(Event<'_>),
    ) -> &mut Self {
        let mut taken = evaluated.iter();
        let next = |device: &mut Device<'_, '_>| {
            let (arrival, quality, evaluated, residuals) = taken.next()?;
            let block = match arrival {
                Arrival::Sample(_) => device.judge(quality, residuals.map(|residuals| residuals.iter().copied())),
                Arrival::Missing(count) => device.missing(count),
            };
            Some(Taken { arrival, quality, evaluated, block })
        };
        self.take(recording, next, on_event)
    }

    /// Takes what the device makes of each arrival, and says what happened.
    fn take(
        &mut self,
        recording: &Recording<'_>,
        mut next: impl FnMut(&mut Device<'a, 's>) -> Option<Taken>,
        mut on_event: impl FnMut(Event<'_>),
    ) -> &mut Self {
        let recording_index = self.recordings;
        let place = |sample: u64| Place {
            recording: recording.name,
            recording_index,
            sample,
            time_s: sample as f64 / recording.sample_rate_hz,
        };
        if self.recordings == 0 {
            let status = self.device.summary().status;
            on_event(Event::Status(StatusChange { status, was: None, at: place(0), statistics: None }));
        }
        self.recordings += 1;
        let mut position = 0;
        let mut before = Quality::Good;
        while let Some(Taken { arrival, quality, evaluated, block }) = next(&mut self.device) {
            self.samples += u64::from(matches!(arrival, Arrival::Sample(_)));
            self.evaluated += u64::from(evaluated);
            if quality != before && quality != Quality::Good {
                let value = match arrival {
                    Arrival::Sample(sample) => Some(sample),
                    Arrival::Missing(_) => None,
                };
                on_event(Event::Fault(FaultStart { kind: quality, value, at: place(position) }));
            }
            before = quality;
            position += u64::from(arrival.periods());
            self.judge(block, place(position.saturating_sub(1)), &mut on_event);
        }
        let block = self.device.end_of_recording();
        self.judge(block, place(position.saturating_sub(1)), &mut on_event);
        self
    }

    /// Ends the run; the totals are the last event and the return value.
    pub fn finish(self, mut on_event: impl FnMut(Event<'_>)) -> Summary {
        let device = self.device.summary();
        let summary = Summary {
            recordings: self.recordings,
            samples: self.samples,
            evaluated: self.evaluated,
            blocks: self.blocks,
            faults: device.faults,
            status: device.status,
            alarms: self.alarms,
            first_alarm: self.first_alarm,
        };
        on_event(Event::Summary(summary.clone()));
        summary
    }

    fn judge(&mut self, block: Option<BlockReport>, at: Place<'_>, on_event: &mut impl FnMut(Event<'_>)) {
        let Some(report) = block else { return };
        self.blocks = report.block;
        let statistics = (&report).into();
        on_event(Event::Block(BlockEnd { status: report.status, at, statistics }));
        if report.status == report.was {
            return;
        }
        match report.status {
            Status::Anomalous if !self.alarmed => {
                self.alarmed = true;
                self.alarms += 1;
                self.first_alarm.get_or_insert_with(|| at.into());
            }
            Status::Starting | Status::Healthy => self.alarmed = false,
            Status::Anomalous | Status::Blind => {}
        }
        let (status, was) = (report.status, Some(report.was));
        on_event(Event::Status(StatusChange { status, was, at, statistics: Some(statistics) }));
    }
}
