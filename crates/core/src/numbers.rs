//! Small functions of lists of numbers that several crates need.

/// The dot product of two lists, summed from left to right. What the longer one has more does not count.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The median of numbers, which are put in another order: the mean of the two in the middle where their number is even, NaN
/// where there is none.
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
