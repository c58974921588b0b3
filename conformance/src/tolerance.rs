//! The one table of tolerances: the number of roundings on the way of each term.
//!
//! # What is counted
//!
//! A kernel computes sums of products. A number may be off by `n ε Σ|aᵢ bᵢ|`. Here n is the number of
//! roundings from the inputs to the result through one term. [`crate::reference`] computes the sums, and this
//! table has the numbers n. n ε is taken as `n ε / (1 − n ε)` ([`gamma`]), which includes all products of
//! roundings.
//!
//! # What a conforming device may do
//!
//! - **Add, subtract, multiply: one unit in the last place.** Vulkan and WebGPU ask for correct rounding, but
//!   not in which direction, so ε is a whole unit ([`EPSILON`]), not half of one.
//! - **Divide: 2.5 units** in Vulkan, WebGPU and OpenCL 1.2 alike.
//! - **Square root: 4.5 units.** OpenCL allows 3; Vulkan and WebGPU `1 / inverseSqrt(x)`: 2 and a division.
//! - **Any order of a sum**, so every term is counted as if it were added first. That covers trees and SIMD
//!   lanes.
//! - **Any corner of a triangle** as the one from which its area is computed.
//! - **Fused operations**: `a b + c` with one rounding has fewer roundings than two.
//! - **Flushed denormals**: numbers below [`TINY`] may become 0, in inputs, in between and in results.
//!
//! A changed formula is not covered: `b (p − r)` computed as `b p − b r`, or `rest` added first to the sum of
//! displacements. Such a device gives visibly worse positions, and fails.
use rhytid_core::Stage;

/// One unit in the last place of 1 in f32, 2⁻²³: the largest error of one operation, relative to its result.
pub const EPSILON: f64 = f32::EPSILON as f64;

/// The smallest normal f32: the largest loss where a device flushes smaller numbers to zero.
pub const TINY: f64 = f32::MIN_POSITIVE as f64;

/// The smallest normal fp16 number: a basis stored as fp16 may lose smaller ones.
pub const TINY_HALF: f64 = 1.0 / (1u64 << 14) as f64;

/// Roundings of an addition, a subtraction or a multiplication.
const ONE: f64 = 1.0;
/// Units in the last place by which a quotient may be off.
const DIVIDE: f64 = 2.5;
/// Units in the last place by which a square root may be off.
const ROOT: f64 = 4.5;

/// A length `√(x² + y² + z²)` of a difference. The difference (doubled by its square), the square and two
/// sums, all halved by the root; and the root.
const LENGTH: f64 = (2.0 * ONE + ONE + 2.0 * ONE) / 2.0 + ROOT;

/// The same on the host, which prepares the rest lengths. It rounds to nearest, so each rounding is half a
/// unit.
const REST_LENGTH: f64 = ((2.0 + 1.0 + 2.0) / 2.0 + 1.0) / 2.0;

/// `strain`, relative to `Σ (|u₁| + |u₂|) (|e| + |ē|)` over x, y, z: the displacements and their difference,
/// the edges and their sum, the product, two sums.
pub const STRAIN_PRODUCTS: f64 = 7.0;
/// `strain`, relative to itself: the length, its sum with the rest length, the rest length, and two
/// divisions.
pub const STRAIN_QUOTIENT: f64 = LENGTH + ONE + REST_LENGTH + 2.0 * DIVIDE;

/// `large_scale`, relative to `Σ|b u|`: the displacement, the product, H − 1 sums. A handle that turns has
/// another vector instead of the displacement, which the host rounds.
pub fn large_scale(handles: usize) -> f64 {
    handles as f64 + 1.0
}

/// `large_scale` where the handles turn: the difference, the product, three sums.
/// Relative to the centre's motion and to the sizes of the products with the coordinates from the centre.
pub const TURN: f64 = 5.0;

/// A vector strain, relative to `(|u₁| + |u₂|) / l`: the displacement, the difference of two, the division,
/// and the length. The host rounds the length by half a unit, and the examples' vector strains in the same
/// way.
pub const VECTOR_STRAIN: f64 = ONE + ONE + DIVIDE + 0.5;
/// A vector strain that is limited, relative to its components: its length, the host's limit, the division,
/// and the product.
pub const LIMITED: f64 = (ONE + 2.0 * ONE) / 2.0 + ROOT + ROUNDED + DIVIDE + ONE;
/// A number that the host rounds once, to nearest.
pub const ROUNDED: f64 = 0.5;

/// `vector_differences`, relative to itself: the square, two sums.
pub const SQUARED_DIFFERENCE: f64 = 3.0;

/// S of `bands`, relative to itself: the product with the weight, K + A − 1 sums, and one product with 0.9.
/// The factor 0.9 is itself rounded.
pub fn squared_distance(features: usize) -> f64 {
    features as f64 + 2.0
}

/// `bands`: the difference, the product, P sums.
/// Relative to the sum of the sizes of a and `(c/2) (S_0 − S_p)`, or of b and `w (r_p − r_0)`.
pub fn bands(examples: usize) -> f64 {
    examples as f64 + 2.0
}

