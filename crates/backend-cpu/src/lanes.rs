//! As many numbers as a processor's register holds, with the operations of the twins' vector functions: what those compute for one
//! vertex of one frame, they compute for several at once, with the same bits.
use pulp::Simd;
use rhytid_kernels::Number;
use std::ops::{Add, Div, Mul, Sub};

/// One register of numbers.
#[derive(Clone, Copy)]
pub struct Lanes<S: Simd>(pub S, pub S::f32s);

impl<S: Simd> Lanes<S> {
    /// The `part`th register of a row whose length is a multiple of the lanes.
    #[inline(always)]
    pub fn load(simd: S, row: &[f32], part: usize) -> Self {
        Self(simd, S::as_simd_f32s(row).0[part])
    }

    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: f32) -> Self {
        Self(simd, simd.splat_f32s(value))
    }

    /// Writes the `part`th register of a row.
    #[inline(always)]
    pub fn store(self, row: &mut [f32], part: usize) {
        S::as_mut_simd_f32s(row).0[part] = self.1;
    }
}

/// The `part`th registers of three rows.
#[inline(always)]
pub fn load3<S: Simd>(simd: S, rows: &[impl AsRef<[f32]>; 3], part: usize) -> [Lanes<S>; 3] {
    let [x, y, z] = rows;
    [
        Lanes::load(simd, x.as_ref(), part),
        Lanes::load(simd, y.as_ref(), part),
        Lanes::load(simd, z.as_ref(), part),
    ]
}

/// The same vector in every lane.
#[inline(always)]
pub fn splat3<S: Simd>(simd: S, &[x, y, z]: &[f32; 3]) -> [Lanes<S>; 3] {
    [Lanes::splat(simd, x), Lanes::splat(simd, y), Lanes::splat(simd, z)]
}

/// Writes the `part`th registers of three rows.
#[inline(always)]
pub fn store3<S: Simd>(vector: [Lanes<S>; 3], rows: &mut [impl AsMut<[f32]>; 3], part: usize) {
    for c in 0..3 {
        vector[c].store(rows[c].as_mut(), part);
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
    fn magnitude(self) -> Self {
        Self(self.0, self.0.abs_f32s(self.1))
    }
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self(self.0, self.0.max_f32s(self.1, other.1))
    }
    #[inline(always)]
    fn root(self) -> Self {
        Self(self.0, self.0.sqrt_f32s(self.1))
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        Self::splat(self.0, 1.0) / self
    }
    #[inline(always)]
    fn or_smallest_normal(self) -> Self {
        self.larger(Self::splat(self.0, f32::MIN_POSITIVE))
    }
    #[inline(always)]
    fn or_one(self) -> Self {
        let is_zero = self.0.equal_f32s(self.1, self.0.splat_f32s(0.0));
        Self(self.0, self.0.select_f32s(is_zero, self.0.splat_f32s(1.0), self.1))
    }
    #[inline(always)]
    fn times_plus(self, y: Self, sum: Self) -> Self {
        Self(self.0, self.0.mul_add_f32s(self.1, y.1, sum.1))
    }
}
