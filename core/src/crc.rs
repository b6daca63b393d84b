//! CRC-32 of IEEE 802.3, for models in flash and for the comparison of runs.

/// Streaming CRC-32, bit by bit: at opt-levels "s" and "z" without a table; at 3 LLVM makes one of 1 kB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crc32 {
    register: u32,
}

impl Crc32 {
    /// CRC-32 of no bytes.
    pub const fn new() -> Self {
        Self { register: !0 }
    }

    /// Takes bytes.
    pub fn update(&mut self, bytes: &[u8]) {
        self.register = bytes.iter().fold(self.register, |register, &byte| {
            (0..8).fold(register ^ u32::from(byte), |r, _| if r & 1 == 1 { (r >> 1) ^ 0xedb8_8320 } else { r >> 1 })
        });
    }

    /// CRC-32 of the bytes so far.
    pub const fn value(&self) -> u32 {
        !self.register
    }
}

impl Default for Crc32 {
    fn default() -> Self {
        Self::new()
    }
}

/// CRC-32 of bytes.
pub fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = Crc32::new();
    crc.update(bytes);
    crc.value()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literature_check_value_whole_and_in_pieces() {
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
        let mut crc = Crc32::default();
        crc.update(b"1234");
        crc.update(b"");
        crc.update(b"56789");
        assert_eq!(crc.value(), 0xcbf4_3926);
    }
}
