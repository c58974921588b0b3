//! Weights of influences in 16 bits.

/// The bits of the exponent that are 0 in each stored weight, as bits of an f32.
const EXPONENT: u32 = 0x3000_0000;

/// The bits of an f32 that are not stored.
const DROPPED: u32 = 12;

/// The 16 bits in which devices keep a weight of an influence, from 0 to 1. It is a floating-point number
/// with an exponent of 5 bits and 11 bits behind the leading 1, so it is off by at most 1/4096 of the weight.
/// Weights below 2⁻³¹ become 0.
pub fn bits_of_weight(weight: f32) -> u16 {
    let Some(bits) = weight.max(0.0).to_bits().checked_sub(EXPONENT) else { return 0 };
    // To the nearest number. Of two equally near ones, the even one.
    let half = (1 << (DROPPED - 1)) - 1 + (bits >> DROPPED & 1);
    ((bits + half) >> DROPPED).min(u32::from(u16::MAX)) as u16
}

/// The weight that these bits stand for.
#[inline(always)]
pub fn weight_of_bits(bits: u16) -> f32 {
    // Without a branch, so that several are computed side by side.
    let is_some = u32::from(bits != 0).wrapping_neg();
    f32::from_bits(((u32::from(bits) << DROPPED) + EXPONENT) & is_some)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_off_by_at_most_a_4096th() {
        for i in 0..200_000u32 {
            let weight = (i as f32 * 1.000_1 / 200_000.0).powi(3).min(1.0);
            let kept = weight_of_bits(bits_of_weight(weight));
            let bound = if weight < f32::exp2(-31.0) { weight } else { weight / 4096.0 };
            assert!((kept - weight).abs() <= bound, "{weight}, {kept}");
        }
        assert_eq!(
            [0.0, 1.0, 0.5, 0.1f32.powi(20)].map(bits_of_weight).map(weight_of_bits),
            [0.0, 1.0, 0.5, 0.0]
        );
    }

    #[test]
    fn bits_stay_what_they_are() {
        for bits in (0..=u16::MAX).filter(|&bits| weight_of_bits(bits) <= 1.0) {
            assert_eq!(bits_of_weight(weight_of_bits(bits)), bits);
        }
    }
}
