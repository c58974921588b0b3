//! The speed of the processor's memory, with which times are compared.
use rayon::prelude::*;
use std::hint::black_box;
use web_time::Instant;

/// An array far larger than any cache. All cores together read it.
#[derive(Debug)]
pub struct Memory {
    words: Vec<u64>,
}

impl Memory {
    /// Takes half a gibibyte.
    #[expect(clippy::new_without_default, reason = "half a gibibyte should be asked for by name")]
    pub fn new() -> Self {
        // Every page is written, since an unwritten page is not in memory.
        Self { words: (0..1 << 26).into_par_iter().map(|i: u64| i ^ 0x5555).collect() }
    }

    /// Bytes a second that all cores together read now. Times of kernels are compared with this speed. On a
    /// shared machine it changes from one second to the next, so measure it in turns with the kernels. Takes
    /// some hundredths of a second.
    pub fn read_bandwidth(&self) -> f64 {
        let start = Instant::now();
        let sum: u64 = self.words.par_chunks(1 << 16).map(sum).reduce(|| 0, u64::wrapping_add);
        black_box(sum);
        size_of_val(self.words.as_slice()) as f64 / start.elapsed().as_secs_f64()
    }
}

/// The median of [`Memory::read_bandwidth`]; takes a few tenths of a second.
pub fn read_bandwidth() -> f64 {
    let memory = Memory::new();
    let mut all = [(); 5].map(|()| memory.read_bandwidth());
    all.sort_unstable_by(f64::total_cmp);
    all[all.len() / 2]
}

/// Eight sums at once, so that the processor waits for memory and not for a sum.
fn sum(words: &[u64]) -> u64 {
    let mut sums = [0u64; 8];
    for eight in words.as_chunks::<8>().0 {
        sums.iter_mut().zip(eight).for_each(|(sum, word)| *sum = sum.wrapping_add(*word));
    }
    sums.into_iter().fold(0, u64::wrapping_add)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_neither_a_disk_nor_magic() {
        let bandwidth = read_bandwidth();
        assert!((1e8..1e13).contains(&bandwidth), "{bandwidth:e} bytes/s");
        assert_eq!(sum(&[1; 64]), 64);
    }
}
