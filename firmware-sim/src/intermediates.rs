//! CRC-32 over all intermediates of a run, to compare host and device bit by bit.
//!
//! Comparing outputs alone lets two wrong numbers cancel, and comparing within a tolerance lets a difference grow
//! unseen.

use core::fmt;

use ballrace_core::crc::Crc32;
use ballrace_core::device::{Device, SampleResult, ScratchTooSmall};
use ballrace_core::input_check::FaultCounts;
use ballrace_core::model::Model;
use ballrace_core::monitor::{BlockReport, Status};
use serde::{Serialize, Serializer};

/// Greatest number of bytes that [`Report::to_json`] needs.
pub const JSON_LEN: usize = 512;

/// Report of a run. Equal reports mean equal bits in every intermediate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Report {
    /// CRC-32 of all intermediates; in JSON eight hexadecimal digits.
    #[serde(serialize_with = "hexadecimal")]
    pub crc: u32,
    /// Number of samples.
    pub samples: u32,
    /// Number of samples that the model was evaluated for.
    pub evaluated: u32,
    /// Number of the monitor's blocks.
    pub blocks: u32,
    /// Number of blocks after which the status was anomalous.
    pub anomalous_blocks: u32,
    /// Status at the end.
    pub status: Status,
    /// Broken samples by kind.
    pub faults: FaultCounts,
}

/// Runs a model over the samples of one recording, m/s², broken ones included.
///
/// # Errors
/// [`ScratchTooSmall`] of [`Device::new`].
pub fn run<'a>(
    model: &'a Model<'a>,
    scratch: &mut [f32],
    samples: impl IntoIterator<Item = f32>,
) -> Result<Report, ScratchTooSmall> {
    let mut device = Device::new(model, scratch)?;
    let mut fold = Fold(Crc32::new());
    let (mut count, mut evaluated, mut blocks, mut anomalous_blocks) = (0_u32, 0_u32, 0_u32, 0_u32);
    let mut judged = |block: Option<BlockReport>| {
        if let Some(block) = block {
            blocks = block.block;
            anomalous_blocks += u32::from(block.status == Status::Anomalous);
        }
    };
    for sample in samples {
        let outcome = device.push(sample);
        fold.outcome(&outcome);
        count = count.saturating_add(1);
        evaluated = evaluated.saturating_add(u32::from(outcome.step.is_some()));
        judged(outcome.block);
    }
    let block = device.end_of_recording();
    fold.block(block.as_ref());
    judged(block);
    let summary = device.summary();
    Ok(Report {
        crc: fold.0.value(),
        samples: count,
        evaluated,
        blocks,
        anomalous_blocks,
        status: summary.status,
        faults: summary.faults,
    })
}

impl Report {
    /// One line of JSON without a line end, in `buffer` of [`JSON_LEN`] bytes; `None` if it is too short.
    pub fn to_json<'b>(&self, buffer: &'b mut [u8]) -> Option<&'b str> {
        let length = serde_json_core::to_slice(self, buffer).ok()?;
        core::str::from_utf8(buffer.get(..length)?).ok()
    }
}

/// CRC-32 of numbers, each as four bytes, little-endian.
struct Fold(Crc32);

impl Fold {
    fn word(&mut self, word: u32) {
        self.0.update(&word.to_le_bytes());
    }

    fn float(&mut self, value: f32) {
        // The sign of the NaN of ∞ − ∞ depends on the processor (set on x86, clear on Arm).
        self.word(if value.is_nan() { f32::NAN } else { value }.to_bits());
    }

    fn floats(&mut self, values: &[f32]) {
        values.iter().for_each(|value| self.float(*value));
    }

    fn outcome(&mut self, outcome: &SampleResult<'_>) {
        self.word(outcome.quality as u32);
        self.word(u32::from(outcome.step.is_some()));
        if let Some(step) = &outcome.step {
            for values in [step.states, step.latent, step.latent_rate, step.predicted, step.measured, step.expected] {
                self.floats(values);
            }
            step.residuals().for_each(|residual| self.float(residual));
            self.word(u32::from(step.next_sample.is_some()));
            self.float(step.next_sample.unwrap_or_default());
        }
        self.block(outcome.block.as_ref());
    }

    fn block(&mut self, report: Option<&BlockReport>) {
        self.word(u32::from(report.is_some()));
        if let Some(r) = report {
            self.word(r.block);
            self.floats(&[r.level, r.deviation, r.ewma]);
            self.word(u32::from(r.beyond));
            self.word(r.status as u32);
            self.word(r.was as u32);
        }
    }
}

fn hexadecimal<S: Serializer>(value: &u32, serializer: S) -> Result<S::Ok, S::Error> {
    let mut text = heapless::String::<8>::new();
    // Eight digits always fit.
    let _ = fmt::write(&mut text, format_args!("{value:08x}"));
    serializer.serialize_str(&text)
}
