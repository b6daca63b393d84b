//! Finite differences of the samples, theory (3) and (5).

use super::settings::MAX_DIMENSION;
use super::spec::StateSpec;

/// Orders of the highest dimension, 0 to 31.
const ORDERS: usize = 2 * MAX_DIMENSION;

/// Backward differences of the newest sample, delayed to the model's instants.
#[derive(Debug)]
pub(super) struct Differences<'s> {
    /// Backward differences ∇^k of the newest sample, k = 0…highest.
    newest: [f32; ORDERS],
    /// Number of differences in use.
    count: usize,
    /// Delay of each state, and of its target.
    delays: [[Delay; 2]; MAX_DIMENSION],
    /// Delay lines, one behind the other in the order of `delays`.
    memory: &'s mut [f32],
}

/// Delay of one difference by its line, which begins where the line before it ends.
#[derive(Clone, Copy, Debug, Default)]
struct Delay {
    order: u8,
    /// Position of the oldest difference in the memory; [`NO_LINE`] without delay.
    oldest: u16,
    end: u16,
}

/// Position beyond every memory.
const NO_LINE: u16 = u16::MAX;

impl<'s> Differences<'s> {
    /// Differences before the first sample, with the lines in `memory`.
    pub(super) fn new(spec: StateSpec, memory: &'s mut [f32]) -> Self {
        let mut end = 0;
        let mut delay = |order: usize, target| {
            let first = end;
            end += spec.delay(order, target) as u16;
            Delay { order: order as u8, oldest: if first < end { first } else { NO_LINE }, end }
        };
        let mut delays = [[Delay::default(); 2]; MAX_DIMENSION];
        for (i, delays) in delays.iter_mut().take(spec.dimension).enumerate() {
            let order = spec.orders.state(i);
            *delays = [delay(order, false), delay(order + 1, true)];
        }
        Self { newest: [0.0; ORDERS], count: spec.orders.highest(spec.dimension) + 1, delays, memory }
    }

    /// Takes a sample. Differences that reach over a reset are never given out: [`StateSpec::warm_up`] is as long as the
    /// longest.
    pub(super) fn push(&mut self, sample: f32, states: &mut [f32], targets: &mut [f32]) {
        let mut difference = sample;
        for previous in self.newest.iter_mut().take(self.count) {
            let next = difference - *previous;
            *previous = difference;
            difference = next;
        }
        let mut first = 0;
        for ([of_state, of_target], (state, target)) in self.delays.iter_mut().zip(states.iter_mut().zip(targets)) {
            for (delay, out) in [(of_state, state), (of_target, target)] {
                let newest = self.newest[usize::from(delay.order) % ORDERS];
                *out = match self.memory.get_mut(usize::from(delay.oldest)) {
                    Some(oldest) => {
                        let next = delay.oldest.wrapping_add(1);
                        delay.oldest = if next == delay.end { first } else { next };
                        core::mem::replace(oldest, newest)
                    }
                    None => newest,
                };
                first = delay.end;
            }
        }
    }

    /// Backward difference ∇^order of the newest sample; order 0 is the sample itself.
    pub(super) fn newest(&self, order: usize) -> f32 {
        self.newest.get(order).copied().unwrap_or(0.0)
    }
}
