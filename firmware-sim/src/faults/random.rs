//! Random numbers for faults, reproducible: a dependency may change its stream.

/// Generator SplitMix64 (Steele, Lea and Flood 2014).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// Stream `stream` of a seed.
    pub fn new(seed: u64, stream: u64) -> Self {
        // First numbers of neighbouring seeds are far apart, so streams do not overlap in practice.
        let mut of_seed = Self(seed);
        Self(of_seed.next() ^ Self(!stream).next())
    }

    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Draws true with a probability.
    pub fn happens(&mut self, probability: f64) -> bool {
        // The upper 53 bits are a uniform number below 1.
        ((self.next() >> 11) as f64) < probability * (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literature_first_numbers_of_seed_1234567() {
        let mut random = Random(1_234_567);
        assert_eq!(random.next(), 6_457_827_717_110_365_317);
        assert_eq!(random.next(), 3_203_168_211_198_807_973);
    }

    #[test]
    fn probabilities_hold() {
        let mut random = Random::new(1, 2);
        let count = (0..100_000).filter(|_| random.happens(0.01)).count();
        assert!((850..1150).contains(&count), "{count}");
        assert!((0..1000).all(|_| random.happens(1.0)));
        assert!(!(0..1000).any(|_| random.happens(0.0)));
    }
}
