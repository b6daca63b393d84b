//! Dual 16-bit multiply-accumulate: one instruction of a Cortex-M4 and M7, and its portable twin of the same bits.
//!
//! The only `unsafe` of the crate is here: the instruction has no other name on the stable channel.

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

/// Adds both products of the halves of two words to `sum`, which wraps.
#[cfg(not(smlad))]
#[inline(always)]
pub fn multiply_add(a: u32, b: u32, sum: i32) -> i32 {
    portable(a, b, sum)
}

/// Adds both products of the halves of two words to `sum`, which wraps.
#[cfg(smlad)]
#[allow(unsafe_code)]
#[inline(always)]
pub fn multiply_add(a: u32, b: u32, sum: i32) -> i32 {
    let result;
    // SAFETY: SMLAD reads three registers and writes one; besides it may only set the sticky Q flag, which no code that
    // Rust compiles reads. Every Armv7E-M core has it (build.rs).
    unsafe {
        core::arch::asm!("smlad {0}, {1}, {2}, {3}", lateout(reg) result, in(reg) a, in(reg) b, in(reg) sum,
            options(pure, nomem, nostack, preserves_flags));
    }
    result
}

/// The definition of SMLAD in plain Rust.
#[cfg(any(not(smlad), test))]
#[inline(always)]
const fn portable(a: u32, b: u32, sum: i32) -> i32 {
    let ((a_low, a_high), (b_low, b_high)) = (halves(a), halves(b));
    sum.wrapping_add(a_low as i32 * b_low as i32).wrapping_add(a_high as i32 * b_high as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_wrap_as_the_instruction_does() {
        // Arm Architecture Reference Manual, Armv7-M, SMLAD: 0x8000 squared twice overflows and wraps.
        let least = pair(i16::MIN, i16::MIN);
        assert_eq!(portable(least, least, 0), i32::MIN);
        assert_eq!(portable(pair(3, -5), pair(-7, 11), 1000), 1000 - 21 - 55);
        assert_eq!(halves(pair(-1, 2)), (-1, 2));
    }

    #[test]
    fn the_instruction_and_its_twin_agree() {
        let mut seed = 1u32;
        let mut next = move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            seed ^ (seed >> 15)
        };
        for _ in 0..10_000 {
            let (a, b, sum) = (next(), next(), next() as i32);
            assert_eq!(multiply_add(a, b, sum), portable(a, b, sum));
        }
    }
}
