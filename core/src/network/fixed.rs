//! A network in 16-bit fixed point, theory (106) to (109): one hidden layer, two multiply-adds an instruction on a core with
//! SMLAD.
//!
//! A vector of `f32` becomes 16-bit numbers with one exponent of its own, so that no input saturates. The sigmoid's excess over
//! ½ comes from a table of 512 intervals, linearly interpolated. Sums have 32 bits; reading a network does not check that
//! they hold, the host's conversion does: a sum that wraps is a wrong number, never undefined.
//!
//! Words of a network from n inputs over H hidden units to m outputs, with P = 4 pairs of inputs for n ≤ 8, else 8:
//!
//! | words | content |
//! |---|---|
//! | 2 | exponents k₁, k₂ of both layers: an integer weight is the weight times 2^k |
//! | H', H rounded up to even | bias times 2^(k₁+15), then P words of weights, two in a word, the first in the lower half |
//! | for each four outputs, for each two hidden units | 4 words, one an output: the weights of both units |
//! | m | f32: bias of each output, half the sum of its weights included |
//!
//! What exceeds n, H or m is zero.

use crate::hardware::{self, LANES, halves, multiply_add_each, multiply_high, pair};
use crate::math::exp_minus;
use crate::{Floats, Word};

/// Greatest number of inputs and of outputs of a network in fixed point.
pub const MAX_FIXED_ENDS: usize = 16;
/// Greatest exponent of a layer's integer weights.
pub const MAX_EXPONENT: i32 = 27;
/// Pairs of inputs of the smaller of two kernels, and words of two of its hidden units.
const FEW_PAIRS: usize = 4;
const FEW_WORDS: usize = 2 * (1 + FEW_PAIRS);
/// Pairs of inputs of the larger of two kernels, and words of two of its hidden units.
const MANY_PAIRS: usize = MAX_FIXED_ENDS / 2;
const MANY_WORDS: usize = 2 * (1 + MANY_PAIRS);
/// Outputs computed at once.
pub const GROUP: usize = LANES;
/// Binary digits of a position between two entries of the sigmoid's table.
const FRACTION_BITS: u32 = 7;
/// Half of the sigmoid's table, which reaches from −16 to 16, in positions.
const MIDDLE: i32 = 1 << 15;
/// Intervals of the table.
const INTERVALS: usize = (2 * MIDDLE as usize) >> FRACTION_BITS;
/// Digits of the argument in a position: 16 intervals for each unit.
const POSITION_BITS: i32 = 4 + FRACTION_BITS as i32;
/// Least and greatest exponent of a rate, far from where a power of two leaves `f32`.
const RATE_EXPONENTS: (i32, i32) = (-32, 64);

/// Parts of a network's words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fixed<'a> {
    hidden_exponent: i32,
    output_exponent: i32,
    inputs: usize,
    /// Hidden units, an even number.
    hidden: usize,
    units: &'a [Word],
    outputs: &'a [Word],
    biases: Floats<'a>,
}

/// Number of words of a network of these widths; `None` for a shape that has no fixed-point form.
pub fn word_count(widths: &[u16]) -> Option<usize> {
    let &[inputs, hidden, outputs] = widths else { return None };
    let (inputs, hidden, outputs) = (usize::from(inputs), usize::from(hidden), usize::from(outputs));
    let ends = 1..=MAX_FIXED_ENDS;
    if !ends.contains(&inputs) || !ends.contains(&outputs) || hidden == 0 {
        return None;
    }
    let hidden = hidden.next_multiple_of(2);
    Some(2 + hidden * (1 + pairs(inputs)) + outputs.next_multiple_of(GROUP) * hidden / 2 + outputs)
}

/// Pairs of inputs that a hidden unit has weights for.
pub const fn pairs(inputs: usize) -> usize {
    if inputs <= 2 * FEW_PAIRS { FEW_PAIRS } else { MANY_PAIRS }
}

impl<'a> Fixed<'a> {
    /// Parts of a network's words; `None` for another shape, another number of words, or an exponent out of range.
    pub(super) fn new(widths: &[u16], words: &'a [Word]) -> Option<Self> {
        if word_count(widths)? != words.len() {
            return None;
        }
        let &[inputs, hidden, outputs] = widths else { return None };
        let (inputs, outputs) = (usize::from(inputs), usize::from(outputs));
        let hidden = usize::from(hidden).next_multiple_of(2);
        let ([k1, k2], rest) = words.split_first_chunk()?;
        let (units, rest) = rest.split_at_checked(hidden * (1 + pairs(inputs)))?;
        let (weights, biases) = rest.split_at_checked(outputs.next_multiple_of(GROUP) * hidden / 2)?;
        let exponents = [k1, k2].map(|k| i32::from_le_bytes(*k));
        let [hidden_exponent, output_exponent] = exponents;
        exponents.iter().all(|k| (0..=MAX_EXPONENT).contains(k)).then_some(Self {
            hidden_exponent,
            output_exponent,
            inputs,
            hidden,
            units,
            outputs: weights,
            biases: Floats(biases),
        })
    }

