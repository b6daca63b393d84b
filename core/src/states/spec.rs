//! Specification of virtual states: orders, instants and estimator.

use serde::{Deserialize, Serialize};

use super::settings::{MAX_DIMENSION, MAX_ESTIMATED_ORDER, MAX_EXCESS, MAX_STRETCH, MAX_WINDOW, MIN_CUTOFF};
use super::{kalman, savitzky_golay};

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

/// Estimator of the states of order 1 and above; state a^(0) is always the sample itself.
///
/// All but [`Estimator::Differences`] need [`Alignment::Causal`] and orders up to [`MAX_ESTIMATED_ORDER`]: they
/// estimate order k per sample^k at the newest sample from samples up to it, and the target of a state is its
/// increment over one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Estimator {
    /// Finite differences, theory (3).
    #[default]
    Differences,
    /// Savitzky–Golay derivatives at the newest sample, theory (102): order k by least squares of a polynomial of
    /// degree k + `excess` in a window of `stretch` times as many samples as it has coefficients.
    SavitzkyGolay {
        /// Degree of the polynomial above the order, 0 to [`MAX_EXCESS`].
        excess: u8,
        /// Samples of a window for each coefficient, 1 (the polynomial meets every sample) to [`MAX_STRETCH`].
        stretch: f32,
    },
    /// Differences of the stationary Kalman filter of a chain of integrators, theory (103) to (105).
    Kalman {
        /// Frequency, in cycles a sample, at which signal and measurement noise of the filter's model have the same
        /// density; [`MIN_CUTOFF`] to below 0.5.
        cutoff: f32,
    },
}

/// Specification of a model's virtual states.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StateSpec {
    /// Model dimension n_MD, 1 (SISO) to [`MAX_DIMENSION`].
    pub dimension: usize,
    /// Orders of states and targets.
    pub orders: Orders,
    /// Instants of states and targets.
    pub alignment: Alignment,
    /// Estimator of the states.
    pub estimator: Estimator,
}

/// Reason why a [`StateSpec`] cannot be streamed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SpecError {
    /// Dimension out of range.
    Dimension {
        /// Dimension found.
        found: usize,
    },
    /// An estimator other than differences outside of the causal alignment.
    NotCausal {
        /// Alignment found.
        found: Alignment,
    },
    /// States of an order that the estimator does not reach.
    Order {
        /// Highest order found.
        found: usize,
    },
    /// Excess degree out of range.
    Excess {
        /// Excess degree found.
        found: u8,
    },
    /// Stretch out of range.
    Stretch {
        /// Stretch found.
        found: f32,
    },
    /// Longest window out of range.
    Window {
        /// Samples found.
        found: usize,
    },
    /// Cut-off out of range.
    Cutoff {
        /// Cut-off found, cycles a sample.
        found: f32,
    },
}

impl core::fmt::Display for SpecError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Dimension { found } => write!(f, "n_MD {found}: expected 1 to {MAX_DIMENSION}"),
            Self::NotCausal { found } => {
                write!(f, "alignment {found:?}: expected the causal alignment, which the estimator of the states needs")
            }
            Self::Order { found } => {
                write!(f, "states of order {found}: expected at most {MAX_ESTIMATED_ORDER} for this estimator")
            }
            Self::Excess { found } => write!(f, "excess degree {found}: expected 0 to {MAX_EXCESS}"),
            Self::Stretch { found } => write!(f, "stretch of the windows {found}: expected 1 to {MAX_STRETCH}"),
            Self::Window { found } => {
                write!(
                    f,
                    "windows of up to {found} samples: expected at most {MAX_WINDOW}, by a smaller stretch or n_MD"
                )
            }
            Self::Cutoff { found } => {
                write!(f, "cut-off {found} cycles a sample: expected {MIN_CUTOFF} to below 0.5")
            }
        }
    }
}

impl core::error::Error for SpecError {}

impl StateSpec {
    /// Checks that the states can be streamed.
    ///
    /// # Errors
    /// [`SpecError`] of the first part that is out of range.
    pub fn check(&self) -> Result<(), SpecError> {
        if self.dimension < 1 || self.dimension > MAX_DIMENSION {
            return Err(SpecError::Dimension { found: self.dimension });
        }
        if self.estimator == Estimator::Differences {
            return Ok(());
        }
        if self.alignment != Alignment::Causal {
            return Err(SpecError::NotCausal { found: self.alignment });
        }
        let highest = self.highest_state();
        if highest > MAX_ESTIMATED_ORDER {
            return Err(SpecError::Order { found: highest });
        }
        match self.estimator {
            Estimator::SavitzkyGolay { excess, .. } if excess > MAX_EXCESS => Err(SpecError::Excess { found: excess }),
            Estimator::SavitzkyGolay { stretch, .. } if !(1.0..=MAX_STRETCH).contains(&stretch) => {
                Err(SpecError::Stretch { found: stretch })
            }
            Estimator::SavitzkyGolay { excess, stretch } => match savitzky_golay::window(highest, excess, stretch) {
                found if found > MAX_WINDOW => Err(SpecError::Window { found }),
                _ => Ok(()),
            },
            Estimator::Kalman { cutoff } if !(MIN_CUTOFF..0.5).contains(&cutoff) => {
                Err(SpecError::Cutoff { found: cutoff })
            }
            _ => Ok(()),
        }
    }

    /// Whether the states can be streamed.
    pub fn is_valid(&self) -> bool {
        self.check().is_ok()
    }

    /// Highest order among the states.
    pub(super) const fn highest_state(&self) -> usize {
        self.orders.highest(self.dimension) - 1
    }

    /// Delay, in samples, from the newest sample that Δ^order at the model's instant uses to the newest sample
    /// (for the causal alignment: 1 for states, 0 for targets).
    pub(super) const fn delay(&self, order: usize, target: bool) -> usize {
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
    pub fn warm_up(&self) -> usize {
        match self.estimator {
            Estimator::Differences => self.warm_up_of_differences(),
            // One sample more for the increments.
            Estimator::SavitzkyGolay { excess, stretch } => {
                savitzky_golay::window(self.highest_state(), excess, stretch) + 1
            }
            Estimator::Kalman { cutoff } => kalman::settling(self.highest_state(), cutoff) + 1,
        }
    }

    const fn warm_up_of_differences(&self) -> usize {
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

    /// Number of floats that [`super::VirtualStates`] needs: delay lines, and windows with their weights.
    pub fn memory_len(&self) -> usize {
        let of_estimator = match self.estimator {
            Estimator::SavitzkyGolay { excess, stretch } => savitzky_golay::memory_len(self, excess, stretch),
            Estimator::Differences | Estimator::Kalman { .. } => 0,
        };
        let mut total = of_estimator;
        for i in 0..self.dimension {
            let order = self.orders.state(i);
            total += self.delay(order, false) + self.delay(order + 1, true);
        }
        total
    }
}
