//! Many pictures on one page.

use crate::heat::Heat;
use crate::picture::Picture;
use crate::words::{Anchor, LEGEND, LINE, letter_scale};
use rhytid_core::{Error, Result};

/// Pixels between and around pictures.
const GAP: u32 = 12;
/// No page has more pixels.
const MOST: u64 = 1 << 28;
const PAPER: [u8; 3] = [28, 30, 34];
const INK: [u8; 3] = [222, 224, 228];

/// Pictures of one size in rows. Each has a line of text below it. Legends of the colours are at the foot.
#[derive(Debug)]
pub struct Sheet {
    page: Picture,
    cell: [u32; 2],
    columns: u32,
    /// Pixels above the first row.
    top: u32,
    next: u32,
    /// The scale of the words.
    scale: u32,
}

impl Sheet {
    /// The colour of a page, as in pictures.
    pub const PAPER: [u8; 4] = [PAPER[0], PAPER[1], PAPER[2], 255];

    /// A page for `count` pictures of `size` pixels, with `legends`. A legend has the colours, and a name
    /// with the unit. A picture may have parts side by side; their `titles` stand above each column.
    ///
    /// # Errors
    /// [`Error::Input`] if the page would have more than 268 million pixels.
    pub fn new(count: u32, size: [u32; 2], titles: &[&str], legends: &[(Heat, &str)]) -> Result<Self> {
        let scale = letter_scale(size);
        let (line, legend) = (LINE * scale, LEGEND.map(|n| n * scale));
        let cell = [size[0].saturating_add(GAP), size[1].saturating_add(line + GAP)];
        // This makes the page about as wide as a screen.
        let ideal = (f64::from(count) * f64::from(cell[1]) / f64::from(cell[0]) * 1.6).sqrt().round();
        let rows = count.div_ceil((ideal as u32).max(1)).max(1);
        // The last row has as few empty places as possible.
        let columns = count.div_ceil(rows).max(1);
        let top = GAP + if titles.is_empty() { 0 } else { line };
        let foot = if legends.is_empty() { 0 } else { legend[1] + line + GAP };
        let least = GAP + legends.len() as u32 * (legend[0] + 4 * GAP);
        let width = columns.saturating_mul(cell[0]).saturating_add(GAP).max(least);
        let height = rows.saturating_mul(cell[1]).saturating_add(top + foot);
        if u64::from(width) * u64::from(height) > MOST {
            return Err(Error::too_large(format!(
                "a page of {count} pictures of {} × {} pixels would have {width} × {height}, expected at most {MOST} in all; \
                 ask for fewer or smaller ones",
                size[0], size[1]
            )));
        }
        let [r, g, b] = PAPER;
        let mut page = Picture::filled([width, height], [r, g, b, 255]);
        for (i, (heat, title)) in (0..).zip(legends) {
            let at = [2 * GAP + i * (legend[0] + 4 * GAP), rows * cell[1] + top];
            page.legend(*heat, title, at, INK, scale);
        }
        let part = size[0] / titles.len().max(1) as u32;
        for column in 0..columns {
            for (i, title) in (0..).zip(titles) {
                let middle = GAP + column * cell[0] + i * part + part / 2;
                // Letters are 10 pixels wide.
                let title: String = title.chars().take((part / (10 * scale)) as usize).collect();
                page.write(&title, [middle as i32, GAP as i32], Anchor::Center, INK, scale);
            }
        }
        Ok(Self { page, cell, columns, top, next: 0, scale })
    }

    /// Adds the next picture to the page, with `words` below it.
    pub fn add(&mut self, picture: &Picture, words: &str) {
        let [column, row] = [self.next % self.columns, self.next / self.columns];
        self.next += 1;
        let at = [GAP + column * self.cell[0], self.top + row * self.cell[1]];
        self.page.put(picture, at);
        let middle = [(at[0] + picture.size[0] / 2) as i32, (at[1] + picture.size[1] + 2) as i32];
        self.page.write(words, middle, Anchor::Center, INK, self.scale);
    }

    /// The page.
    pub fn into_picture(self) -> Picture {
        self.page
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_picture_is_somewhere_and_whole() {
        for count in [1, 2, 7, 12] {
            let mut sheet =
                Sheet::new(count, [60, 80], &["a", "long title"], &[(Heat::Signed(0.1), "strain")]).unwrap();
            let inked = |page: &Picture| {
                let above = page.pixels.as_chunks::<4>().0.iter().take((page.size[0] * GAP + 1) as usize);
                let title =
                    page.pixels.as_chunks::<4>().0.iter().take((page.size[0] * (GAP + LINE)) as usize);
                above.copied().all(|p| p == Sheet::PAPER) && title.copied().any(|p| p != Sheet::PAPER)
            };
            assert!(inked(&sheet.page) && !inked(&Sheet::new(count, [60, 80], &[], &[]).unwrap().page));
            for i in 0..count {
                sheet.add(&Picture::filled([60, 80], [200, i as u8, 0, 255]), &format!("frame {i}"));
            }
            let page = sheet.into_picture();
            for i in 0..count {
                let found = page.pixels.as_chunks::<4>().0.iter().filter(|p| **p == [200, i as u8, 0, 255]);
                assert_eq!(found.count(), 60 * 80, "picture {i} of {count}");
            }
        }
        let refused = Sheet::new(1_000_000, [1000, 1000], &[], &[]).unwrap_err().to_string();
        assert!(refused.contains("ask for fewer or smaller ones"), "{refused}");
    }
}
