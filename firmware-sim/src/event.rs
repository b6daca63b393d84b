//! What a device tells of. Each event serialises to one flat JSON object whose `event` is `starting`,
//! `healthy`, `anomalous`, `blind`, `block`, `fault` or `summary`; a number that does not exist is `null`.

use ballrace_core::input_check::{FaultCounts, Quality};
use ballrace_core::monitor::{BlockReport, Status};
use serde::Serialize;

/// Something that a person may want to know of.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Event<'n> {
    /// The device holds something else of the machine than before.
    Status(StatusChange<'n>),
    /// A block of the monitor ended: the trend, mostly of interest to a plot.
    Block(BlockEnd<'n>),
    /// The first broken sample of a run of one kind.
    Fault(FaultStart<'n>),
    /// The last event.
    Summary(Summary),
}

/// Where in the recordings something happened.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Place<'n> {
    /// Name of the recording.
    pub recording: &'n str,
    /// Its place among the recordings, from 0.
    pub recording_index: u32,
    /// Sample periods since the recording's start; samples known to be missing count.
    pub sample: u64,
    /// The same in seconds.
    pub time_s: f64,
}

/// A change of status.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StatusChange<'n> {
    /// Status from now on.
    #[serde(rename = "event")]
    pub status: Status,
    /// Status before; `None` at the very start.
    pub was: Option<Status>,
    /// The sample that ended the block.
    #[serde(flatten)]
    pub at: Place<'n>,
    /// What led to it; `None` at the very start.
    #[serde(flatten)]
    pub statistics: Option<Statistics>,
}

/// A block of the monitor ended.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename = "block")]
pub struct BlockEnd<'n> {
    /// Status after it.
    pub status: Status,
    /// The sample that ended it.
    #[serde(flatten)]
    pub at: Place<'n>,
    /// The statistics after it.
    #[serde(flatten)]
    pub statistics: Statistics,
}

/// The monitor's statistics after a block.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Statistics {
    /// Blocks so far.
    pub block: u32,
    /// Mean squared normalised residual; NaN for a blind block.
    pub level: f32,
    /// Distance from the healthy mean in healthy spreads; NaN for a blind block.
    pub deviation: f32,
    /// Slow statistic.
    pub ewma: f32,
    /// Fast statistic.
    pub cusum: f32,
}

impl From<&BlockReport> for Statistics {
    fn from(report: &BlockReport) -> Self {
        let BlockReport { block, level, deviation, ewma, cusum, .. } = *report;
        Self { block, level, deviation, ewma, cusum }
    }
}

/// A run of broken samples began.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename = "fault")]
pub struct FaultStart<'n> {
    /// How it is broken.
    pub kind: Quality,
    /// The sample, m/s²; `None` where it is missing.
    pub value: Option<f32>,
    /// Where the run began, as far as the device can tell.
    #[serde(flatten)]
    pub at: Place<'n>,
}

/// The totals of a run over recordings.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename = "summary")]
pub struct Summary {
    /// Recordings.
    pub recordings: u32,
    /// Samples that arrived, broken ones included.
    pub samples: u64,
    /// Samples that the model was evaluated for.
    pub evaluated: u64,
    /// Blocks of the monitor.
    pub blocks: u32,
    /// Broken samples by kind.
    pub faults: FaultCounts,
    /// Status at the end.
    pub status: Status,
    /// Anomalies raised. One that outlasts blindness is still the same.
    pub alarms: u32,
    /// Where the first one was raised.
    pub first_alarm: Option<Alarm>,
}

/// Where an anomaly was raised: a [`Place`] that outlives the recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Alarm {
    /// Name of the recording.
    pub recording: String,
    /// Its place among the recordings, from 0.
    pub recording_index: u32,
    /// Sample periods since the recording's start.
    pub sample: u64,
    /// The same in seconds.
    pub time_s: f64,
}

impl From<Place<'_>> for Alarm {
    fn from(place: Place<'_>) -> Self {
        let Place { recording, recording_index, sample, time_s } = place;
        Self { recording: recording.to_owned(), recording_index, sample, time_s }
    }
}
