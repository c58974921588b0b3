//! Text and legends in pictures.

use crate::heat::Heat;
use crate::picture::Picture;
use embedded_graphics::Pixel;
use embedded_graphics::mono_font::iso_8859_1::{FONT_9X15_BOLD, FONT_10X20};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::text::{Alignment, Baseline, Text, TextStyleBuilder};
use std::convert::Infallible;

/// Height of a line of words, in pixels.
pub const LINE: u32 = 24;

/// The size of a small letter, in pixels.
pub const SMALL: [u32; 2] = [9, 15];

/// The size of a legend, in pixels.
pub const LEGEND: [u32; 2] = [300, 2 * LINE + 8];

/// How text is aligned with its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins there.
    Left,
    /// The middle of the text is there.
    Center,
    /// The text ends there.
    Right,
}

impl Picture {
    /// Writes a line of Latin-1 letters of 10 × 20 pixels, whose top is at `at`. Pixels outside the picture
    /// are left out.
    pub fn write(&mut self, words: &str, at: [i32; 2], anchor: Anchor, colour: [u8; 3]) {
        self.write_with(&FONT_10X20, words, at, anchor, colour);
    }

    /// Writes a line of Latin-1 letters of the size [`SMALL`] whose top left corner is at `at`, with a rim of
    /// one pixel of another colour around each letter. Pixels outside the picture are left out.
    pub fn write_small(&mut self, words: &str, [x, y]: [i32; 2], colour: [u8; 3], rim: [u8; 3]) {
        for [right, down] in [[-1, 0], [1, 0], [0, -1], [0, 1], [-1, -1], [1, 1], [-1, 1], [1, -1]] {
            self.write_with(&FONT_9X15_BOLD, words, [x + right, y + down], Anchor::Left, rim);
        }
        self.write_with(&FONT_9X15_BOLD, words, [x, y], Anchor::Left, colour);
    }

    fn write_with(
        &mut self,
        font: &MonoFont<'_>,
        words: &str,
        at: [i32; 2],
        anchor: Anchor,
        [r, g, b]: [u8; 3],
    ) {
        let font = MonoTextStyle::new(font, Rgb888::new(r, g, b));
        let style = TextStyleBuilder::new()
            .baseline(Baseline::Top)
            .alignment(match anchor {
                Anchor::Left => Alignment::Left,
                Anchor::Center => Alignment::Center,
                Anchor::Right => Alignment::Right,
            })
            .build();
        // It never fails.
        let _ = Text::with_text_style(words, Point::new(at[0], at[1]), font, style).draw(self);
    }

    /// Draws the colours of `heat` as a bar of [`LEGEND`] pixels with its numbers below, and `title` with its
    /// unit above. The ends say that what is beyond them has the same colour.
    pub fn legend(&mut self, heat: Heat, title: &str, at: [u32; 2], colour: [u8; 3]) {
        let [width, height] = LEGEND;
        let [low, high] = heat.range();
        self.write(title, [at[0] as i32, at[1] as i32], Anchor::Left, colour);
        let bar = height - 2 * LINE;
        for x in 0..width.min(self.size[0].saturating_sub(at[0])) {
            let number = low + (high - low) * (x as f32 + 0.5) / width as f32;
            let [r, g, b] = heat.code(number);
            self.put(&Self::filled([1, bar], [r, g, b, 255]), [at[0] + x, at[1] + LINE]);
        }
        let below = (at[1] + LINE + bar) as i32;
        for (part, anchor) in [(0.0, Anchor::Left), (0.5, Anchor::Center), (1.0, Anchor::Right)] {
            let number = low + (high - low) * part;
            let text = match (number, part) {
                (0.0, _) => "0".to_owned(),
                (_, 1.0) => format!("{} and more", short(number)),
                (_, 0.0) => format!("{} and less", short(number)),
                _ => short(number),
            };
            self.write(&text, [(at[0] as f32 + part * width as f32) as i32, below + 2], anchor, colour);
        }
    }
}

/// A number of three digits.
fn short(number: f32) -> String {
    let digits = (2 - number.abs().log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{number:.digits$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

impl OriginDimensions for Picture {
    fn size(&self) -> Size {
        Size::new(self.size[0], self.size[1])
    }
}

impl DrawTarget for Picture {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(at, colour) in pixels {
            let (Ok(x), Ok(y)) = (u32::try_from(at.x), u32::try_from(at.y)) else { continue };
            if x < self.size[0] && y < self.size[1] {
                let first = 4 * (y as usize * self.size[0] as usize + x as usize);
                self.pixels[first..first + 4].copy_from_slice(&[colour.r(), colour.g(), colour.b(), 255]);
            }
        }
        Ok(())
    }
}
