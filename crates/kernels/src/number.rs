//! Numbers that vectors are made of.
use std::ops::{Add, Div, Mul, Sub};

/// A component of a vector: one floating-point number, or several of them side by side in a processor's
/// register.
///
/// There is no comparison, so every lane runs the same instructions.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// |x|.
    fn abs(self) -> Self;
    /// The larger of two numbers.
    fn max(self, other: Self) -> Self;
    /// √x.
    fn sqrt(self) -> Self;
    /// 1 / x.
    fn reciprocal(self) -> Self;
    /// x, or the smallest normal number where x is smaller.
    fn or_smallest_normal(self) -> Self;
    /// x, or 1 where x is 0.
    fn or_one(self) -> Self;
    /// x y + sum, rounded once; twice in WebAssembly ([`IS_FUSED`]).
    fn mul_add(self, y: Self, sum: Self) -> Self;
}

/// Whether a product is added before it is rounded. WebAssembly has no such instruction, and a function that
/// does the same takes some fifty times as long.
pub const IS_FUSED: bool = cfg!(not(target_arch = "wasm32"));

macro_rules! number {
    ($type:ty) => {
        impl Number for $type {
            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                self.max(other)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline(always)]
            fn reciprocal(self) -> Self {
                1.0 / self
            }
            #[inline(always)]
            fn or_smallest_normal(self) -> Self {
                self.max(<$type>::MIN_POSITIVE)
            }
            #[inline(always)]
            fn or_one(self) -> Self {
                if self == 0.0 { 1.0 } else { self }
            }
            #[inline(always)]
            fn mul_add(self, y: Self, sum: Self) -> Self {
                if IS_FUSED { self.mul_add(y, sum) } else { self * y + sum }
            }
        }
    };
}

number!(f32);
number!(f64);
