//! What the processor does better than plain Rust can say, each with a portable form of the same bits: two 16-bit multiply-adds
//! in an instruction of a Cortex-M4 and M7, and words read at their alignment.
//!
//! The only `unsafe` of the crate is here.

use crate::Word;

/// A 32-bit word of a model as it lies in memory.
pub trait Stored: Copy {
    /// Value of the word.
    fn bits(self) -> u32;
}

impl Stored for Word {
    fn bits(self) -> u32 {
        u32::from_le_bytes(self)
    }
}

/// A word at its alignment on a little-endian processor, from [`aligned`].
impl Stored for u32 {
    fn bits(self) -> u32 {
        self
    }
}

/// Words at their alignment, which load several at once; `None` where they lie at another or the processor is big-endian.
#[allow(unsafe_code)]
pub fn aligned(words: &[Word]) -> Option<&[u32]> {
    if cfg!(target_endian = "big") {
        return None;
    }
    // SAFETY: every four bytes are a u32, and `align_to` keeps to alignment and bounds.
    let (before, words, after) = unsafe { words.align_to::<u32>() };
    (before.is_empty() && after.is_empty()).then_some(words)
}

/// Two signed 16-bit numbers in a word, the first in the lower half.
pub const fn pair(first: i16, second: i16) -> u32 {
    u32::from_le_bytes({
        let ([a, b], [c, d]) = (first.to_le_bytes(), second.to_le_bytes());
        [a, b, c, d]
    })
}

/// Both halves of a word, the lower first.
pub const fn halves(word: u32) -> (i16, i16) {
    (word as i16, (word >> 16) as i16)
}

/// Words of a product: as many as load one behind the other into free registers.
pub const LANES: usize = 4;

/// Adds the products of the halves of each word with those of the same of `x` to `sum`, which wraps.
#[cfg(not(smlad))]
#[inline(always)]
pub fn dot(words: &[Word; LANES], x: &[u32; LANES], sum: i32) -> i32 {
    words.iter().zip(x).fold(sum, |sum, (word, x)| multiply_add(word.bits(), *x, sum))
}

/// Adds the products of the halves of each word with those of the same of `x` to `sum`, which wraps.
#[cfg(smlad)]
#[allow(unsafe_code)]
#[inline(always)]
pub fn dot(words: &[Word; LANES], x: &[u32; LANES], mut sum: i32) -> i32 {
    let [a, b, c, d] = *x;
    // SAFETY: reads the sixteen bytes of `words`, at any alignment, as LDR may, and writes only its own registers and, by
    // SMLAD, the sticky Q flag, so `preserves_flags` is not stated. Every Armv7E-M core has it (build.rs).
    unsafe {
        core::arch::asm!(
            "ldr {0}, [{words}]", "ldr {1}, [{words}, #4]",
            "smlad {sum}, {0}, {a}, {sum}", "smlad {sum}, {1}, {b}, {sum}",
            "ldr {0}, [{words}, #8]", "ldr {1}, [{words}, #12]",
            "smlad {sum}, {0}, {c}, {sum}", "smlad {sum}, {1}, {d}, {sum}",
            out(reg) _, out(reg) _, words = in(reg) words,
            a = in(reg) a, b = in(reg) b, c = in(reg) c, d = in(reg) d, sum = inout(reg) sum,
            options(pure, readonly, nostack));
    }
    sum
}

/// Adds the products of the halves of each word with those of `x` to a sum for each, which wraps.
#[cfg(not(smlad))]
#[inline(always)]
pub fn multiply_add_each(words: &[Word; LANES], x: u32, sums: &mut [i32; LANES]) {
    sums.iter_mut().zip(words).for_each(|(sum, word)| *sum = multiply_add(word.bits(), x, *sum));
}

