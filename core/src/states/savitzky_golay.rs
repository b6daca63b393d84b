//! Savitzky–Golay derivatives at the newest sample, theory (102).
//!
//! Order k is the k-th derivative, per sample^k, of the least-squares polynomial of degree k + e through the last w_k
//! samples. A window of its own for each order leaves low orders little delayed and smooths high ones; with e = 0 and
//! windows of k + 1 samples the estimates are the backward differences.
//!
//! Gram's polynomials (discrete Chebyshev) are orthonormal on the window, so that no system is solved: that of
//! monomials of the sample's index has a condition number of 1e20 at degree 14. They are found once, by recurrence, in
//! `f64`: in `f32` the weights of order 14 would be off by up to 3e-4. The weights are then `f32`, and a device's step
//! is plain sums.

use nalgebra::SVector;

use super::settings::{MAX_ESTIMATED_ORDER, MAX_WINDOW};
use super::spec::StateSpec;
use crate::math::double;

/// Samples in the window of order `order`, the next whole number from (order + excess + 1) · stretch.
pub(super) const fn window(order: usize, excess: u8, stretch: f32) -> usize {
    let exact = (order + excess as usize + 1) as f32 * stretch;
    let whole = exact as usize;
    if exact > whole as f32 { whole + 1 } else { whole }
}

/// Number of floats of [`SavitzkyGolay`]: the longest window, and the weights of all.
pub(super) fn memory_len(spec: &StateSpec, excess: u8, stretch: f32) -> usize {
    let weights: usize = (1..spec.dimension).map(|i| window(spec.orders.state(i), excess, stretch)).sum();
    window(spec.highest_state(), excess, stretch) + weights
}

/// Windows over the newest samples, with their weights.
#[derive(Debug)]
pub(super) struct SavitzkyGolay<'s> {
    excess: u8,
    stretch: f32,
    /// Newest samples, as a ring.
    history: &'s mut [f32],
    /// Place in the ring of the oldest sample, which the next replaces.
    oldest: usize,
    /// Weights of state 1, 2, …, each from the oldest sample to the newest.
    weights: &'s [f32],
}

impl<'s> SavitzkyGolay<'s> {
    /// Windows before the first sample; `None` if `memory` is shorter than [`memory_len`].
    pub(super) fn new(spec: &StateSpec, excess: u8, stretch: f32, memory: &'s mut [f32]) -> Option<Self> {
        let memory = memory.get_mut(..memory_len(spec, excess, stretch))?;
        let (history, weights) = memory.split_at_mut_checked(window(spec.highest_state(), excess, stretch))?;
        let mut rest = &mut *weights;
        for i in 1..spec.dimension {
            let order = spec.orders.state(i);
            let (line, left) = rest.split_at_mut_checked(window(order, excess, stretch))?;
            end_point_weights(order + usize::from(excess), order, line);
            rest = left;
        }
        Some(Self { excess, stretch, history, oldest: 0, weights })
    }

    /// Forgets all samples.
    pub(super) fn reset(&mut self) {
        self.history.fill(0.0);
        self.oldest = 0;
    }

    /// Takes a sample.
    pub(super) fn push(&mut self, sample: f32) {
        if let Some(slot) = self.history.get_mut(self.oldest) {
            *slot = sample;
        }
        self.oldest = if self.oldest + 1 < self.history.len() { self.oldest + 1 } else { 0 };
    }

    /// Estimates of state 1, 2, … of the specification, at the newest sample.
    pub(super) fn estimates(&self, spec: StateSpec) -> impl Iterator<Item = f32> + '_ {
        let (newer, older) = self.history.split_at_checked(self.oldest).unwrap_or((&[], &[]));
        let mut rest = self.weights;
        (1..spec.dimension).map_while(move |i| {
            let length = window(spec.orders.state(i), self.excess, self.stretch);
            let (weights, left) = rest.split_at_checked(length)?;
            rest = left;
            let samples = older.iter().chain(newer).skip(self.history.len().saturating_sub(length));
            Some(weights.iter().zip(samples).fold(0.0, |sum, (weight, sample)| sum + weight * sample))
        })
    }
}

/// Weights, from the oldest sample to the newest, of the `order`-th derivative per sample^`order` at the newest sample
/// of the least-squares polynomial of degree `degree` through `weights.len()` samples.
///
/// Shapes: `order` ≤ `degree` < `weights.len()` ≤ [`MAX_WINDOW`], `order` ≤ [`MAX_ESTIMATED_ORDER`]; else the weights
/// are without meaning.
// Not inlined, so that its vectors are on the stack only while it runs.
#[inline(never)]
pub(super) fn end_point_weights(degree: usize, order: usize, weights: &mut [f32]) {
    type Samples = SVector<f64, MAX_WINDOW>;
    let count = weights.len();
    // The window in units of its half, −1…1, so that derivatives of high order stay in range.
    let half = (count.max(2) - 1) as f64 / 2.0;
    let inside = |i: usize, value: f64| if i < count { value } else { 0.0 };
    let place = Samples::from_fn(|i, _| inside(i, i as f64 / half - 1.0));
    // Coefficient of the recurrence t P_j = c_(j+1) P_(j+1) + c_j P_(j−1).
    let coefficient = |j: usize| {
        let (j, n) = (j as f64, count as f64);
        double::sqrt(j * j * (n * n - j * j) / (4.0 * (4.0 * j * j - 1.0))) / half
    };
    let first = 1.0 / double::sqrt(count as f64);
    let (mut before, mut polynomial) = (Samples::zeros(), Samples::from_fn(|i, _| inside(i, first)));
    // Derivatives of order 0, 1, … of the polynomial and of the one before at the window's end, where t = 1.
    let mut ends = [(0.0, 0.0); MAX_ESTIMATED_ORDER + 1];
    if let Some((end, _)) = ends.first_mut() {
        *end = first;
    }
    let mut sum = Samples::zeros();
    for j in 0..=degree {
        let share = ends.get(order).map_or(0.0, |(end, _)| *end);
        sum.zip_apply(&polynomial, |sum, value| *sum += share * value);
        let (this, next) = (if j == 0 { 0.0 } else { coefficient(j) }, coefficient(j + 1));
        let after = place.zip_zip_map(&polynomial, &before, |u, value, before| (u * value - this * before) / next);
        (before, polynomial) = (polynomial, after);
        // Of t P: t P^(r) + r P^(r−1).
        let mut lower = 0.0;
        for (r, (end, end_before)) in ends.iter_mut().enumerate().take(order + 1) {
            let after = (*end + r as f64 * lower - this * *end_before) / next;
            lower = *end;
            (*end_before, *end) = (*end, after);
        }
    }
    let unit = (0..order).fold(1.0, |product, _| product * half);
    weights.iter_mut().zip(sum.iter()).for_each(|(weight, sum)| *weight = (sum / unit) as f32);
}
