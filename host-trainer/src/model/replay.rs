//! The device's own code over recordings.

use ballrace_core::monitor::Status;
use ballrace_firmware_sim::event::{Event, Statistics, Summary};
use ballrace_firmware_sim::faults::{FaultPlan, Injected, Injector};
use ballrace_firmware_sim::runner::{Recording, Runner, RunnerError};
use ballrace_firmware_sim::source::{Arrival, SampleSource};

use crate::model::OwnedModel;
use crate::recording::input::Input;

/// How to run the device.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// What to break of the samples.
    pub plan: FaultPlan,
    /// Seed of that.
    pub seed: u64,
    /// Play at the recordings' rate times this; `None` as fast as it goes.
    pub pace: Option<f64>,
    /// Keep every sample that reached the device, faults included.
    pub keep_samples: bool,
}

/// One block of the monitor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Index of its recording.
    pub recording: usize,
    /// Status after it.
    pub status: Status,
    /// Statistics after it.
    pub statistics: Statistics,
}

/// What a run over recordings gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Replayed {
    /// The totals.
    pub summary: Summary,
    /// Every block of the monitor.
    pub blocks: Vec<Block>,
    /// Every other event as a JSON object, in order.
    pub events: Vec<serde_json::Value>,
    /// What was broken on purpose.
    pub injected: Injected,
    /// The samples that reached the device, where they were to be kept.
    pub samples: Vec<f32>,
    /// How long it took.
    pub seconds: f64,
}

/// Why a model cannot watch recordings.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// Another sample rate.
    #[error("recordings: found {found} Hz, expected the model's {expected} Hz; --resample {expected} makes them so")]
    Rate {
        /// Of the recordings.
        found: f64,
        /// Of the model.
        expected: f64,
    },
    /// Not a model for a device.
    #[error("{0}")]
    Runner(RunnerError),
    /// An event that is no JSON.
    #[error("an event cannot be written: {0}")]
    Event(#[from] serde_json::Error),
}

/// Runs the device over recordings; `on_event` gets each event and the recordings done.
///
/// # Errors
/// What does not fit together.
pub fn replay(
    model: &OwnedModel,
    input: &Input,
    options: &Options,
    on_event: &mut dyn FnMut(&Event<'_>, usize),
) -> Result<Replayed, ReplayError> {
    let model = model.view();
    let (found, expected) = (input.sample_rate_hz, f64::from(model.sample_rate_hz));
    if (found / expected - 1.0).abs() >= 1e-3 {
        return Err(ReplayError::Rate { found, expected });
    }
    let mut scratch = vec![0.0; Runner::scratch_len(&model)];
    let mut runner = Runner::new(&model, &mut scratch).map_err(ReplayError::Runner)?;
    let mut injector = Injector::new(options.plan.clone(), options.seed);
    let (mut blocks, mut events, mut samples) = (Vec::new(), Vec::new(), Vec::new());
    let mut failed = None;
    let start = std::time::Instant::now();
    let mut see = |event: &Event<'_>, done: usize| {
        match event {
            Event::Block(block) => {
                blocks.push(Block { recording: done, status: block.status, statistics: block.statistics });
            }
            other => match serde_json::to_value(other) {
                Ok(value) => events.push(value),
                Err(error) => failed = Some(error),
            },
        }
        on_event(event, done);
    };
    for (done, series) in input.series.iter().enumerate() {
        let recording = Recording { name: &series.name, sample_rate_hz: input.sample_rate_hz };
        let gaps = input.gaps.get(done).map_or(&[][..], Vec::as_slice);
        let source = injector.over(with_gaps(&series.samples, gaps)).inspect(|arrival| match arrival {
            Arrival::Sample(sample) if options.keep_samples => samples.push(*sample),
            _ => {}
        });
        match options.pace {
            Some(factor) => runner.run(&recording, source.paced(factor * input.sample_rate_hz), |e| see(&e, done)),
            None => runner.run(&recording, source, |e| see(&e, done)),
        };
    }
    let done = input.series.len();
    let summary = runner.finish(|event| see(&event, done));
    match failed {
        Some(error) => Err(error.into()),
        None => Ok(Replayed {
            summary,
            blocks,
            events,
            injected: injector.injected(),
            samples,
            seconds: start.elapsed().as_secs_f64(),
        }),
    }
}

/// A recording as it reaches the device: after each gap it hears that a sample is missing. How many
/// are, the recording does not always say; one is enough to start anew.
fn with_gaps<'a>(samples: &'a [f32], gaps: &'a [usize]) -> impl Iterator<Item = Arrival> + 'a {
    samples.iter().enumerate().flat_map(move |(index, sample)| {
        let missing = gaps.binary_search(&index).is_ok().then_some(Arrival::Missing(1));
        std::iter::once(Arrival::Sample(*sample)).chain(missing)
    })
}