/// Adds the products of the halves of each word with those of `x` to a sum for each, which wraps.
#[cfg(smlad)]
#[allow(unsafe_code)]
#[inline(always)]
pub fn multiply_add_each(words: &[Word; LANES], x: u32, sums: &mut [i32; LANES]) {
    let [a, b, c, d] = sums;
    // SAFETY: as in `dot`.
    unsafe {
        core::arch::asm!(
            "ldr {0}, [{words}]", "ldr {1}, [{words}, #4]", "ldr {2}, [{words}, #8]", "ldr {3}, [{words}, #12]",
            "smlad {a}, {0}, {x}, {a}", "smlad {b}, {1}, {x}, {b}", "smlad {c}, {2}, {x}, {c}", "smlad {d}, {3}, {x}, {d}",
            out(reg) _, out(reg) _, out(reg) _, out(reg) _, words = in(reg) words, x = in(reg) x,
            a = inout(reg) *a, b = inout(reg) *b, c = inout(reg) *c, d = inout(reg) *d,
            options(pure, readonly, nostack));
    }
}

/// Product of 32 and 16 bits without its lowest 16.
#[cfg(not(smlad))]
#[inline(always)]
pub fn multiply_high(a: i32, b: i16) -> i32 {
    portable_high(a, b)
}

/// Product of 32 and 16 bits without its lowest 16.
#[cfg(smlad)]
#[allow(unsafe_code)]
#[inline(always)]
pub fn multiply_high(a: i32, b: i16) -> i32 {
    let result;
    // SAFETY: SMULWB reads two registers and writes one. Every Armv7E-M core has it (build.rs).
    unsafe {
        core::arch::asm!("smulwb {0}, {1}, {2}", lateout(reg) result, in(reg) a, in(reg) i32::from(b),
            options(pure, nomem, nostack, preserves_flags));
    }
    result
}

/// The definition of SMULWB in plain Rust.
#[cfg(any(not(smlad), test))]
#[inline(always)]
const fn portable_high(a: i32, b: i16) -> i32 {
    ((a as i64 * b as i64) >> 16) as i32
}

/// The definition of SMLAD in plain Rust.
#[cfg(any(not(smlad), test))]
#[inline(always)]
const fn multiply_add(a: u32, b: u32, sum: i32) -> i32 {
    let ((a_low, a_high), (b_low, b_high)) = (halves(a), halves(b));
    sum.wrapping_add(a_low as i32 * b_low as i32).wrapping_add(a_high as i32 * b_high as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_the_same_at_their_alignment() {
        let words: [Word; 5] = core::array::from_fn(|i| [i as u8, 2, 3, 0x80]);
        let bits = words.map(Stored::bits);
        #[repr(align(4))]
        struct Aligned([Word; 5]);
        let held = Aligned(words);
        // An interpreter may refuse what a processor finds aligned.
        assert!(aligned(&held.0).is_none_or(|words| words.iter().map(|w| w.bits()).eq(bits)));
        #[repr(align(4))]
        struct Shifted([u8; 24]);
        let mut shifted = Shifted([0; 24]);
        shifted.0[1..21].copy_from_slice(words.as_flattened());
        assert_eq!(aligned(shifted.0[1..21].as_chunks().0), None);
    }

    #[test]
    fn extremes_wrap_as_the_instruction_does() {
        // Arm Architecture Reference Manual, Armv7-M, SMLAD: 0x8000 squared twice overflows and wraps.
        let least = pair(i16::MIN, i16::MIN);
        assert_eq!(multiply_add(least, least, 0), i32::MIN);
        assert_eq!(multiply_add(pair(3, -5), pair(-7, 11), 1000), 1000 - 21 - 55);
        assert_eq!(halves(pair(-1, 2)), (-1, 2));
    }

    #[test]
    fn the_instructions_are_their_definitions() {
        let mut seed = 1u32;
        let mut next = move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            seed ^ (seed >> 15)
        };
        for _ in 0..10_000 {
            let words: [Word; LANES] = core::array::from_fn(|_| next().to_le_bytes());
            let x: [u32; LANES] = core::array::from_fn(|_| next());
            let sum = next() as i32;
            let expected = (0..LANES).fold(sum, |sum, i| multiply_add(u32::from_le_bytes(words[i]), x[i], sum));
            assert_eq!(dot(&words, &x, sum), expected);
            let mut sums = [sum, 1, -2, i32::MAX];
            let expected: [i32; LANES] =
                core::array::from_fn(|i| multiply_add(u32::from_le_bytes(words[i]), x[0], sums[i]));
            multiply_add_each(&words, x[0], &mut sums);
            assert_eq!(sums, expected);
            assert_eq!(multiply_high(sum, x[0] as i16), portable_high(sum, x[0] as i16));
        }
    }
}
