//! Small functions of lists of numbers that several crates need.
use rayon::prelude::*;
use rhytid_kernels::Real;

/// The dot product of two lists, summed from left to right. The longer list's further numbers do not count.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The first of `numbers` that is NaN or infinite, as an index.
///
/// ```
/// use rhytid_core::numbers::first_not_finite;
///
/// assert_eq!(first_not_finite(&[0.0, 1.0]), None);
/// assert_eq!(first_not_finite(&[0.0, f32::NAN, f32::INFINITY]), Some(1));
/// ```
pub fn first_not_finite<T: Real>(numbers: &[T]) -> Option<usize> {
    first_beyond(numbers, f64::MAX)
}

/// The first of `numbers` that is NaN, or larger than `most` without its sign, as an index.
pub fn first_beyond<T: Real>(numbers: &[T], most: f64) -> Option<usize> {
    const BLOCK: usize = 4096;
    // The check of a block does not stop early, so the compiler can check many numbers at a time.
    let are_within = |block: &[T]| block.iter().fold(true, |within, x| within & (x.widen().abs() <= most));
    let block = numbers.par_chunks(BLOCK).with_min_len(16).position_first(|block| !are_within(block))?;
    let first = block * BLOCK;
    numbers[first..].iter().position(|x| !are_within(std::slice::from_ref(x))).map(|i| first + i)
}

/// The median of numbers, whose order is changed. It is the mean of the two in the middle if their number is
/// even, and NaN if there are none.
///
/// ```
/// use rhytid_core::numbers::median;
///
/// assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
/// assert_eq!(median(&mut [4.0, 1.0, 2.0, 100.0]), 3.0);
/// assert!(median(&mut []).is_nan());
/// ```
pub fn median(numbers: &mut [f64]) -> f64 {
    let (middle, is_odd) = (numbers.len() / 2, numbers.len() % 2 == 1);
    if numbers.is_empty() {
        return f64::NAN;
    }
    let (below, &mut upper, _) = numbers.select_nth_unstable_by(middle, f64::total_cmp);
    if is_odd {
        return upper;
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    0.5 * (lower + upper)
}
