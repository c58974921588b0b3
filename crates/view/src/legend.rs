//! The legend of a map: its colours, its numbers, and what is beyond them or has none.

use crate::settings::Map;
use crate::theme;
use eframe::egui::{self, Align2, Color32, Pos2, Rect, Shape, Stroke, pos2, vec2};
use rhytid_core::human;

/// The steps of the bar of colours.
const STEPS: usize = 64;

/// A narrower bar has no number in its middle, in points.
const NARROW: f32 = 200.0;

/// The numbers of a map in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spread {
    /// The least and the largest of them.
    pub range: [f32; 2],
    /// The part of the vertices whose numbers are beyond the scale, from 0 to 1.
    pub beyond: f32,
    /// Whether some vertices have no number.
    pub has_gaps: bool,
}

impl Spread {
    /// Of `numbers`, for a scale from `low` to `high`. Those that are not finite are gaps.
    pub(crate) fn of(numbers: &[f32], [low, high]: [f32; 2]) -> Self {
        let mut spread = Self { range: [f32::INFINITY, f32::NEG_INFINITY], beyond: 0.0, has_gaps: false };
        let mut beyond = 0_usize;
        for &number in numbers {
            if !number.is_finite() {
                spread.has_gaps = true;
                continue;
            }
            spread.range = [spread.range[0].min(number), spread.range[1].max(number)];
            beyond += usize::from(number < low || number > high);
        }
        spread.beyond = beyond as f32 / numbers.len().max(1) as f32;
        spread
    }

    /// The largest size of a number. 0 where there are none.
    pub(crate) fn largest(self) -> f32 {
        let [low, high] = self.range;
        low.abs().max(high.abs()).min(f32::MAX) * f32::from(u8::from(low <= high))
    }
}

/// Draws the legend in the lower left corner of `rect`.
pub(crate) fn show(ui: &egui::Ui, rect: Rect, map: &Map<'_>, spread: Option<Spread>) {
    let [low, high] = map.heat.range();
    let [less, more] = match spread {
        Some(Spread { range: [least, most], .. }) => [least < low, most > high],
        None => [false; 2],
    };
    let font = egui::TextStyle::Body.resolve(ui.style());
    let colour = ui.visuals().strong_text_color();
    let line = ui.text_style_height(&egui::TextStyle::Body) + 2.0;
    let gaps = spread.is_some_and(|spread| spread.has_gaps);
    let width = (rect.width() - 48.0).clamp(120.0, 280.0);
    let lines = if gaps { 3.0 } else { 2.0 };
    let size = vec2(width + 24.0, lines * line + 14.0 + 16.0);
    let ground = Rect::from_min_size(rect.left_bottom() + vec2(8.0, -8.0 - size.y), size);
    let painter = ui.painter();
    painter.rect_filled(ground, 4.0, theme::over_picture(ui.visuals()));
    let write = |at: Pos2, align: Align2, words: &str| {
        painter.text(at, align, words, font.clone(), colour);
    };
    write(ground.min + vec2(12.0, 4.0), Align2::LEFT_TOP, &map.title_with_unit());
    let bar = Rect::from_min_size(ground.min + vec2(12.0, 6.0 + line), vec2(width, 14.0));
    for i in 0..STEPS {
        let x = |i: usize| bar.left() + bar.width() * i as f32 / STEPS as f32;
        let number = low + (high - low) * (i as f32 + 0.5) / STEPS as f32;
        let step = Rect::from_min_max(pos2(x(i), bar.top()), pos2(x(i + 1) + 0.5, bar.bottom()));
        painter.rect_filled(step, 0.0, colour_of(map, number));
    }
    // An end with an arrow has numbers beyond it.
    for (is_beyond, end, number, side) in [(less, bar.left(), low, -1.0), (more, bar.right(), high, 1.0)] {
        if is_beyond {
            let corners =
                [pos2(end, bar.top()), pos2(end + side * 9.0, bar.center().y), pos2(end, bar.bottom())];
            let arrow =
                Shape::convex_polygon(corners.to_vec(), colour_of(map, number), Stroke::new(1.0, colour));
            painter.add(arrow);
        }
    }
    let below = bar.bottom() + 2.0;
    let ticks =
        [(low, Align2::LEFT_TOP), (0.5 * (low + high), Align2::CENTER_TOP), (high, Align2::RIGHT_TOP)];
    for ((number, align), x) in ticks.into_iter().zip([bar.left(), bar.center().x, bar.right()]) {
        if align == Align2::CENTER_TOP && width < NARROW {
            continue;
        }
        painter.vline(x, bar.bottom() - 4.0..=bar.bottom() + 2.0, Stroke::new(1.0, colour));
        let beyond = match align {
            Align2::LEFT_TOP if less => " and less",
            Align2::RIGHT_TOP if more => " and more",
            _ => "",
        };
        write(pos2(x, below), align, &format!("{}{beyond}", map.words(number)));
    }
    if gaps {
        let at = pos2(bar.left(), below + line + 2.0);
        let swatch = Rect::from_min_size(at + vec2(0.0, 2.0), vec2(12.0, 12.0));
        painter.rect_filled(swatch, 2.0, colour_of(map, f32::NAN));
        write(at + vec2(18.0, 0.0), Align2::LEFT_TOP, "has no number");
    }
}

fn colour_of(map: &Map<'_>, number: f32) -> Color32 {
    let [r, g, b] = map.heat.code(number);
    Color32::from_rgb(r, g, b)
}

impl Map<'_> {
    /// The title with the unit of the numbers.
    pub(crate) fn title_with_unit(&self) -> String {
        match self.unit {
            "" => self.title.to_owned(),
            unit => format!("{}, {unit}", self.title),
        }
    }

    /// A number of the map in its unit.
    pub(crate) fn words(&self, number: f32) -> String {
        // Three digits are as much as anybody reads from colours.
        let number = f64::from(self.factor * number);
        let power = 10_f64.powi(2 - number.abs().max(1e-6).log10().floor() as i32);
        human::number((number * power).round() / power)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_render::Heat;

    #[test]
    fn what_is_beyond_a_scale_is_counted() {
        let spread = Spread::of(&[0.0, -0.4, 0.2, f32::NAN], [-0.3, 0.3]);
        assert_eq!(spread, Spread { range: [-0.4, 0.2], beyond: 0.25, has_gaps: true });
        assert_eq!(spread.largest(), 0.4);
        let none = Spread::of(&[f32::NAN], [0.0, 1.0]);
        assert_eq!((none.largest(), none.beyond, none.has_gaps), (0.0, 0.0, true));
    }

    #[test]
    fn ticks_are_in_the_unit_of_the_map() {
        let strain = Map { heat: Heat::Signed(0.3), title: "strain", unit: "%", factor: 100.0 };
        assert_eq!([-0.3, 0.0, 0.3].map(|x| strain.words(x)), ["-30", "0", "30"]);
        assert_eq!(strain.title_with_unit(), "strain, %");
        let numbers = Map { heat: Heat::From0(0.016), title: "wear", unit: "", factor: 1.0 };
        assert_eq!([0.0, 0.008, 0.016].map(|x| numbers.words(x)), ["0", "0.008", "0.016"]);
    }
}
