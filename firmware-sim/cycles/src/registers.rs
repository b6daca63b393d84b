//! Sets of core and floating-point registers.

/// A set of registers: bits 0 to 15 are r0 to pc, bits 16 to 47 are s0 to s31 (d0 is s0 and s1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Registers(pub u64);

/// The stack pointer.
pub const SP: Registers = Registers(1 << 13);
/// The program counter.
pub const PC: Registers = Registers(1 << 15);

impl Registers {
    /// Whether the sets share a register.
    pub const fn meets(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Registers of either set.
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Number of words that the registers hold.
    pub const fn words(self) -> u32 {
        self.0.count_ones()
    }

    /// All registers that an operand's text names, such as `r4`, `[r1, r2, lsl #2]`, `{s0, s1}` or `{r4-r7}`.
    pub fn named(text: &str) -> Self {
        let mut all = 0;
        let (mut first, mut range) = (None, false);
        for part in text.split_inclusive(|c: char| !c.is_ascii_alphanumeric()) {
            let name = part.trim_end_matches(|c: char| !c.is_ascii_alphanumeric());
            let bits = one(name);
            if range && let (Some(first), Some(last)) = (first, bits) {
                all |= (last << 1).wrapping_sub(first);
            }
            all |= bits.unwrap_or(0);
            first = bits;
            range = part.ends_with('-');
        }
        Self(all)
    }
}

fn one(name: &str) -> Option<u64> {
    let core = match name {
        "sb" => Some(9),
        "sl" => Some(10),
        "fp" => Some(11),
        "ip" => Some(12),
        "sp" => Some(13),
        "lr" => Some(14),
        "pc" => Some(15),
        _ => None,
    };
    if let Some(core) = core {
        return Some(1 << core);
    }
    let number: u32 = name.get(1..)?.parse().ok()?;
    match name.as_bytes().first()? {
        b'r' if number < 16 => Some(1 << number),
        b's' if number < 32 => Some(1 << (16 + number)),
        b'd' if number < 16 => Some(3 << (16 + 2 * number)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operands_name_their_registers() {
        assert_eq!(Registers::named("[r1, r2, lsl #2]"), Registers(0b110));
        assert_eq!(Registers::named("{r4, r5, r6, pc}"), Registers(0x8070));
        assert_eq!(Registers::named("{r4-r7}"), Registers(0xf0));
        assert_eq!(Registers::named("d1"), Registers::named("{s2, s3}"));
        assert_eq!(Registers::named("#0x10").words(), 0);
        assert_eq!(Registers::named("sb"), Registers::named("r9"));
    }
}
