//! The device half of ballrace: a SINDy-NN model evaluated sample by sample, inside fixed memory.
//!
//! Data flows one way, and each module knows only the ones before it:
//!
//! | module | holds | takes → gives |
//! |---|---|---|
//! | [`math`] | exp, ln, sigmoid, sin, cos, sqrt, for host and device | |
//! | [`crc`] | CRC-32 | |
//! | `hardware` | dual multiply-accumulate, words at their alignment; the only `unsafe` | |
//! | [`states`] | virtual states: finite differences of the acceleration, or estimates that amplify its noise less | sample → x, ẋ |
//! | [`library`] | candidate functions Θ(z), their order and names | z → θ |
//! | [`network`] | dense layers: encoder φ and decoder ψ, in single precision or fixed point | x → z |
//! | [`dynamics`] | the sparse Ξ | z → ż = Θ(z) Ξ |
//! | [`model`] | all of the above as one value; binary form used in place from flash; JSON | bytes → model |
//! | [`evaluator`] | one step: states, z, ż, predicted derivatives, predicted next sample | sample → prediction |
//! | [`input_check`] | non-finite, saturated, stuck and missing samples, counted | sample → quality |
//! | [`monitor`] | EWMA of the logarithm of the normalised residual's level, limit, hysteresis | residual → status |
//! | [`device`] | screen, evaluator and monitor in one call per sample | sample → result, status |
//! | [`telemetry`] | messages to the broker of a fleet, 124 bytes with a CRC-32 | status, statistics → bytes |
//! | [`update`] | two slots of flash: an update is validated, on trial, confirmed or rolled back | flash → model |
//!
//! The arithmetic is plain `f32` multiplications and additions in a stated order and the functions of
//! [`math`], so a host and a Cortex-M agree to the bit; what is found once, the weights and gains of
//! [`states`], is plain `f64`. Of `nalgebra` only element-wise operations are used: its products take another order of
//! sums where `std` is on. Nothing allocates and nothing panics; all
//! memory that depends on a model's size is a scratch slice from the caller, whose length
//! [`device::Device::scratch_len`] states.
#![no_std]
#![deny(unsafe_code)]
#![deny(missing_docs)]

pub mod crc;
pub mod device;
pub mod dynamics;
pub mod evaluator;
mod hardware;
pub mod input_check;
pub mod library;
pub mod math;
pub mod model;
pub mod monitor;
pub mod network;
pub mod states;
pub mod telemetry;
#[cfg(test)]
mod testing;
pub mod update;

/// A 32-bit little-endian word in flash; `f32` and `u32` are read from it at any alignment, so that a model is used in
/// place without `unsafe`.
pub type Word = [u8; 4];

/// A borrowed array of `f32` stored as little-endian [`Word`]s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Floats<'a>(pub &'a [Word]);

impl<'a> Floats<'a> {
    /// Number of values.
    pub const fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are no values.
    pub const fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Values in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = f32> + Clone + use<'a> {
        self.0.iter().map(|w| f32::from_le_bytes(*w))
    }

    /// Value `i`, if there is one.
    pub fn get(&self, i: usize) -> Option<f32> {
        self.0.get(i).map(|w| f32::from_le_bytes(*w))
    }
}
