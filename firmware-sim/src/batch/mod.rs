//! Evaluation of recordings many samples at a time, to the device's own bits.
//!
//! Only the virtual states and the monitor go from sample to sample; what is between them, nearly all of the work, is the
//! same for each sample by itself. So the samples of a chunk lie side by side in the lanes of vectors, each lane makes the
//! device's operations in the device's order, and chunks and recordings spread over the cores. The networks' kernels are
//! `network`, the functions of [`ballrace_core::math`] on vectors in `functions`; tests hold both to the device's bits.

mod functions;
mod network;

use ballrace_core::evaluator::{Evaluator, scratch_len};
use ballrace_core::input_check::{Quality, Screen};
use ballrace_core::model::{Input, Model};
use ballrace_core::network::Arithmetic;
use ballrace_core::states::{Alignment, StateSpec, VirtualStates};
use pulp::Arch;
use rayon::prelude::*;

use crate::source::Arrival;
use network::Kernel;

/// Samples of a chunk: a multiple of every vector's lanes, few enough for a core's cache.
const CHUNK: usize = 64;
/// Chunks that a core takes at once.
const CHUNKS: usize = 8;

/// A model prepared for the evaluation of recordings.
#[derive(Debug)]
pub struct Batch<'a> {
    model: &'a Model<'a>,
    spec: StateSpec,
    arch: Arch,
    /// Networks in single precision; `None` in fixed point or with the feature `approx`, which the device's own code evaluates.
    kernel: Option<Kernel>,
}

/// What the device makes of a recording, up to the monitor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evaluated {
    arrivals: Vec<(Arrival, Quality, Outcome)>,
    /// Normalised residuals of the compared samples, one behind the other.
    residuals: Vec<f32>,
    /// Residuals of a sample.
    dimension: usize,
}

/// What came of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// Not evaluated: broken, or while the differences fill.
    Nothing,
    /// Evaluated, and nothing to compare with.
    Evaluated,
    /// Evaluated and compared.
    Compared,
}

impl Evaluated {
    /// Arrivals with their quality, whether the model was evaluated, and the normalised residuals.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (Arrival, Quality, bool, Option<&[f32]>)> {
        let mut residuals = self.residuals.chunks_exact(self.dimension.max(1));
        self.arrivals.iter().map(move |(arrival, quality, outcome)| {
            let residuals = if *outcome == Outcome::Compared { residuals.next() } else { None };
            (*arrival, *quality, *outcome != Outcome::Nothing, residuals)
        })
    }
}

impl<'a> Batch<'a> {
    /// Prepares a model; `None` for one whose states are given directly.
    pub fn new(model: &'a Model<'a>) -> Option<Self> {
        let Input::VirtualStates(spec) = model.input else { return None };
        // The vectors have the exact functions only.
        let exact = !cfg!(feature = "approx");
        let float = [&model.encoder, &model.decoder].iter().all(|n| n.arithmetic() == Arithmetic::Float);
        Some(Self { model, spec, arch: Arch::new(), kernel: (exact && float).then(|| Kernel::new(model)) })
    }

    /// Normalised residuals of a recording's samples.
    pub fn evaluate(&self, arrivals: impl IntoIterator<Item = Arrival>) -> Evaluated {
        let n = self.spec.dimension;
        let causal = self.spec.alignment == Alignment::Causal;
        let mut memory = vec![0.0; self.spec.memory_len()];
        let mut stream = VirtualStates::new(self.spec, &mut memory).expect("a valid model's states");
        let mut screen = Screen::new(self.model.screen);
        let (mut row, mut target) = (vec![0.0; n], vec![0.0; n]);
        let (mut states, mut targets) = (Vec::new(), Vec::new());
        let mut out = Evaluated { dimension: n, ..Evaluated::default() };
        // Whether the row before belongs to the sample before.
        let mut awaiting = false;
        let arrivals = arrivals.into_iter();
        let expected = arrivals.size_hint().0;
        out.arrivals.reserve(expected);
        states.reserve(n * expected);
        targets.reserve(n * expected);
        for arrival in arrivals {
            let quality = match arrival {
                Arrival::Sample(sample) => screen.check(sample),
                Arrival::Missing(0) => continue,
                Arrival::Missing(count) => {
                    screen.missing(count);
                    Quality::Missing
                }
            };
            let mut outcome = Outcome::Nothing;
            if let (Arrival::Sample(sample), Quality::Good) = (arrival, quality) {
                let valid = stream.push(sample, &mut row, &mut target);
                if valid {
                    if causal {
                        stream.present(&mut row);
                    }
                    states.extend_from_slice(&row);
                    targets.extend_from_slice(&target);
                    outcome = if causal && !awaiting { Outcome::Evaluated } else { Outcome::Compared };
                }
                awaiting = valid;
            } else {
                stream.reset();
                awaiting = false;
            }
            out.arrivals.push((arrival, quality, outcome));
        }
        out.residuals = self.residuals(&states, &targets, &out.arrivals, usize::from(causal));
        out
    }

    /// Normalised residuals: measured derivatives less the prediction made `lag` rows before, over the healthy spread.
    fn residuals(
        &self,
        states: &[f32],
        targets: &[f32],
        arrivals: &[(Arrival, Quality, Outcome)],
        lag: usize,
    ) -> Vec<f32> {
        let n = self.spec.dimension;
        let predicted = self.predict(states);
        let scaling = &self.model.derivatives;
        let columns: Vec<[f32; 3]> =
            (scaling.mean.iter().zip(scaling.scale.iter()).zip(self.model.residual_spread.iter()))
                .map(|((mean, scale), spread)| [mean, 1.0 / scale, 1.0 / spread])
                .collect();
        let evaluated = arrivals.iter().map(|arrival| arrival.2).filter(|outcome| *outcome != Outcome::Nothing);
        let mut residuals = Vec::with_capacity(targets.len());
        for (row, _) in evaluated.enumerate().filter(|(_, outcome)| *outcome == Outcome::Compared) {
            let (measured, expected) = (&targets[n * row..][..n], &predicted[n * (row - lag)..][..n]);
            let pairs = measured.iter().zip(expected).zip(&columns);
            residuals.extend(pairs.map(|((d, e), [mean, scale, spread])| ((d - mean) * scale - e) * spread));
        }
        residuals
    }

    /// Predicted derivatives of rows of states, in the model's scaled units.
    fn predict(&self, states: &[f32]) -> Vec<f32> {
        let n = self.spec.dimension;
        let mut predicted = vec![0.0; states.len()];
        let parts = states.par_chunks(n * CHUNK * CHUNKS).zip(predicted.par_chunks_mut(n * CHUNK * CHUNKS));
        parts.for_each(|(states, predicted)| match &self.kernel {
            Some(kernel) => self.arch.dispatch(network::Chunks { kernel, states, predicted }),
            None => self.predict_one_by_one(states, predicted),
        });
        predicted
    }

    fn predict_one_by_one(&self, states: &[f32], predicted: &mut [f32]) {
        let n = self.spec.dimension;
        let mut scratch = vec![0.0; scratch_len(self.model)];
        let mut evaluator = Evaluator::new(self.model, &mut scratch).expect("as much scratch as it asks for");
        for (states, predicted) in states.chunks_exact(n).zip(predicted.chunks_exact_mut(n)) {
            predicted.copy_from_slice(evaluator.step_with(states, &[]).predicted);
        }
    }
}

#[cfg(test)]
mod tests;
