//! Random numbers from a seed.
use std::collections::BTreeSet;

/// Random numbers that are the same on every machine (splitmix64).
#[derive(Debug, Clone)]
pub struct Numbers(u64);

impl Numbers {
    /// Each seed has its own sequence.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next number in [0, 1), a multiple of 2⁻⁵³.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The next number in [−1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// The next whole number below `n`, which is at least 1.
    pub fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n - 1)
    }

    /// `count` distinct whole numbers below `n`, which is at least `count`; ascending.
    pub fn some_below(&mut self, n: usize, count: usize) -> BTreeSet<u32> {
        let mut some = BTreeSet::new();
        while some.len() < count {
            some.insert(self.below(n) as u32);
        }
        some
    }
}
