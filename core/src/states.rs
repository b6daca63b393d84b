//! Virtual states, theory (3) to (5): finite differences of the measured acceleration.
//!
//! A model of dimension n_MD has n_MD inputs x and n_MD outputs ẋ, each a finite difference of the
//! acceleration, of orders [`Orders`] at instants [`Alignment`].
//! Differences are per sample, not per second: a^(k) has the unit of the acceleration.

use serde::{Deserialize, Serialize};

/// Greatest model dimension n_MD.
pub const MAX_DIMENSION: usize = 16;

/// Orders of the differences that are states and targets, theory (4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(rename_all = "kebab-case")]
pub enum Orders {
    /// Even orders: states a^(0), a^(2), …, a^(2(n−1)); targets a^(1), a^(3), …, a^(2n−1).
    Even,
    /// Consecutive orders: states a^(0), a^(1), …, a^(n−1); targets one order higher.
    Consecutive,
}

impl Orders {
    /// Order of state `i`; its target is one order higher.
    pub const fn state(self, i: usize) -> usize {
        match self {
            Orders::Even => 2 * i,
            Orders::Consecutive => i,
        }
    }

    /// Highest order a model of dimension `n` needs.
    pub const fn highest(self, n: usize) -> usize {
        self.state(n.saturating_sub(1)) + 1
    }
}

/// Instants of states and targets, theory (5), with Δ the forward and ∇ the backward difference of sample a\[t\].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(rename_all = "kebab-case")]
pub enum Alignment {
    /// Forward differences at one index: x_i = Δ^k a\[t\], ẋ_i = Δ^(k+1) a\[t\].
    Forward,
    /// Centred differences: order k starts at t − ⌊k/2⌋, so even orders are centred on t and
    /// odd ones half a sample later.
    Half,
    /// Backward differences of samples up to t as states, of sample t + 1 as targets, which are
    /// the states' increments: ẋ_i = ∇^(k+1) a\[t+1\] = ∇^k a\[t+1\] − ∇^k a\[t\].
    Causal,
}

/// Specification of a model's virtual states.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StateSpec {
    /// Model dimension n_MD, 1 (SISO) to [`MAX_DIMENSION`].
    pub dimension: usize,
    /// Orders of states and targets.
    pub orders: Orders,
    /// Instants of states and targets.
    pub alignment: Alignment,
}

impl StateSpec {
    /// Whether the dimension is in range.
    pub const fn is_valid(&self) -> bool {
        self.dimension >= 1 && self.dimension <= MAX_DIMENSION
    }

    /// Delay, in samples, from the newest sample that Δ^order at the model's instant uses to the newest sample
    /// (for the causal alignment: 1 for states, 0 for targets).
    const fn delay(&self, order: usize, target: bool) -> usize {
        match self.alignment {
            Alignment::Forward => self.orders.highest(self.dimension) - order,
            Alignment::Half => self.half_span() - order.div_ceil(2),
            Alignment::Causal => !target as usize,
        }
    }

    /// Samples after t that the centred differences reach.
    const fn half_span(&self) -> usize {
        self.orders.highest(self.dimension).div_ceil(2)
    }

    /// Samples needed before the first states and targets exist.
    pub const fn warm_up(&self) -> usize {
        let highest = self.orders.highest(self.dimension);
        let mut samples = highest + self.delay(highest, true);
        let mut i = 0;
        while i < self.dimension {
            let order = self.orders.state(i);
            let for_state = order + self.delay(order, false);
            if for_state > samples {
                samples = for_state;
            }
            i += 1;
        }
        samples + 1
    }

    /// Number of floats of the delay lines of [`VirtualStates`].
    pub const fn delay_len(&self) -> usize {
        let mut total = 0;
        let mut i = 0;
        while i < self.dimension {
            let order = self.orders.state(i);
            total += self.delay(order, false) + self.delay(order + 1, true);
            i += 1;
        }
        total
    }
}

/// Stream of virtual states from samples; ring buffers in caller-supplied memory.
#[derive(Debug)]
pub struct VirtualStates<'s> {
    spec: StateSpec,
    /// Backward differences ∇^k of the newest sample, k = 0…highest.
    differences: [f32; 2 * MAX_DIMENSION],
    delays: &'s mut [f32],
    /// Samples since the last reset.
    seen: usize,
}

impl<'s> VirtualStates<'s> {
    /// Stream before the first sample; `None` if `delays` has fewer than [`StateSpec::delay_len`] floats or the
    /// dimension is out of range.
    pub fn new(spec: StateSpec, delays: &'s mut [f32]) -> Option<Self> {
        if !spec.is_valid() {
            return None;
        }
        let delays = delays.get_mut(..spec.delay_len())?;
        Some(Self { spec, differences: [0.0; 2 * MAX_DIMENSION], delays, seen: 0 })
    }

    /// Resets the differences: the next sample does not continue the last.
    pub fn reset(&mut self) {
        self.seen = 0;
    }

