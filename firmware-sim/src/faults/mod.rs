//! Broken sensors and lost samples, put between a source and the device.
//!
//! Every fault is a stage with its own random numbers, seeded from the seed and the stage's place,
//! so that the same seed breaks the same samples, and a fault added at the end changes none before it.
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
    /// `drop:P`: a sample is lost and nobody notices; what follows closes up.
    Drop {
        /// Chance of a sample to be lost.
        probability: f64,
    },
    /// `gap:PxN`: a run of samples never comes, and the device is told.
    Gap {
        /// Chance of a sample to begin a gap.
        probability: f64,
        /// Samples in a gap.
        run: u32,
    },
    /// `stuck:PxN`: the value of a sample is held.
    Stuck {
        /// Chance of a sample to be held.
        probability: f64,
        /// Samples after it that have its value.
        run: u32,
    },
    /// `saturate:LEVEL`: samples are clipped to ±LEVEL. A device sees a level at or above the full
    /// scale of its model; clipping below it looks like a machine that shakes less.
    Saturate {
        /// m/s².
        level: f32,
    },
    /// `nan:P`: a sample is NaN.
    Nan {
        /// Chance of a sample to be NaN.
        probability: f64,
    },
    /// `flip:P`: one of the 32 bits of a sample's `f32` is inverted. Most such errors, like most of a
    /// converter's, leave a plausible number: no screen can see those, only the residual can.
    Flip {
        /// Chance of a sample to have a bit inverted.
        probability: f64,
    },
}

/// Faults in the order in which samples meet them.
///
/// The written form is a list such as `nan:0.001,stuck:1e-4x50,saturate:30,flip:1e-5,drop:1e-3,gap:1e-5x200`;
/// an empty text is no faults.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaultPlan(pub Vec<Fault>);

/// Samples that an injector has broken so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Injected {
    /// Lost without notice.
    pub dropped: u64,
    /// Lost with notice.
    pub missing: u64,
    /// Held at an earlier value.
    pub stuck: u64,
    /// Clipped.
    pub saturated: u64,
    /// Made NaN.
    pub nan: u64,
    /// One bit inverted.
    pub flipped: u64,
}

/// Stages in a row, and their counts.
#[derive(Clone, Debug)]
pub struct Injector {
    stages: Vec<Stage>,
    injected: Injected,
}

impl Injector {
    /// The faults of a plan; the same seed gives the same faults.
    pub fn new(plan: FaultPlan, seed: u64) -> Self {
        let stages = plan.0.into_iter().zip(0..).map(|(fault, place)| Stage::new(fault, seed, place)).collect();
        Self { stages, injected: Injected::default() }
    }

    /// Samples broken so far.
    pub fn injected(&self) -> Injected {
        self.injected
    }

    /// Breaks what arrives from a source. The injector outlives the source, so that its random numbers
    /// and its counts go on from one recording to the next.
    pub fn over<S: SampleSource>(&mut self, source: S) -> Faulty<'_, S> {
        Faulty { source, injector: self }
    }

    /// What the device gets for what arrived; nothing for a sample lost without notice.
    pub fn pass(&mut self, arrival: Arrival) -> Option<Arrival> {
        self.stages.iter_mut().try_fold(arrival, |arrival, stage| stage.pass(arrival, &mut self.injected))
    }
}

/// See [`Injector::over`].
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
