//! Injection of broken and lost samples between a source and the device.
//!
//! Every fault is a stage with its own random numbers, seeded from the seed and the stage's place,
//! so that a seed always breaks the same samples, and a fault added at the end changes none before it.
//! [`FaultPlan`] has the written form.

mod parse;
mod random;
mod stage;

pub use parse::{PlanError, Problem};

use serde::Serialize;
use stage::Stage;

use crate::source::{Arrival, SampleSource};

/// One way for samples to be broken. Probabilities are per sample, 0 to 1; runs are samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// `drop:P`: a sample is lost without notice; the next follows directly.
    Drop {
        /// Probability of a sample to be lost.
        probability: f64,
    },
    /// `gap:PxN`: a run of samples is lost with notice to the device.
    Gap {
        /// Probability of a sample to begin a gap.
        probability: f64,
        /// Samples in a gap.
        run: u32,
    },
    /// `stuck:PxN`: the value of a sample is held.
    Stuck {
        /// Probability of a sample to be held.
        probability: f64,
        /// Samples after it with its value.
        run: u32,
    },
    /// `saturate:LEVEL`: samples are clipped to ±LEVEL. A device detects a level at or above the full
    /// scale of its model; clipping below it looks like a machine that vibrates less.
    Saturate {
        /// Clipping level, m/s².
        level: f32,
    },
    /// `nan:P`: a sample is NaN.
    Nan {
        /// Probability of a sample to be NaN.
        probability: f64,
    },
    /// `flip:P`: one of the 32 bits of a sample's `f32` is inverted. Most such errors, like most of a
    /// converter's, leave a plausible number, which only the residual can show.
    Flip {
        /// Probability of a sample to have a bit inverted.
        probability: f64,
    },
}

/// Faults in the order in which they are applied.
///
/// The written form is a list such as `nan:0.001,stuck:1e-4x50,saturate:30,flip:1e-5,drop:1e-3,gap:1e-5x200`;
/// an empty text is no faults.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaultPlan(pub Vec<Fault>);

/// Counts of the samples that an injector has broken so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Injected {
    /// Samples lost without notice.
    pub dropped: u64,
    /// Samples lost with notice.
    pub missing: u64,
    /// Samples held at an earlier value.
    pub stuck: u64,
    /// Samples clipped.
    pub saturated: u64,
    /// Samples made NaN.
    pub nan: u64,
    /// Samples with one bit inverted.
    pub flipped: u64,
}

/// Injector of a plan's faults, with their counts.
#[derive(Clone, Debug)]
pub struct Injector {
    stages: Vec<Stage>,
    injected: Injected,
}

impl Injector {
    /// Injector of a plan; reproducible from the seed.
    pub fn new(plan: FaultPlan, seed: u64) -> Self {
        let stages = plan.0.into_iter().zip(0..).map(|(fault, place)| Stage::new(fault, seed, place)).collect();
        Self { stages, injected: Injected::default() }
    }

    /// Counts of the samples broken so far.
    pub fn injected(&self) -> Injected {
        self.injected
    }

    /// Source with faults injected. The injector outlives the source, so that its random numbers
    /// and its counts continue from one recording to the next.
    pub fn over<S: SampleSource>(&mut self, source: S) -> Faulty<'_, S> {
        Faulty { source, injector: self }
    }

    /// Arrival at the device for one from the source; `None` for a sample lost without notice.
    pub fn pass(&mut self, arrival: Arrival) -> Option<Arrival> {
        self.stages.iter_mut().try_fold(arrival, |arrival, stage| stage.pass(arrival, &mut self.injected))
    }
}

/// Source of [`Injector::over`].
#[derive(Debug)]
pub struct Faulty<'i, S> {
    source: S,
    injector: &'i mut Injector,
}

impl<S: SampleSource> Iterator for Faulty<'_, S> {
    type Item = Arrival;

    fn next(&mut self) -> Option<Arrival> {
        loop {
            let arrival = self.source.next()?;
            if let Some(arrival) = self.injector.pass(arrival) {
                return Some(arrival);
            }
        }
    }
}