    /// Floats of scratch of both passes: one for each two hidden units.
    pub(super) fn scratch_len(&self) -> usize {
        self.hidden / 2
    }

    /// Biases of the outputs, the only `f32` of the words.
    pub(super) fn biases(&self) -> Floats<'a> {
        self.biases
    }

    /// Computes y = network(x), theory (106) to (108); NaN where an input is not finite or beyond what the exponent holds.
    pub(super) fn forward(&self, x: &[f32], y: &mut [f32], scratch: &mut [f32]) {
        let done = if pairs(self.inputs) == FEW_PAIRS {
            self.hidden_values::<FEW_PAIRS, FEW_WORDS>(x, scratch)
        } else {
            self.hidden_values::<MANY_PAIRS, MANY_WORDS>(x, scratch)
        };
        if done.is_none() {
            return y.fill(f32::NAN);
        }
        let scale = power_of_two(-16 - self.output_exponent);
        self.output(scratch, |o, sum| {
            if let (Some(y), Some(bias)) = (y.get_mut(o), self.biases.get(o)) {
                *y = sum as f32 * scale + bias;
            }
        });
    }

    /// Computes dy = (∂network/∂x)(x) dx, theory (109); NaN where [`forward`](Self::forward) has it or a rate is not finite.
    pub(super) fn tangent(&self, x: &[f32], dx: &[f32], dy: &mut [f32], scratch: &mut [f32]) {
        let exponent = if pairs(self.inputs) == FEW_PAIRS {
            self.hidden_rates::<FEW_PAIRS, FEW_WORDS>(x, dx, scratch)
        } else {
            self.hidden_rates::<MANY_PAIRS, MANY_WORDS>(x, dx, scratch)
        };
        let Some(exponent) = exponent else { return dy.fill(f32::NAN) };
        let scale = power_of_two(exponent - 1 - self.hidden_exponent) * power_of_two(-self.output_exponent);
        self.output(scratch, |o, sum| {
            if let Some(dy) = dy.get_mut(o) {
                *dy = sum as f32 * scale;
            }
        });
    }

    /// Shift from a hidden unit's sum to a position in the sigmoid's table, for inputs of an exponent.
    fn shift(&self, exponent: i32) -> u32 {
        (self.hidden_exponent + 15 - POSITION_BITS - exponent) as u32
    }

    /// Least and greatest exponent of inputs: below, the bias would shift to the left, above, the sum.
    fn exponents(&self) -> (i32, i32) {
        (0, self.hidden_exponent + 15 - POSITION_BITS)
    }

    /// σ − ½ of each hidden unit times 2¹⁶, two in a float's bits.
    fn hidden_values<const P: usize, const U: usize>(&self, x: &[f32], scratch: &mut [f32]) -> Option<()> {
        let (x, exponent) = quantise::<P>(x, self.exponents())?;
        let shift = self.shift(exponent);
        let value = |unit: &[Word]| {
            let bias = unit.first().map_or(0, |bias| i32::from_le_bytes(*bias));
            sigmoid(dot(unit, &x, bias >> exponent) >> shift)
        };
        for (slot, two) in scratch.iter_mut().zip(self.units.as_chunks::<U>().0) {
            let (first, second) = two.split_at(U / 2);
            *slot = f32::from_bits(pair(value(first), value(second)));
        }
        Some(())
    }

    /// Derivative of each hidden unit, two in a float's bits; returns the exponent of `dx`.
    fn hidden_rates<const P: usize, const U: usize>(&self, x: &[f32], dx: &[f32], scratch: &mut [f32]) -> Option<i32> {
        self.hidden_values::<P, U>(x, scratch)?;
        let (dx, exponent) = quantise::<P>(dx, RATE_EXPONENTS)?;
        for (slot, two) in scratch.iter_mut().zip(self.units.as_chunks::<U>().0) {
            let (first, second) = two.split_at(U / 2);
            let (a, b) = halves(slot.to_bits());
            *slot = f32::from_bits(pair(rate(a, dot(first, &dx, 0)), rate(b, dot(second, &dx, 0))));
        }
        Some(exponent)
    }

    /// Sums of the output layer over the pairs of hidden units in `scratch`.
    fn output(&self, scratch: &[f32], mut put: impl FnMut(usize, i32)) {
        let hidden = scratch.get(..self.hidden / 2).unwrap_or(&[]);
        if hidden.is_empty() {
            return;
        }
        let (mut rows, mut group) = (self.outputs.as_chunks::<GROUP>().0, 0);
        while let Some((weights, rest)) = rows.split_at_checked(hidden.len()) {
            let mut sums = [0; GROUP];
            for (weights, hidden) in weights.iter().zip(hidden) {
                multiply_add_each(weights, hidden.to_bits(), &mut sums);
            }
            sums.into_iter().enumerate().for_each(|(o, sum)| put(group + o, sum));
            (rows, group) = (rest, group + GROUP);
        }
    }
}

