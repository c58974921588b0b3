//! Comparisons of computed with expected numbers.
use crate::expected::Expected;
use crate::outcome::{Measured, stage_name};
use rhytid_core::Stage;

/// Where two arrays differ most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// The index into both arrays.
    pub index: usize,
    /// The computed number.
    pub found: f64,
    /// The reference's number.
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

/// How a stage compares with its reference.
pub(crate) struct Comparison {
    /// `None` where the stage has no numbers.
    pub measured: Option<Measured>,
    /// A sentence about the number that is farthest beyond its bound, if any is.
    pub problem: Option<String>,
}

/// Compares a stage with its reference, which has as many numbers.
pub(crate) fn compare(
    stage: Stage,
    found: &[f32],
    expected: &[Expected],
    metres_per_unit: f64,
) -> Comparison {
    let size = size_of(stage, expected);
    let (mut worst, mut part_of_bound, mut difference) = (0, 0.0, 0.0f64);
    for (i, (&found, expected)) in found.iter().zip(expected).enumerate() {
        let off = (f64::from(found) - expected.value).abs();
        let part = off / expected.bound;
        let part = if part.is_nan() { f64::INFINITY } else { part };
        if part > part_of_bound {
            (worst, part_of_bound) = (i, part);
        }
        if expected.bound <= size / 100.0 {
            difference = difference.max(off);
        }
    }
    if found.len() != expected.len() {
        part_of_bound = f64::INFINITY;
    }
    // Written so that a NaN does not pass.
    let passes = part_of_bound <= 1.0;
    let problem = (!passes).then(|| match (found.get(worst), expected.get(worst)) {
        (Some(found), Some(Expected { value, bound })) => format!(
            "{} has {found:e} as number {worst}, expected {value:e} within {bound:.2e}: {part_of_bound:.3} of what is \
             allowed",
            stage_name(stage)
        ),
        _ => format!("{} has {} numbers, expected {}", stage_name(stage), found.len(), expected.len()),
    });
    let is_length = matches!(stage, Stage::LargeScale | Stage::Detail | Stage::Positions);
    let measured = (!found.is_empty()).then(|| Measured {
        part_of_bound,
        ulp: (size > 0.0).then(|| difference / unit_in_the_last_place(size)),
        mm: is_length.then_some(difference * metres_per_unit * 1000.0),
    });
    Comparison { measured, problem }
}

/// The size that relates to a stage's errors: see [`Measured::ulp`].
fn size_of(stage: Stage, expected: &[Expected]) -> f64 {
    let largest = expected.iter().map(|e| e.value.abs()).fold(0.0, f64::max);
    match stage {
        Stage::Strain => largest.max(1.0),
        Stage::LargeScaleNormals | Stage::Normals => 1.0,
        Stage::LargeScale | Stage::Detail | Stage::Positions => largest,
    }
}

/// The distance of two neighbouring f32 at `size`.
fn unit_in_the_last_place(size: f64) -> f64 {
    2f64.powi(size.log2().floor() as i32 - 23)
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
