/// Where two arrays differ most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// The index into both arrays.
    pub index: usize,
    /// What was computed there.
    pub found: f64,
    /// What the reference has there.
    pub expected: f64,
    /// |found − expected|; infinite where `found` is not finite.
    pub size: f64,
}

/// The largest absolute difference between two arrays of equal length.
///
/// # Panics
/// If the lengths differ or are zero: a comparison of nothing must not pass.
pub fn worst_difference<A: Copy + Into<f64>, B: Copy + Into<f64>>(found: &[A], expected: &[B]) -> Difference {
    assert_eq!(found.len(), expected.len(), "two arrays of different lengths");
    let differences = found.iter().zip(expected).enumerate().map(|(index, (&found, &expected))| {
        let (found, expected) = (found.into(), expected.into());
        let size = (found - expected).abs();
        Difference { index, found, expected, size: if size.is_nan() { f64::INFINITY } else { size } }
    });
    differences.max_by(|a, b| a.size.total_cmp(&b.size)).expect("two arrays with at least one number")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_is_found_and_nan_is_worse_than_anything() {
        let worst = worst_difference(&[1.0f32, 2.0, 3.5], &[1.0f64, 2.25, 3.0]);
        assert_eq!((worst.index, worst.size), (2, 0.5));
        let worst = worst_difference(&[1.0f32, f32::NAN, 9.0], &[1.0f64, 2.25, 3.0]);
        assert_eq!((worst.index, worst.size), (1, f64::INFINITY));
    }

    #[test]
    #[should_panic(expected = "different lengths")]
    fn arrays_of_different_lengths_do_not_compare() {
        worst_difference(&[1.0f32], &[1.0f64, 2.0]);
    }
}
