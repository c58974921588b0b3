//! Registers of numbers with the operations of the references' vector functions. The functions then compute
//! several vertices or frames at once, with the same bits as for one.
use pulp::Simd;
use rhytid_kernels::{IS_FUSED, Number};
use std::ops::{Add, Div, Mul, Sub};

/// One register of numbers.
#[derive(Clone, Copy)]
pub(crate) struct Lanes<S: Simd>(pub S, pub S::f32s);

impl<S: Simd> Lanes<S> {
    /// The `register`th register of numbers whose count is a multiple of the lanes.
    #[inline(always)]
    pub(crate) fn load(simd: S, numbers: &[f32], register: usize) -> Self {
        Self(simd, S::as_simd_f32s(numbers).0[register])
    }

    /// The same number in every lane.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f32) -> Self {
        Self(simd, simd.splat_f32s(value))
    }

    /// Writes the `register`th register of numbers whose count is a multiple of the lanes.
    #[inline(always)]
    pub(crate) fn store(self, numbers: &mut [f32], register: usize) {
        S::as_mut_simd_f32s(numbers).0[register] = self.1;
    }
}

/// The `register`th registers of three lines.
#[inline(always)]
pub(crate) fn load3<S: Simd>(simd: S, lines: &[impl AsRef<[f32]>; 3], register: usize) -> [Lanes<S>; 3] {
    let [x, y, z] = lines;
    [
        Lanes::load(simd, x.as_ref(), register),
        Lanes::load(simd, y.as_ref(), register),
        Lanes::load(simd, z.as_ref(), register),
    ]
}

/// The same vector in every lane.
#[inline(always)]
pub(crate) fn splat3<S: Simd>(simd: S, &[x, y, z]: &[f32; 3]) -> [Lanes<S>; 3] {
    [Lanes::splat(simd, x), Lanes::splat(simd, y), Lanes::splat(simd, z)]
}

/// Writes the `register`th registers of three lines.
#[inline(always)]
pub(crate) fn store3<S: Simd>(vector: [Lanes<S>; 3], lines: &mut [impl AsMut<[f32]>; 3], register: usize) {
    for c in 0..3 {
        vector[c].store(lines[c].as_mut(), register);
    }
}

macro_rules! operator {
    ($trait:ident, $function:ident, $simd:ident) => {
        impl<S: Simd> $trait for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(self.0, self.0.$simd(self.1, other.1))
            }
        }
    };
}

operator!(Add, add, add_f32s);
operator!(Sub, sub, sub_f32s);
operator!(Mul, mul, mul_f32s);
operator!(Div, div, div_f32s);

impl<S: Simd> Number for Lanes<S> {
    #[inline(always)]
    fn abs(self) -> Self {
        // `abs_f32s` is not always inlined, so that its instructions would be function calls.
        self.max(Self::splat(self.0, 0.0) - self)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0, self.0.max_f32s(self.1, other.1))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0, self.0.sqrt_f32s(self.1))
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        Self::splat(self.0, 1.0) / self
    }
    #[inline(always)]
    fn or_smallest_normal(self) -> Self {
        self.max(Self::splat(self.0, f32::MIN_POSITIVE))
    }
    #[inline(always)]
    fn or_one(self) -> Self {
        let is_zero = self.0.equal_f32s(self.1, self.0.splat_f32s(0.0));
        Self(self.0, self.0.select_f32s(is_zero, self.0.splat_f32s(1.0), self.1))
    }
    #[inline(always)]
    fn mul_add(self, y: Self, sum: Self) -> Self {
        if IS_FUSED { Self(self.0, self.0.mul_add_f32s(self.1, y.1, sum.1)) } else { self * y + sum }
    }
}
