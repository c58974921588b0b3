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

/// Height of a line of words, in pixels, for a scale of 1.
pub const LINE: u32 = 24;

/// The size of a small letter, in pixels.
pub const SMALL: [u32; 2] = [9, 15];

/// The size of a legend, in pixels, for a scale of 1.
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

/// The scale of words below or in a picture of `size` pixels: 1 below 900 pixels of width or height, 2 below
/// 1,350, and so on.
pub fn letter_scale([width, height]: [u32; 2]) -> u32 {
    (width.min(height) / 450).clamp(1, 8)
}

impl Picture {
    /// Writes a line of Latin-1 letters of 10 × 20 pixels times `scale`, whose top is at `at`. Pixels outside
    /// the picture are left out.
    pub fn write(&mut self, words: &str, at: [i32; 2], anchor: Anchor, colour: [u8; 3], scale: u32) {
        Letters { picture: self, at, scale }.write(&FONT_10X20, words, anchor, colour);
    }

    /// Writes a line of Latin-1 letters of the size [`SMALL`] whose top left corner is at `at`, with a rim of
    /// one pixel of another colour around each letter. Pixels outside the picture are left out.
    pub fn write_small(&mut self, words: &str, [x, y]: [i32; 2], colour: [u8; 3], rim: [u8; 3]) {
        let mut write = |at, colour| {
            Letters { picture: self, at, scale: 1 }.write(&FONT_9X15_BOLD, words, Anchor::Left, colour);
        };
        for [right, down] in [[-1, 0], [1, 0], [0, -1], [0, 1], [-1, -1], [1, 1], [-1, 1], [1, -1]] {
            write([x + right, y + down], rim);
        }
        write([x, y], colour);
    }

    /// Draws the colours of `heat` as a bar with its numbers below, and `title` with its unit above. All of
    /// it has [`LEGEND`] pixels times `scale`. The ends say that what is beyond them has the same colour.
    pub fn legend(&mut self, heat: Heat, title: &str, at: [u32; 2], colour: [u8; 3], scale: u32) {
        let ([width, height], line) = (LEGEND.map(|n| n * scale), LINE * scale);
        let [low, high] = heat.range();
        self.write(title, [at[0] as i32, at[1] as i32], Anchor::Left, colour, scale);
        let bar = height - 2 * line;
        for x in 0..width.min(self.size[0].saturating_sub(at[0])) {
            let number = low + (high - low) * (x as f32 + 0.5) / width as f32;
            let [r, g, b] = heat.code(number);
            self.put(&Self::filled([1, bar], [r, g, b, 255]), [at[0] + x, at[1] + line]);
        }
        let below = (at[1] + line + bar) as i32;
        for (part, anchor) in [(0.0, Anchor::Left), (0.5, Anchor::Center), (1.0, Anchor::Right)] {
            let number = low + (high - low) * part;
            let text = match (number, part) {
                (0.0, _) => "0".to_owned(),
                (_, 1.0) => format!("{} and more", short(number)),
                (_, 0.0) => format!("{} and less", short(number)),
                _ => short(number),
            };
            let at = [(at[0] as f32 + part * width as f32) as i32, below + 2];
            self.write(&text, at, anchor, colour, scale);
        }
    }
}

/// A picture to write on. Each dot of a letter is a square of `scale` pixels a side.
struct Letters<'a> {
    picture: &'a mut Picture,
    /// The anchor of the words, in pixels.
    at: [i32; 2],
    scale: u32,
}

impl Letters<'_> {
    fn write(&mut self, font: &MonoFont<'_>, words: &str, anchor: Anchor, [r, g, b]: [u8; 3]) {
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
        let _ = Text::with_text_style(words, Point::zero(), font, style).draw(self);
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

impl OriginDimensions for Letters<'_> {
    fn size(&self) -> Size {
        Size::new(self.picture.size[0], self.picture.size[1])
    }
}

impl DrawTarget for Letters<'_> {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        let scale = self.scale as i32;
        for Pixel(dot, colour) in pixels {
            let corner = [self.at[0] + scale * dot.x, self.at[1] + scale * dot.y];
            for (x, y) in (0..scale * scale).map(|i| (corner[0] + i % scale, corner[1] + i / scale)) {
                self.picture.set([x, y], [colour.r(), colour.g(), colour.b(), 255]);
            }
        }
        Ok(())
    }
}

impl Picture {
    /// Sets a pixel, if the picture has it.
    fn set(&mut self, at: [i32; 2], colour: [u8; 4]) {
        let [Ok(x), Ok(y)] = at.map(u32::try_from) else { return };
        if x < self.size[0] && y < self.size[1] {
            let first = 4 * (y as usize * self.size[0] as usize + x as usize);
            self.pixels[first..first + 4].copy_from_slice(&colour);
        }
    }
}
