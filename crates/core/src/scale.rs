//! The ends of scales of colours: round numbers.

/// The numbers with which a scale may end, times powers of ten. Half of each is short, too.
const ENDS: [f32; 9] = [1.0, 1.2, 1.6, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0];

/// The part of the numbers that may be larger than the end of their scale, so that a few bad vertices do not
/// make all others white.
const CLIPPED: f64 = 0.03;

/// Numbers that differ by less than this part of them are the same end.
const SAME: f32 = 1e-3;

/// The end of a scale that begins at 0, for the numbers of these maps: a round number that only a few of them
/// exceed. Numbers that are not finite do not count.
pub fn end<'a>(maps: impl Iterator<Item = &'a [f32]>) -> f32 {
    let mut all: Vec<f32> = maps.flatten().copied().filter(|x| x.is_finite()).collect();
    if all.is_empty() {
        return 1.0;
    }
    let at = ((all.len() as f64 * (1.0 - CLIPPED)) as usize).min(all.len() - 1);
    let usual = *all.select_nth_unstable_by(at, f32::total_cmp).1;
    let most = all.into_iter().fold(0.0, f32::max);
    match (usual > 0.0, most > 0.0) {
        (true, _) => round_up(usual),
        // Nearly all numbers are 0.
        (false, true) => round_up(most),
        (false, false) => 1.0,
    }
}

/// The next round number that is at least `number`, which is above 0.
pub fn round_up(number: f32) -> f32 {
    let power = 10_f32.powf(number.log10().floor());
    let ends = ENDS.into_iter().map(|end| end * power);
    ends.into_iter().find(|end| *end >= number * (1.0 - SAME)).unwrap_or(10.0 * power)
}

/// The next round number that is at most `number`, which is above 0.
pub fn round_down(number: f32) -> f32 {
    let power = 10_f32.powf(number.log10().floor());
    let ends = ENDS.into_iter().rev().map(|end| end * power);
    ends.into_iter().find(|end| *end <= number * (1.0 + SAME)).unwrap_or(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_ends_at_a_round_number_that_a_few_exceed() {
        let values: Vec<f32> = (0..1000).map(|i| i as f32 / 100.0).collect();
        assert_eq!(end([&values[..500], &values[500..]].into_iter()), 10.0);
        assert_eq!((end([].into_iter()), end([&[0.0_f32; 5][..]].into_iter())), (1.0, 1.0));
        // Two bad vertices of a hundred do not change it, and neither does what has no number.
        let mut values = vec![0.37_f32; 100];
        values[..4].copy_from_slice(&[50.0, 1e9, f32::NAN, f32::INFINITY]);
        assert_eq!(end([&values[..]].into_iter()), 0.4);
        // One number that is not 0 is seen.
        values.fill(0.0);
        values[3] = 0.017;
        assert_eq!(end([&values[..]].into_iter()), 0.02);
    }

    #[test]
    fn round_numbers_are_near_on_both_sides() {
        for exponent in -30..30 {
            let number = 1.7 * 2.0_f32.powi(exponent);
            assert!((number..1.6 * number).contains(&round_up(number)), "{number} to {}", round_up(number));
            let below = round_down(number);
            assert!(below <= number && below > number / 1.6, "{number} to {below}");
            // A round number stays.
            assert_eq!((round_up(below), round_down(below)), (below, below));
        }
        assert_eq!([round_down(0.29), round_up(0.31), round_up(0.3)], [0.2, 0.4, 0.3]);
    }
}