/// Derivative of a hidden unit from its value and the derivative of its argument.
#[inline(always)]
fn rate(value: i16, of_argument: i32) -> i16 {
    // σ' = ¼ − (σ − ½)², times 2¹⁶.
    let value = i32::from(value);
    let slope = (((1 << 30) - value * value) >> 16) as i16;
    (multiply_high(of_argument, slope) >> 14) as i16
}

/// Sum of products of a unit's weights, which follow its bias, and a start.
#[inline(always)]
fn dot<const P: usize>(unit: &[Word], x: &[u32; P], start: i32) -> i32 {
    let weights = unit.get(1..).unwrap_or(&[]).as_chunks::<LANES>().0;
    weights.iter().zip(x.as_chunks::<LANES>().0).fold(start, |sum, (weights, x)| hardware::dot(weights, x, sum))
}

/// Vector as 16-bit numbers of one exponent e, the least in `range` with every |x| < 2^e: x times 2^(15−e), towards zero.
/// `None` where an element is not finite or needs a greater exponent.
#[inline(always)]
fn quantise<const P: usize>(x: &[f32], range: (i32, i32)) -> Option<([u32; P], i32)> {
    let greatest = x.iter().fold(0, |greatest, x| greatest.max(x.to_bits() & 0x7fff_ffff));
    let exponent = ((greatest >> 23) as i32 - 126).max(range.0);
    if exponent > range.1 {
        return None;
    }
    let scale = power_of_two(15 - exponent);
    let mut words = [0; P];
    for (word, two) in words.iter_mut().zip(x.chunks(2)) {
        let number = |i: usize| two.get(i).map_or(0, |x| (x * scale) as i32 as i16);
        *word = pair(number(0), number(1));
    }
    Some((words, exponent))
}

/// Power of two with an exponent of a normal `f32`, −126 to 127.
const fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) as u32) << 23)
}

/// σ − ½ times 2¹⁶ at a position, counted from the table's middle.
#[inline(always)]
fn sigmoid(position: i32) -> i16 {
    let position = position.clamp(-MIDDLE, MIDDLE - 1);
    let (value, step) = halves(TABLE[(position >> FRACTION_BITS) as usize % INTERVALS]);
    let fraction = position & ((1 << FRACTION_BITS) - 1);
    value.wrapping_add(((i32::from(step) * fraction) >> FRACTION_BITS) as i16)
}

/// Value at the start of each interval of the sigmoid, and the step to the next; negative intervals lie behind the positive
/// ones, as their remainders do.
static TABLE: [u32; INTERVALS] = table();

const fn table() -> [u32; INTERVALS] {
    let mut table = [0; INTERVALS];
    let mut i = 0;
    while i < INTERVALS {
        let interval = if i < INTERVALS / 2 { i as i32 } else { i as i32 - INTERVALS as i32 };
        let value = excess(interval);
        table[i] = pair(value, excess(interval + 1) - value);
        i += 1;
    }
    table
}

/// σ − ½ times 2¹⁶ at the start of interval `i`, rounded.
const fn excess(i: i32) -> i16 {
    let x = i as f64 / 16.0;
    let value = 65_536.0 * (1.0 / (1.0 + exp_minus(x)) - 0.5);
    let rounded = (value + if value < 0.0 { -0.5 } else { 0.5 }) as i32;
    // σ(−16) is 7e-9 short of the least i16.
    if rounded > i16::MAX as i32 { i16::MAX } else { rounded as i16 }
}
