//! Virtual states, theory (3) to (5) and (102) to (105): finite differences of the measured acceleration, or
//! estimates of them that amplify its noise less.
//!
//! A model of dimension n_MD has n_MD inputs x and n_MD outputs ẋ, each a difference of the
//! acceleration, of orders [`Orders`] at instants [`Alignment`], by an [`Estimator`].
//! Differences are per sample, not per second: a^(k) has the unit of the acceleration.

mod differences;
mod kalman;
mod savitzky_golay;
pub mod settings;
mod spec;

pub use settings::MAX_DIMENSION;
pub use spec::{Alignment, Estimator, Orders, SpecError, StateSpec};

use differences::Differences;
use kalman::Kalman;
use savitzky_golay::SavitzkyGolay;

/// Stream of virtual states from samples; delay lines and windows in caller-supplied memory.
#[derive(Debug)]
pub struct VirtualStates<'s> {
    spec: StateSpec,
    source: Source<'s>,
    /// Samples since the last reset.
    seen: usize,
    /// Samples needed before states and targets exist.
    warm_up: usize,
}

/// Source of the states; of an estimator with the states at the newest sample, whose increments are the targets.
#[derive(Debug)]
enum Source<'s> {
    Differences(Differences<'s>),
    SavitzkyGolay(SavitzkyGolay<'s>, &'s mut [f32]),
    Kalman(Kalman, &'s mut [f32]),
}

impl<'s> VirtualStates<'s> {
    /// Stream before the first sample; `None` if `memory` has fewer than [`StateSpec::memory_len`] floats or the
    /// specification is not valid.
    pub fn new(spec: StateSpec, memory: &'s mut [f32]) -> Option<Self> {
        if !spec.is_valid() {
            return None;
        }
        let memory = memory.get_mut(..spec.memory_len())?;
        let source = match spec.estimator {
            Estimator::Differences => Source::Differences(Differences::new(spec, memory)),
            Estimator::SavitzkyGolay { excess, stretch } => {
                let (newest, memory) = memory.split_at_mut_checked(spec.dimension)?;
                Source::SavitzkyGolay(SavitzkyGolay::new(&spec, excess, stretch, memory)?, newest)
            }
            Estimator::Kalman { cutoff } => Source::Kalman(Kalman::new(spec.highest_state(), cutoff), memory),
        };
        let mut stream = Self { spec, source, seen: 0, warm_up: spec.warm_up() };
        stream.reset();
        Some(stream)
    }

    /// Resets the states: the next sample does not continue the last.
    pub fn reset(&mut self) {
        self.seen = 0;
        match &mut self.source {
            Source::Differences(_) => {}
            Source::SavitzkyGolay(filter, newest) => {
                filter.reset();
                newest.fill(0.0);
            }
            Source::Kalman(filter, newest) => {
                filter.reset();
                newest.fill(0.0);
            }
        }
    }

    /// Takes a sample; true once `states` and `targets` (n_MD values each) are valid, from sample
    /// [`StateSpec::warm_up`] after a reset on. A sample or an estimate that is not finite resets an estimator other
    /// than differences, whose recursion would keep it for ever.
    pub fn push(&mut self, sample: f32, states: &mut [f32], targets: &mut [f32]) -> bool {
        let spec = self.spec;
        let valid = match &mut self.source {
            Source::Differences(differences) => {
                differences.push(sample, states, targets);
                true
            }
            Source::SavitzkyGolay(filter, newest) => {
                filter.push(sample);
                increments(core::iter::once(sample).chain(filter.estimates(spec)), newest, states, targets)
            }
            Source::Kalman(filter, newest) => {
                filter.push(sample);
                let estimates = (1..spec.dimension).map(|i| filter.estimate(spec.orders.state(i)));
                increments(core::iter::once(sample).chain(estimates), newest, states, targets)
            }
        };
        if !valid {
            self.reset();
            return false;
        }
        // Wraps after 2^32 samples on the device, two days at 25.6 kHz, and then warms up again.
        self.seen = self.seen.wrapping_add(1);
        self.seen >= self.warm_up
    }

    /// Causal states of the newest sample, whose targets are not known yet.
    pub fn present(&self, states: &mut [f32]) {
        match &self.source {
            Source::Differences(differences) => {
                for (i, state) in states.iter_mut().take(self.spec.dimension).enumerate() {
                    *state = differences.newest(self.spec.orders.state(i));
                }
            }
            Source::SavitzkyGolay(_, newest) | Source::Kalman(_, newest) => {
                states.iter_mut().zip(newest.iter()).for_each(|(state, newest)| *state = *newest);
            }
        }
    }
}

/// Replaces the states of the last sample by those of the newest: the old ones go to `states`, their increments to
/// `targets`. False if an increment is not finite.
fn increments(
    estimates: impl Iterator<Item = f32>,
    newest: &mut [f32],
    states: &mut [f32],
    targets: &mut [f32],
) -> bool {
    let mut finite = true;
    for ((estimate, newest), (state, target)) in estimates.zip(newest).zip(states.iter_mut().zip(targets)) {
        *state = core::mem::replace(newest, estimate);
        *target = estimate - *state;
        finite &= target.is_finite();
    }
    finite
}

#[cfg(test)]
mod tests;
