//! The spans of the weights.

use super::basis::Basis;

/// A column of the basis's weights as `zero + range · w` with w from 0 to 1. The range is negative if the
/// base mesh, at w = 0, is then closer to the mean.
#[derive(Clone, Copy)]
pub(super) struct Span {
    pub zero: f64,
    pub range: f64,
}

/// The spans of all columns but the first, which is constant.
pub(super) fn spans(basis: &Basis) -> Vec<Span> {
    (1..basis.weights.ncols())
        .map(|k| {
            let column = basis.weights.col(k);
            let low = column.iter().copied().fold(f64::INFINITY, f64::min);
            let high = column.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let (zero, one) = if low.abs() <= high.abs() { (low, high) } else { (high, low) };
            Span { zero, range: one - zero }
        })
        .collect()
}
