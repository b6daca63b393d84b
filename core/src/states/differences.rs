//! Finite differences of the samples, theory (3) and (5).

use super::settings::MAX_DIMENSION;
use super::spec::StateSpec;

/// Backward differences of the newest sample, delayed to the model's instants.
#[derive(Debug)]
pub(super) struct Differences<'s> {
    /// Backward differences ∇^k of the newest sample, k = 0…highest.
    newest: [f32; 2 * MAX_DIMENSION],
    delays: &'s mut [f32],
}

impl<'s> Differences<'s> {
    /// Differences before the first sample.
    pub(super) fn new(delays: &'s mut [f32]) -> Self {
        Self { newest: [0.0; 2 * MAX_DIMENSION], delays }
    }

    /// Takes sample number `seen` since the last reset. Differences that reach over a reset are never given out:
    /// [`StateSpec::warm_up`] is as long as the longest.
    pub(super) fn push(
        &mut self,
        sample: f32,
        seen: usize,
        spec: StateSpec,
        states: &mut [f32],
        targets: &mut [f32],
    ) -> Option<()> {
        let highest = spec.orders.highest(spec.dimension);
        let mut difference = sample;
        for previous in self.newest.iter_mut().take(highest + 1) {
            let next = difference - *previous;
            *previous = difference;
            difference = next;
        }
        let mut lines = &mut *self.delays;
        for i in 0..spec.dimension {
            let order = spec.orders.state(i);
            for (order, target, out) in [(order, false, states.get_mut(i)), (order + 1, true, targets.get_mut(i))] {
                let newest = self.newest.get(order).copied().unwrap_or(0.0);
                let delay = spec.delay(order, target);
                let (line, rest) = core::mem::take(&mut lines).split_at_mut_checked(delay)?;
                lines = rest;
                let value = match line.len() {
                    0 => newest,
                    length => match line.get_mut(seen % length) {
                        Some(slot) => core::mem::replace(slot, newest),
                        None => newest,
                    },
                };
                if let Some(out) = out {
                    *out = value;
                }
            }
        }
        Some(())
    }

    /// Backward difference ∇^order of the newest sample; order 0 is the sample itself.
    pub(super) fn newest(&self, order: usize) -> f32 {
        self.newest.get(order).copied().unwrap_or(0.0)
    }
}
