//! Conversion of a network from single precision to fixed point, theory (106): done once, on the host.

use core::fmt;

use super::fixed::{GROUP, MAX_EXPONENT, pairs, word_count};
use super::float::{self, weight_index};
use super::{Arithmetic, Network};
use crate::hardware::pair;
use crate::{Floats, Word};

/// Reason why a network has no form in fixed point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FixedError {
    /// Not one hidden layer, or more than 16 inputs or outputs, or not single precision.
    Shape,
    /// Buffer of another length than [`word_count`] says.
    Buffer {
        /// Words needed.
        expected: usize,
        /// Words found.
        found: usize,
    },
    /// Weights and bias of a unit whose sum of magnitudes is 65,500 or more.
    Weights {
        /// Layer, 0 the hidden one.
        layer: usize,
    },
}

impl fmt::Display for FixedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape => {
                f.write_str("no form in fixed point: expected one hidden layer and at most 16 inputs and outputs")
            }
            Self::Buffer { expected, found } => write!(f, "buffer of {found} words, expected {expected}"),
            Self::Weights { layer } => {
                write!(f, "layer {layer}: the weights of a unit sum to 65,500 or more, expected less")
            }
        }
    }
}

impl core::error::Error for FixedError {}

/// One layer in single precision.
struct Layer<'a> {
    inputs: usize,
    outputs: usize,
    weights: Floats<'a>,
    biases: Floats<'a>,
}

impl Layer<'_> {
    /// Weight from input `i` to output `o`; 0 beyond the layer.
    fn weight(&self, o: usize, i: usize) -> f32 {
        let inside = o < self.outputs && i < self.inputs;
        let weight = || self.weights.get(weight_index(self.inputs, self.outputs, o, i));
        if inside { weight().unwrap_or(0.0) } else { 0.0 }
    }

    fn bias(&self, o: usize) -> f32 {
        self.biases.get(o).unwrap_or(0.0)
    }

    /// Greatest exponent k for which no weight times 2^k leaves 16 bits and no sum over 16-bit inputs 32 bits.
    fn exponent(&self, with_bias: bool) -> Option<i32> {
        let sum = |o: usize| {
            let bias = if with_bias { self.bias(o).abs() } else { 0.0 };
            let weights = (0..self.inputs).map(|i| self.weight(o, i).abs());
            // Of one weight alone, half: it must fit in 15 bits and a sign.
            let most = weights.clone().fold(0.0, f32::max);
            (weights.sum::<f32>() + bias).max(2.0 * most)
        };
        let greatest = (0..self.outputs).map(sum).fold(0.0, f32::max);
        // Half a unit of each weight is what rounding adds.
        let room = 65_500.0 - 0.5 * self.inputs as f32;
        (0..=MAX_EXPONENT).rev().find(|k| greatest * scale(*k) < room)
    }
}

/// Writes the words of a network's form in fixed point.
///
/// # Errors
/// [`FixedError`] of a network or buffer that does not fit.
pub fn to_fixed(network: &Network<'_>, out: &mut [Word]) -> Result<(), FixedError> {
    let expected = word_count(network.widths()).ok_or(FixedError::Shape)?;
    let found = out.len();
    if found != expected {
        return Err(FixedError::Buffer { expected, found });
    }
    let (&[n, h, m], Arithmetic::Float) = (network.widths(), network.arithmetic()) else {
        return Err(FixedError::Shape);
    };
    let (first, second) = network.words().split_at_checked(float::word_count(&[n, h])).ok_or(FixedError::Shape)?;
    let hidden = split(first, n, h).ok_or(FixedError::Shape)?;
    let output = split(second, h, m).ok_or(FixedError::Shape)?;
    let k1 = hidden.exponent(true).ok_or(FixedError::Weights { layer: 0 })?;
    let k2 = output.exponent(false).ok_or(FixedError::Weights { layer: 1 })?;
    let units = hidden.outputs.next_multiple_of(2);

    let mut slots = out.iter_mut();
    let mut put = |word: Word| {
        if let Some(slot) = slots.next() {
            *slot = word;
        }
    };
    put(k1.to_le_bytes());
    put(k2.to_le_bytes());
    for o in 0..units {
        put(round(hidden.bias(o) * scale(k1 + 15)).to_le_bytes());
        for p in 0..pairs(hidden.inputs) {
            let weight = |i| round(hidden.weight(o, i) * scale(k1)) as i16;
            put(pair(weight(2 * p), weight(2 * p + 1)).to_le_bytes());
        }
    }
    let weight = |o, i| round(output.weight(o, i) * scale(k2)) as i16;
    for group in 0..output.outputs.div_ceil(GROUP) {
        for p in 0..units / 2 {
            for o in GROUP * group..GROUP * (group + 1) {
                put(pair(weight(o, 2 * p), weight(o, 2 * p + 1)).to_le_bytes());
            }
        }
    }
    for o in 0..output.outputs {
        // Of the weights before rounding: only what the sigmoid adds to a half meets the rounded ones.
        let sum: f32 = (0..output.inputs).map(|i| output.weight(o, i)).sum();
        put((output.bias(o) + 0.5 * sum).to_le_bytes());
    }
    Ok(())
}

fn split(words: &[Word], inputs: u16, outputs: u16) -> Option<Layer<'_>> {
    let (inputs, outputs) = (usize::from(inputs), usize::from(outputs));
    let (weights, biases) = words.split_at_checked(inputs * outputs)?;
    Some(Layer { inputs, outputs, weights: Floats(weights), biases: Floats(biases) })
}

fn scale(exponent: i32) -> f32 {
    (1_u64 << exponent) as f32
}

/// Nearest integer, halves away from zero.
fn round(x: f32) -> i32 {
    (x + if x < 0.0 { -0.5 } else { 0.5 }) as i32
}
