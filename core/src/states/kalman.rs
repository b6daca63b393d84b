//! Kalman differentiating observer, theory (103) to (105).
//!
//! The measured acceleration is taken as a signal whose difference of order m + 1 is white noise, plus white
//! measurement noise: a chain of m + 1 integrators. The states are the differences ∇^k of the filtered signal, k = 0…m,
//! at the newest sample; without measurement noise they are the differences of the samples.
//!
//! In differences the chain's transition is a sum, so that a step costs m additions and m + 1 multiply-adds; a product
//! with the transition matrix would cost its square. The stationary gain has a closed form, theory (105): the roots of
//! the spectral factor lie on a Butterworth circle. So no Riccati equation is iterated on the device, in software
//! doubles on 16 × 16 matrices; the tests do that.

use nalgebra::{Complex, SVector};

use super::settings::{MAX_ESTIMATED_ORDER, SETTLED};
use crate::math::double;

/// Length of the chain of integrators.
pub(super) const CHAIN: usize = MAX_ESTIMATED_ORDER + 1;

/// Stationary Kalman filter; its memory does not depend on the order.
#[derive(Debug)]
pub(super) struct Kalman {
    /// Differences of order 0, 1, … of the filtered signal at the newest sample; 0 above the highest order.
    state: SVector<f32, CHAIN>,
    /// Gain of each difference; 0 above the highest order.
    gain: SVector<f32, CHAIN>,
    /// Whether there was a sample since the last reset.
    started: bool,
}

impl Kalman {
    /// Filter for differences up to `highest`, at most [`MAX_ESTIMATED_ORDER`], before the first sample.
    pub(super) fn new(highest: usize, cutoff: f32) -> Self {
        Self { state: SVector::zeros(), gain: gain(highest, cutoff), started: false }
    }

    /// Forgets all samples.
    pub(super) fn reset(&mut self) {
        self.state = SVector::zeros();
        self.started = false;
    }

    /// Takes a sample.
    pub(super) fn push(&mut self, sample: f32) {
        if !self.started {
            // A constant signal settles at once.
            self.started = true;
            if let Some(signal) = self.state.as_mut_slice().first_mut() {
                *signal = sample;
            }
            return;
        }
        let mut higher = 0.0;
        for difference in self.state.as_mut_slice().iter_mut().rev() {
            *difference += higher;
            higher = *difference;
        }
        // The last sum is the predicted sample.
        self.state += self.gain * (sample - higher);
    }

    /// Estimate of ∇^order of the signal at the newest sample.
    pub(super) fn estimate(&self, order: usize) -> f32 {
        self.state.as_slice().get(order).copied().unwrap_or(0.0)
    }
}

/// Samples until the slowest mode of the filter has decayed to [`SETTLED`].
pub(super) fn settling(highest: usize, cutoff: f32) -> usize {
    // The root next to the unit circle.
    let slowest = double::sqrt(root(0, highest + 1, cutoff).norm_sqr());
    let (mut samples, mut left) = (0, 1.0);
    while left > SETTLED {
        left *= slowest;
        samples += 1;
    }
    samples
}

/// Stationary gain of the filter for differences up to `highest`, theory (105).
// Not inlined, so that its vectors are on the stack only while it runs.
#[inline(never)]
pub(super) fn gain(highest: usize, cutoff: f32) -> SVector<f32, CHAIN> {
    // Spectral factor Π (1 − ρ + ρ ∇) as a polynomial in ∇; its coefficients are real once all roots are in.
    let mut factor = SVector::<Complex<f64>, { CHAIN + 1 }>::zeros();
    if let Some(constant) = factor.as_mut_slice().first_mut() {
        *constant = Complex::new(1.0, 0.0);
    }
    for i in 0..=highest {
        let root = root(i, highest + 1, cutoff);
        let mut below = Complex::new(0.0, 0.0);
        for coefficient in factor.as_mut_slice() {
            let old = *coefficient;
            *coefficient = old * (Complex::new(1.0, 0.0) - root) + below * root;
            below = old;
        }
    }
    let mut gain = SVector::<f32, CHAIN>::zeros();
    let mut sum = 0.0;
    for (gain, coefficient) in gain.as_mut_slice().iter_mut().take(highest + 1).rev().zip(factor.as_slice()) {
        sum += coefficient.re;
        *gain = sum as f32;
    }
    gain
}

/// Root `i` of `count` of the spectral factor, theory (105): inside the unit circle, 2 − ρ − 1/ρ = x_i.
fn root(i: usize, count: usize, cutoff: f32) -> Complex<f64> {
    let (_, sine) = double::cos_sin(core::f64::consts::PI * f64::from(cutoff));
    let (cos, sin) = double::cos_sin(core::f64::consts::PI * (2 * i + 1) as f64 / count as f64);
    let power = 4.0 * sine * sine;
    let sum = Complex::new(2.0 - power * cos, -power * sin);
    let difference = square_root(sum * sum - Complex::new(4.0, 0.0));
    let (one, other) = ((sum + difference) * 0.5, (sum - difference) * 0.5);
    let outside = if one.norm_sqr() > other.norm_sqr() { one } else { other };
    // The roots' product is 1, and a quotient has no cancellation.
    outside.conj() * (1.0 / outside.norm_sqr())
}

/// Square root with a real part that is not negative.
fn square_root(z: Complex<f64>) -> Complex<f64> {
    let magnitude = double::sqrt(z.norm_sqr());
    let greater = double::sqrt((magnitude + z.re.abs()) * 0.5);
    if greater == 0.0 {
        return Complex::new(0.0, 0.0);
    }
    let lesser = z.im.abs() / (2.0 * greater);
    let (re, im) = if z.re >= 0.0 { (greater, lesser) } else { (lesser, greater) };
    Complex::new(re, if z.im < 0.0 { -im } else { im })
}
