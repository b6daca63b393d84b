//! Replay of recordings through the device's own code.

use ballrace_core::monitor::Status;
use ballrace_firmware_sim::batch::{Batch, Evaluated};
use ballrace_firmware_sim::event::{Event, Statistics, Summary};
use ballrace_firmware_sim::faults::{FaultPlan, Injected, Injector};
use ballrace_firmware_sim::runner::{Recording, Runner, RunnerError};
use ballrace_firmware_sim::source::{Arrival, SampleSource};
use rayon::prelude::*;

use crate::model::OwnedModel;
use crate::recording::input::Input;

/// Recordings evaluated side by side, for what their residuals take of memory.
const SIDE_BY_SIDE: usize = 32;

/// Options of a replay.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Faults to inject into the samples.
    pub plan: FaultPlan,
    /// Seed of the faults.
    pub seed: u64,
    /// Speed in multiples of real time; `None`: as fast as possible.
    pub pace: Option<f64>,
    /// Keep every sample that reached the device, faults included.
    pub keep_samples: bool,
}

/// One block of the monitor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Index of its recording.
    pub recording: usize,
    /// Status after the block.
    pub status: Status,
    /// Statistics after the block.
    pub statistics: Statistics,
}

/// Result of a replay.
#[derive(Clone, Debug, PartialEq)]
pub struct Replayed {
    /// Totals over the run.
    pub summary: Summary,
    /// Every block of the monitor.
    pub blocks: Vec<Block>,
    /// Every other event as a JSON object, in order.
    pub events: Vec<serde_json::Value>,
    /// Faults injected.
    pub injected: Injected,
    /// Samples that reached the device; empty unless `keep_samples`.
    pub samples: Vec<f32>,
    /// Wall-clock time, s.
    pub seconds: f64,
}

/// Failure of a replay.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// Another sample rate.
    #[error("recordings: found {found} Hz, expected the model's {expected} Hz; --resample {expected} makes them so")]
    Rate {
        /// Sample rate of the recordings, Hz.
        found: f64,
        /// Sample rate of the model, Hz.
        expected: f64,
    },
    /// Model that the runner refuses.
    #[error("{0}")]
    Runner(RunnerError),
    /// Event that cannot be written as JSON.
    #[error("an event cannot be written: {0}")]
    Event(#[from] serde_json::Error),
}

/// Runs the device over recordings; `on_event` gets each event and the recordings done.
///
/// # Errors
/// Another sample rate than the model's, a model that the runner refuses, an event that is no JSON.
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
    let recording = |index: usize| Recording { name: &input.series[index].name, sample_rate_hz: input.sample_rate_hz };
    let mut arrivals = |index: usize, injector: &mut Injector| -> Vec<Arrival> {
        let gaps = input.gaps.get(index).map_or(&[][..], Vec::as_slice);
        let arrivals: Vec<_> = injector.over(with_gaps(&input.series[index].samples, gaps)).collect();
        if options.keep_samples {
            samples.extend(arrivals.iter().filter_map(|arrival| match arrival {
                Arrival::Sample(sample) => Some(*sample),
                Arrival::Missing(_) => None,
            }));
        }
        arrivals
    };
    let indices: Vec<usize> = (0..input.series.len()).collect();
    match (options.pace, Batch::new(&model)) {
        (None, Some(batch)) => {
            let evaluate = |arrivals: Vec<Vec<Arrival>>| -> Vec<Evaluated> {
                arrivals.into_par_iter().map(|arrivals| batch.evaluate(arrivals)).collect()
            };
            // The monitor takes the recordings before while these are evaluated.
            let (mut before, mut evaluated) = (&[][..], Vec::new());
            for indices in indices.chunks(SIDE_BY_SIDE).chain([&[][..]]) {
                let arrivals: Vec<_> = indices.iter().map(|index| arrivals(*index, &mut injector)).collect();
                evaluated = std::thread::scope(|scope| {
                    let next = scope.spawn(|| evaluate(arrivals));
                    for (index, evaluated) in before.iter().zip(&evaluated) {
                        runner.run_evaluated(&recording(*index), evaluated, |event| see(&event, *index));
                    }
                    next.join().expect("no panic in an evaluation")
                });
                before = indices;
            }
        }
        (pace, _) => {
            let rate_hz = pace.map_or(f64::INFINITY, |factor| factor * input.sample_rate_hz);
            for index in indices {
                let source = arrivals(index, &mut injector).into_iter().paced(rate_hz);
                runner.run(&recording(index), source, |event| see(&event, index));
            }
        }
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

/// Arrivals of a recording at the device, with one missing sample at each gap: the recording does not always state how
/// many are missing, and one is enough to restart the differences.
fn with_gaps<'a>(samples: &'a [f32], gaps: &'a [usize]) -> impl Iterator<Item = Arrival> + 'a {
    samples.iter().enumerate().flat_map(move |(index, sample)| {
        let missing = gaps.binary_search(&index).is_ok().then_some(Arrival::Missing(1));
        std::iter::once(Arrival::Sample(*sample)).chain(missing)
    })
}
