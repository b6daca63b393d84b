//! Injection of one fault.

use super::random::Random;
use super::{Fault, Injected};
use crate::source::Arrival;

/// One fault with its random numbers and the rest of its current run.
#[derive(Clone, Debug)]
pub struct Stage {
    fault: Fault,
    random: Random,
    left: u32,
    held: f32,
}

impl Stage {
    /// Stage at a place in the list of faults.
    pub(super) fn new(fault: Fault, seed: u64, place: u64) -> Self {
        Self { fault, random: Random::new(seed, place), left: 0, held: 0.0 }
    }

    /// Passes an arrival on, broken or not; `None` for a sample lost without notice. Missing samples stay missing and
    /// neither begin nor shorten a run.
    pub(super) fn pass(&mut self, arrival: Arrival, injected: &mut Injected) -> Option<Arrival> {
        let Arrival::Sample(sample) = arrival else { return Some(arrival) };
        let broken = match self.fault {
            Fault::Drop { probability } => {
                if self.random.happens(probability) {
                    injected.dropped += 1;
                    return None;
                }
                sample
            }
            Fault::Gap { probability, run } => {
                if self.left == 0 && self.random.happens(probability) {
                    self.left = run;
                }
                if self.left > 0 {
                    self.left -= 1;
                    injected.missing += 1;
                    return Some(Arrival::Missing(1));
                }
                sample
            }
            Fault::Stuck { probability, run } => {
                if self.left > 0 {
                    self.left -= 1;
                    injected.stuck += 1;
                    self.held
                } else {
                    if self.random.happens(probability) {
                        (self.left, self.held) = (run, sample);
                    }
                    sample
                }
            }
            Fault::Saturate { level } => {
                // Not `clamp`, which does not show whether it changed a sample; NaN passes.
                if sample.abs() >= level {
                    injected.saturated += 1;
                    level.copysign(sample)
                } else {
                    sample
                }
            }
            Fault::Nan { probability } => {
                if self.random.happens(probability) {
                    injected.nan += 1;
                    f32::NAN
                } else {
                    sample
                }
            }
            Fault::Flip { probability } => {
                if self.random.happens(probability) {
                    injected.flipped += 1;
                    f32::from_bits(sample.to_bits() ^ (1 << (self.random.next() % 32)))
                } else {
                    sample
                }
            }
        };
        Some(Arrival::Sample(broken))
    }
}