/// `beyond`, relative to the sum of the sizes of the products: the product, K + A sums, the subtraction.
pub fn beyond(features: usize) -> f64 {
    features as f64 + 2.0
}

/// A distance of `bands`, relative to itself, beyond the error of its square.
pub const DISTANCE: f64 = ROOT;

/// `normals`: two differences, the product, the difference of products, the sum over triangles.
/// Relative to the sum of the products in the cross products of `triangles` triangles, for each component by
/// itself. Each triangle counts from the corner with the largest products, since a device may use any corner.
pub fn cross_products(triangles: usize) -> f64 {
    triangles as f64 + 3.0
}

/// `v / |v|` for a v that is known exactly, relative to each component.
/// The division by the largest component. Under the line, that division (doubled by the square), a square and
/// two sums, all halved by the root, and the root. Then the division by the root.
pub const UNIT: f64 = DIVIDE + ((2.0 * DIVIDE + ONE + 2.0 * ONE) / 2.0 + ROOT) + DIVIDE;

/// `detail`, relative to `|W| r_p + Σ|w| (r + r_p)`, or with |b| for the first term.
/// Roundings of r: the difference (doubled by the square), the square, the product with α, K − 1 sums (all
/// halved by the root), and the root. Then the difference from the pivot's r, or the rounding of W, the sum
/// of all weights. Then the product with w and N − 1 sums.
pub fn detail(centers: usize, influences: usize) -> f64 {
    (influences as f64 + 3.0) / 2.0 + ROOT + ONE + centers as f64
}

/// `fine_scale`'s tangent before it is normalised, `e − (e·n) n`, relative to `|e|`: two subtractions.
pub const TANGENT_EDGE: f64 = 2.0;
/// The same, relative to `Σ|e n| |n|`: the difference e, the product, two sums, the product with n, the
/// subtraction.
pub const TANGENT_ALONG: f64 = 6.0;
/// `b = n × t`, relative to `|n t|`: the product, the difference of products.
pub const BITANGENT: f64 = 2.0;
/// `t d₀ + b d₁ + n d₂`, relative to the sum of the sizes: the product, two sums.
pub const OFFSET: f64 = 3.0;

/// The last sum, of a rest or smooth position and a displacement, relative to the result.
pub const POSITION: f64 = ONE;

/// The relative error of `n` roundings together.
pub fn gamma(n: f64) -> f64 {
    n * EPSILON / (1.0 - n * EPSILON)
}

/// The table in words, for the report.
pub fn in_words(stage: Stage) -> &'static str {
    match stage {
        Stage::Strain => "7 ε Σ(|u₁| + |u₂|)(|e| + |ē|) / (L + l) / l + 14.75 ε |f|",
        Stage::LargeScale => {
            "(H + 1) ε Σ|b u| + ε |x|; and with bands (P + 2) ε (|a| + Σ|c/2| |S₀ − S_p|), the error of S times |c/2|, and ε |x|"
        }
        Stage::LargeScaleNormals | Stage::Normals => {
            "(T + 3) ε Σ|e f| over the area, for T triangles at the vertex, from the corner with the most, and 13.5 ε |n|"
        }
        Stage::Detail => {
            "(N + (K + 3)/2 + 5.5) ε (|Σw| r_p or |b|, + Σ|w| (r + r_p)), for the pivot p; of vector strains (P + 2) ε (|b| + Σ|w| |r_p − r₀|), \
             and the error of r times |w|"
        }
        Stage::Positions => "3 ε Σ|R d|, the error of the frame's t and b times d, and ε |x|",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The derivation repeated by hand. A wider tolerance needs a change here.
    #[test]
    fn the_table_is_the_one_that_was_derived() {
        assert_eq!(EPSILON, 2f64.powi(-23));
        assert_eq!(TINY, 2f64.powi(-126));
        assert_eq!(TINY_HALF, 2f64.powi(-14));
        assert_eq!([DIVIDE, ROOT], [2.5, 4.5]);
        assert_eq!([STRAIN_PRODUCTS, STRAIN_QUOTIENT], [7.0, 14.75]);
        assert_eq!([large_scale(1), large_scale(89)], [2.0, 90.0]);
        assert_eq!([VECTOR_STRAIN, ROUNDED, SQUARED_DIFFERENCE, DISTANCE], [5.0, 0.5, 3.0, 4.5]);
        assert_eq!([squared_distance(1), squared_distance(24), bands(1), bands(6)], [3.0, 26.0, 3.0, 8.0]);
        assert_eq!([cross_products(1), cross_products(6)], [4.0, 9.0]);
        assert_eq!(UNIT, 13.5);
        assert_eq!([detail(1, 1), detail(7, 16)], [8.5, 22.0]);
        assert_eq!([TANGENT_EDGE, TANGENT_ALONG, BITANGENT, OFFSET, POSITION], [2.0, 6.0, 2.0, 3.0, 1.0]);
        assert_eq!(gamma(0.0), 0.0);
        assert!((gamma(1000.0) / (1000.0 * EPSILON) - 1.0).abs() < 2e-4);
    }
}
