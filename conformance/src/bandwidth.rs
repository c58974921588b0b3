use rayon::prelude::*;
use std::hint::black_box;
use std::time::Instant;

/// Bytes a second that all cores together read from memory, in an array far larger than any cache: what times of kernels
/// are compared with. Takes about a second.
pub fn read_bandwidth() -> f64 {
    const WORDS: usize = 1 << 26;
    // Written, since a page that never was is not in memory.
    let words: Vec<u64> = (0..WORDS as u64).into_par_iter().map(|i| i ^ 0x5555).collect();
    let mut best = f64::MAX;
    for _ in 0..5 {
        let start = Instant::now();
        let sum: u64 = words.par_chunks(1 << 16).map(sum).reduce(|| 0, u64::wrapping_add);
        black_box(sum);
        best = best.min(start.elapsed().as_secs_f64());
    }
    size_of_val(words.as_slice()) as f64 / best
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
