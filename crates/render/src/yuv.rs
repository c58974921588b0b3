//! From red, green and blue to luma and colour differences.

use crate::Picture;

/// BT.709's weights of red and blue in luma.
const RED: f32 = 0.2126;
const BLUE: f32 = 0.0722;
/// The part of 255 that limited range uses, for luma and for colour differences.
const LUMA: f32 = 219.0 / 255.0;
const CHROMA: f32 = 224.0 / 255.0;

/// Converts one picture after another to planes, by BT.709 in limited range. The planes are luma, and the
/// differences of blue and of red to it. The differences have half the resolution (4:2:0), rounded up. As in
/// MPEG-2, each difference sits beside the left column of its four pixels.
pub(crate) struct Yuv {
    size: [usize; 2],
    luma: Vec<u8>,
    /// The differences of blue and of red to luma for each pixel of a row, summed over two rows.
    rows: [Vec<f32>; 2],
    chroma: [Vec<u8>; 2],
}

impl Yuv {
    /// For pictures of `size` pixels.
    pub(crate) fn new(size: [u32; 2]) -> Self {
        let size = size.map(|side| side as usize);
        let [width, height] = size;
        let chroma = vec![0; width.div_ceil(2) * height.div_ceil(2)];
        Self {
            size,
            luma: vec![0; width * height],
            rows: [vec![0.0; width], vec![0.0; width]],
            chroma: [chroma.clone(), chroma],
        }
    }

    pub(crate) fn size(&self) -> [u32; 2] {
        self.size.map(|side| side as u32)
    }

    /// Each plane and its width. The picture must have the size given to [`Yuv::new`].
    pub(crate) fn planes(&mut self, picture: &Picture) -> [(&[u8], usize); 3] {
        let [width, height] = self.size;
        let half = width.div_ceil(2);
        for top in (0..height).step_by(2) {
            self.rows.iter_mut().for_each(|row| row.fill(0.0));
            // If the number of rows is odd, the last row counts twice.
            for y in [top, (top + 1).min(height - 1)] {
                let pixels = &picture.pixels[4 * y * width..4 * (y + 1) * width];
                let luma = &mut self.luma[y * width..(y + 1) * width];
                let [blue, red] = &mut self.rows;
                for (x, [r, g, b, _]) in pixels.as_chunks::<4>().0.iter().enumerate() {
                    let [r, g, b] = [r, g, b].map(|&part| f32::from(part));
                    let y = RED * r + (1.0 - RED - BLUE) * g + BLUE * b;
                    luma[x] = (16.5 + LUMA * y) as u8;
                    blue[x] += b - y;
                    red[x] += r - y;
                }
            }
            let weights = [0.5 * CHROMA / (1.0 - BLUE), 0.5 * CHROMA / (1.0 - RED)];
            for ((row, plane), weight) in self.rows.iter().zip(&mut self.chroma).zip(weights) {
                let plane = &mut plane[top / 2 * half..(top / 2 + 1) * half];
                for (i, chroma) in plane.iter_mut().enumerate() {
                    let x = 2 * i;
                    let sum = row[x.saturating_sub(1)] + 2.0 * row[x] + row[(x + 1).min(width - 1)];
                    *chroma = (128.5 + weight * sum / 8.0) as u8;
                }
            }
        }
        [(&*self.luma, width), (&*self.chroma[0], half), (&*self.chroma[1], half)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_have_bt_709s_numbers() {
        // By ITU-R BT.709-6, item 4: the bars' primaries, white and black in 8 bits.
        for (colour, expected) in [
            ([255, 255, 255, 255], [235, 128, 128]),
            ([0, 0, 0, 255], [16, 128, 128]),
            ([255, 0, 0, 255], [63, 102, 240]),
            ([0, 255, 0, 255], [173, 42, 26]),
            ([0, 0, 255, 255], [32, 240, 118]),
        ] {
            let mut yuv = Yuv::new([5, 3]);
            let planes = yuv.planes(&Picture::filled([5, 3], colour));
            assert_eq!(planes.map(|(plane, width)| (plane.len(), width)), [(15, 5), (6, 3), (6, 3)]);
            for ((plane, _), expected) in planes.into_iter().zip(expected) {
                assert!(
                    plane.iter().all(|number| *number == expected),
                    "{colour:?}: {plane:?}, not {expected}"
                );
            }
        }
    }

    #[test]
    fn differences_are_where_the_left_pixels_are() {
        // A black picture with one red column. A pixel itself counts a half, and each neighbour a quarter.
        let at = |column: u32| {
            let mut picture = Picture::filled([8, 2], [0, 0, 0, 255]);
            picture.put(&Picture::filled([1, 2], [255, 0, 0, 255]), [column, 0]);
            Yuv::new([8, 2]).planes(&picture)[2].0.to_vec()
        };
        assert_eq!(at(4), [128, 128, 184, 128]);
        assert_eq!(at(5), [128, 128, 156, 156]);
    }
}
