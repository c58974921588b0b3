//! Three-vectors as the twins use them: plain arrays, one rounding per operation, sums from left to right.
use crate::Real;

/// a − b.
pub fn sub<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a + b.
pub fn add<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a · b.
pub fn dot<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b.
pub fn cross<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// ‖a‖.
pub fn length<T: Real>(a: [T; 3]) -> T {
    dot(a, a).sqrt()
}

/// a / ‖a‖, or zero where a is zero. Divides by the largest component first, so that the squares of very
/// small and very large vectors neither vanish nor overflow.
pub fn normalize<T: Real>(a: [T; 3]) -> [T; 3] {
    let largest = a[0].abs().max(a[1].abs()).max(a[2].abs());
    if largest == T::zero() {
        return a;
    }
    let scaled = a.map(|c| c / largest);
    let length = length(scaled);
    scaled.map(|c| c / length)
}