    /// Takes a sample; true once `states` and `targets` (n_MD values each) are valid, from sample
    /// [`StateSpec::warm_up`] after a reset on.
    pub fn push(&mut self, sample: f32, states: &mut [f32], targets: &mut [f32]) -> bool {
        let highest = self.spec.orders.highest(self.spec.dimension);
        let mut difference = sample;
        for previous in self.differences.iter_mut().take(highest + 1) {
            let next = difference - *previous;
            *previous = difference;
            difference = next;
        }
        let mut lines = &mut *self.delays;
        for i in 0..self.spec.dimension {
            let order = self.spec.orders.state(i);
            for (order, target, out) in [(order, false, states.get_mut(i)), (order + 1, true, targets.get_mut(i))] {
                let newest = self.differences.get(order).copied().unwrap_or(0.0);
                let delay = self.spec.delay(order, target);
                let Some((line, rest)) = core::mem::take(&mut lines).split_at_mut_checked(delay) else { return false };
                lines = rest;
                let value = match line.len() {
                    0 => newest,
                    length => match line.get_mut(self.seen % length) {
                        Some(slot) => core::mem::replace(slot, newest),
                        None => newest,
                    },
                };
                if let Some(out) = out {
                    *out = value;
                }
            }
        }
        // Wraps after 2^32 samples on the device, two days at 25.6 kHz, and then warms up again.
        self.seen = self.seen.wrapping_add(1);
        self.seen >= self.spec.warm_up()
    }

    /// Backward difference ∇^order of the newest sample; order 0 is the sample itself.
    pub fn newest(&self, order: usize) -> f32 {
        self.differences.get(order).copied().unwrap_or(0.0)
    }

    /// Causal states ∇^k a\[t\] of the newest sample, whose targets are not known yet.
    pub fn present(&self, states: &mut [f32]) {
        for (i, state) in states.iter_mut().take(self.spec.dimension).enumerate() {
            *state = self.newest(self.spec.orders.state(i));
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    /// Definition, written out: Δ^k by repeated differencing of the whole recording.
    fn reference(a: &[f32], spec: StateSpec) -> Vec<(Vec<f32>, Vec<f32>)> {
        let highest = spec.orders.highest(spec.dimension);
        let mut d = std::vec![a.to_vec()];
        for k in 0..highest {
            d.push(d[k].windows(2).map(|w| w[1] - w[0]).collect());
        }
        let at =
            |k: usize, start: isize| -> Option<f32> { usize::try_from(start).ok().and_then(|s| d[k].get(s).copied()) };
        (0..a.len() as isize)
            .filter_map(|t| {
                let pick = |k: usize, target: bool| match spec.alignment {
                    Alignment::Forward => at(k, t),
                    Alignment::Half => at(k, t - (k / 2) as isize),
                    Alignment::Causal => at(k, t + target as isize - k as isize),
                };
                let n = spec.dimension;
                let x: Option<Vec<f32>> = (0..n).map(|i| pick(spec.orders.state(i), false)).collect();
                let y: Option<Vec<f32>> = (0..n).map(|i| pick(spec.orders.state(i) + 1, true)).collect();
                Some((x?, y?))
            })
            .collect()
    }

    #[test]
    fn streaming_equals_the_definition_for_every_dimension_order_and_alignment() {
        let a: Vec<f32> = (0..80).map(|i| ((i * i * 7919) % 1000) as f32 / 250.0 - 2.0).collect();
        for dimension in 1..=MAX_DIMENSION {
            for orders in [Orders::Even, Orders::Consecutive] {
                for alignment in [Alignment::Forward, Alignment::Half, Alignment::Causal] {
                    let spec = StateSpec { dimension, orders, alignment };
                    let mut delays = std::vec![f32::NAN; spec.delay_len()];
                    let mut streaming = VirtualStates::new(spec, &mut delays).unwrap();
                    for _ in 0..2 {
                        // Twice: a reset must leave nothing behind.
                        streaming.reset();
                        let (mut x, mut y) = (std::vec![0.0; dimension], std::vec![0.0; dimension]);
                        let got: Vec<_> = a
                            .iter()
                            .filter_map(|&s| {
                                if streaming.push(s, &mut x, &mut y) { Some((x.clone(), y.clone())) } else { None }
                            })
                            .collect();
                        assert_eq!(got, reference(&a, spec), "{spec:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn causal_targets_are_the_increments_of_the_states() {
        let spec = StateSpec { dimension: 4, orders: Orders::Even, alignment: Alignment::Causal };
        let a: Vec<f32> = (0..40).map(|i| ((i * i) % 17) as f32).collect();
        let rows = reference(&a, spec);
        for pair in rows.windows(2) {
            for i in 0..4 {
                assert_eq!(pair[0].1[i], pair[1].0[i] - pair[0].0[i]);
            }
        }
    }

    #[test]
    fn refuses_what_it_cannot_stream() {
        let spec = |dimension| StateSpec { dimension, orders: Orders::Even, alignment: Alignment::Half };
        assert!(VirtualStates::new(spec(0), &mut [0.0; 9]).is_none());
        assert!(VirtualStates::new(spec(17), &mut [0.0; 900]).is_none());
        assert!(VirtualStates::new(spec(3), &mut [0.0; 8]).is_none());
        assert!(VirtualStates::new(spec(3), &mut [0.0; 9]).is_some());
    }
}
