//! Events of a device. Each serialises to one flat JSON object whose `event` is `starting`,
//! `healthy`, `anomalous`, `blind`, `block`, `fault` or `summary`; a missing number is `null`.

use ballrace_core::input_check::{FaultCounts, Quality};
use ballrace_core::monitor::{BlockReport, Status};
use serde::Serialize;

/// Event of a device.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Event<'n> {
    /// Change of the status.
    Status(StatusChange<'n>),
    /// End of a block of the monitor, for trends.
    Block(BlockEnd<'n>),
    /// First broken sample of a run of one kind.
    Fault(FaultStart<'n>),
    /// Totals, the last event.
    Summary(Summary),
}

/// Place of an event in the recordings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Place<'n> {
    /// Name of the recording.
    pub recording: &'n str,
    /// Index of the recording, from 0.
    pub recording_index: u32,
    /// Sample periods since the recording's start; samples known to be missing count.
    pub sample: u64,
    /// Time since the recording's start, s.
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
    /// Place of the sample that ended the block.
    #[serde(flatten)]
    pub at: Place<'n>,
    /// Statistics of the block; `None` at the very start.
    #[serde(flatten)]
    pub statistics: Option<Statistics>,
}

/// End of a block of the monitor.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename = "block")]
pub struct BlockEnd<'n> {
    /// Status after the block.
    pub status: Status,
    /// Place of the sample that ended the block.
    #[serde(flatten)]
    pub at: Place<'n>,
    /// Statistics after the block.
    #[serde(flatten)]
    pub statistics: Statistics,
}

/// Statistics of the monitor after a block.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Statistics {
    /// Blocks so far.
    pub block: u32,
    /// Mean squared normalised residual; NaN for a blind block.
    pub level: f32,
    /// Distance of the level's logarithm from its healthy centre in healthy spreads; NaN for a blind block.
    pub deviation: f32,
    /// EWMA of the running median of the deviation; it is what the limit judges.
    pub ewma: f32,
}

impl From<&BlockReport> for Statistics {
    fn from(report: &BlockReport) -> Self {
        let BlockReport { block, level, deviation, ewma, .. } = *report;
        Self { block, level, deviation, ewma }
    }
}

/// Start of a run of broken samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename = "fault")]
pub struct FaultStart<'n> {
    /// Kind of the fault.
    pub kind: Quality,
    /// Value of the sample, m/s²; `None` if it is missing.
    pub value: Option<f32>,
    /// Place of the first sample that the device detected.
    #[serde(flatten)]
    pub at: Place<'n>,
}

/// Totals of a run over recordings.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename = "summary")]
pub struct Summary {
    /// Number of recordings.
    pub recordings: u32,
    /// Number of samples that arrived, broken ones included.
    pub samples: u64,
    /// Number of samples that the model was evaluated for.
    pub evaluated: u64,
    /// Number of the monitor's blocks.
    pub blocks: u32,
    /// Broken samples by kind.
    pub faults: FaultCounts,
    /// Status at the end.
    pub status: Status,
    /// Number of anomalies raised; one that outlasts blindness counts once.
    pub alarms: u32,
    /// Place of the first anomaly raised.
    pub first_alarm: Option<Alarm>,
}

/// Place of an anomaly, as [`Place`] with an owned name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Alarm {
    /// Name of the recording.
    pub recording: String,
    /// Index of the recording, from 0.
    pub recording_index: u32,
    /// Sample periods since the recording's start.
    pub sample: u64,
    /// Time since the recording's start, s.
    pub time_s: f64,
}

impl From<Place<'_>> for Alarm {
    fn from(place: Place<'_>) -> Self {
        let Place { recording, recording_index, sample, time_s } = place;
        Self { recording: recording.to_owned(), recording_index, sample, time_s }
    }
}
