//! Colours for numbers. Equal steps between numbers look like equal steps between colours.

use crate::picture::to_srgb;

/// The number of colours in the table that a device reads. It is odd, so one colour is in the middle.
pub(crate) const COLOURS: usize = 65;

/// Which numbers have which colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Heat {
    /// From dark blue for 0 to yellow for this number, above 0. Larger numbers are yellow too.
    From0(f32),
    /// From blue for minus this number, above 0, over white for 0 to red.
    Signed(f32),
}

/// Linear red, green and blue of a place that has no number.
const GREY: [f32; 3] = [0.3; 3];

/// What stands for no number on a device, whose compilers may assume that NaN does not occur. A triangle with
/// such a corner has no number.
pub(crate) const NO_NUMBER: f32 = -1e36;

impl Heat {
    /// The colour of a place that has no number, NaN, in 8 bits of sRGB.
    pub fn grey() -> [u8; 3] {
        GREY.map(to_srgb)
    }

    /// The numbers that have the first and the last colour.
    pub fn range(self) -> [f32; 2] {
        match self {
            Self::From0(most) => [0.0, most],
            Self::Signed(most) => [-most, most],
        }
    }

    /// Linear red, green and blue, 0 to 1; grey for NaN. Steps are even in Oklab (Ottosson 2020), whose
    /// distances match those that the eye sees.
    pub fn colour(self, number: f32) -> [f32; 3] {
        if number.is_nan() {
            return GREY;
        }
        let [low, high] = self.range();
        let t = ((number - low) / (high - low)).clamp(0.0, 1.0);
        let lab = match self {
            // A helix at a constant distance from grey.
            Self::From0(_) => {
                let (sin, cos) = (270.0 + 205.0 * t).to_radians().sin_cos();
                [0.21 + 0.73 * t, CHROMA * cos, CHROMA * sin]
            }
            // Straight lines to white.
            Self::Signed(_) => {
                let s = 2.0 * t - 1.0;
                let (sin, cos) = if s < 0.0 { 255.0_f32 } else { 25.0 }.to_radians().sin_cos();
                [0.95 - 0.5 * s.abs(), 0.14 * s.abs() * cos, 0.14 * s.abs() * sin]
            }
        };
        linear_rgb(lab).map(|x| x.clamp(0.0, 1.0))
    }

    /// The same as 8 bits of sRGB, for a legend.
    pub fn code(self, number: f32) -> [u8; 3] {
        self.colour(number).map(to_srgb)
    }

    pub(crate) fn table(self) -> [[f32; 3]; COLOURS] {
        let [low, high] = self.range();
        std::array::from_fn(|i| self.colour(low + (high - low) * i as f32 / (COLOURS - 1) as f32))
    }
}

/// The chroma of [`Heat::From0`] in Oklab: the largest with which all its colours can be displayed.
const CHROMA: f32 = 0.13;

/// From Oklab to linear sRGB.
fn linear_rgb([l, a, b]: [f32; 3]) -> [f32; 3] {
    let cone = |x: f32, y: f32| (l + x * a + y * b).powi(3);
    let (l, m, s) = (
        cone(0.396_337_78, 0.215_803_76),
        cone(-0.105_561_346, -0.063_854_17),
        cone(-0.089_484_18, -1.291_485_5),
    );
    [
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_38 * s,
        -0.004_196_086 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From linear sRGB to Oklab, by the inverse matrices as they are published.
    fn oklab([r, g, b]: [f32; 3]) -> [f32; 3] {
        let l = (0.412_221_46 * r + 0.536_332_55 * g + 0.051_445_995 * b).cbrt();
        let m = (0.211_903_5 * r + 0.680_699_5 * g + 0.107_396_96 * b).cbrt();
        let s = (0.088_302_46 * r + 0.281_718_85 * g + 0.629_978_7 * b).cbrt();
        [
            0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_047 * s,
            1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
            0.025_904_037 * l + 0.782_771_77 * m - 0.808_675_77 * s,
        ]
    }

    #[test]
    fn steps_are_even_and_all_colours_can_be_shown() {
        for heat in [Heat::From0(2.0), Heat::Signed(0.1)] {
            let colours: Vec<[f32; 3]> = heat.table().into_iter().map(oklab).collect();
            let steps: Vec<f32> =
                colours.windows(2).map(|w| glam::Vec3::from(w[1]).distance(w[0].into())).collect();
            let mean = steps.iter().sum::<f32>() / steps.len() as f32;
            // A colour that cannot be shown would be clamped, and its steps be others.
            assert!(steps.iter().all(|step| (step / mean - 1.0).abs() < 0.03), "{heat:?}: {steps:?}");
        }
    }

    #[test]
    fn numbers_beyond_the_range_have_its_ends_colours() {
        let heat = Heat::Signed(2.0);
        assert_eq!(heat.colour(9.0), heat.colour(2.0));
        assert_eq!(heat.colour(-9.0), heat.colour(-2.0));
        assert_eq!(heat.code(f32::NAN), Heat::grey());
        let [r, g, b] = heat.colour(0.0);
        assert!(r.min(g).min(b) > 0.8 && r.max(g).max(b) - r.min(g).min(b) < 0.01, "white: {r} {g} {b}");
        let ([blue, .., more], [red, .., less]) = (heat.colour(-2.0), heat.colour(2.0));
        assert!(more > 2.0 * blue && red > 2.0 * less);
    }
}
