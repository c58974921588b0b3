//! Three-vectors as the references use them: plain arrays, one rounding per operation, sums from left to
//! right.
use crate::Number;

/// a − b.
#[inline(always)]
pub fn sub<T: Number>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a + b.
#[inline(always)]
pub fn add<T: Number>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// s a.
#[inline(always)]
pub fn scaled<T: Number>(a: [T; 3], s: T) -> [T; 3] {
    // `map` is not compiled for the vectors that its caller is compiled for.
    [a[0] * s, a[1] * s, a[2] * s]
}

/// a · b.
#[inline(always)]
pub fn dot<T: Number>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b.
#[inline(always)]
pub fn cross<T: Number>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// ‖a‖.
#[inline(always)]
pub fn length<T: Number>(a: [T; 3]) -> T {
    dot(a, a).sqrt()
}

/// a / ‖a‖, or zero where a is zero. The vector is first scaled by its largest component. So the squares of
/// very small vectors do not vanish, and those of very large ones do not overflow. How that scale is rounded
/// does not matter.
#[inline(always)]
pub fn normalize<T: Number>(a: [T; 3]) -> [T; 3] {
    let largest = a[0].abs().max(a[1].abs()).max(a[2].abs());
    let scale = largest.or_smallest_normal().reciprocal();
    let a = scaled(a, scale);
    scaled(a, length(a).or_one().reciprocal())
}
