//! Animated images in WebP.

use crate::Picture;
use image_webp::{ColorType, WebPEncoder};
use std::io::{self, Seek, SeekFrom, Write};

/// Flags of the header `VP8X`: the file has opacities, and it is animated.
const OPACITY: u8 = 1 << 4;
const MOVES: u8 = 1 << 1;
/// Flag of a picture: it replaces the picture before it, instead of being blended over it.
const REPLACES: u8 = 1 << 1;
/// Bytes before the first chunk: `RIFF`, the size of the rest of the file, `WEBP`.
const FILE_HEADER: usize = 12;

/// An animated WebP, written picture by picture: without loss, with opacities, and in every browser.
pub struct AnimatedWebP<W: Write + Seek> {
    out: W,
    size: [u32; 2],
    rate: f64,
    pictures: u32,
    /// Bytes after the file's size.
    written: u64,
}

impl<W: Write + Seek> AnimatedWebP<W> {
    /// The most pixels along a side.
    pub const LARGEST: u32 = 16_384;

    /// Begins an animation of pictures of `size` pixels, `rate` of them a second (0.1 to 600), which repeats
    /// forever. `out` is at its beginning.
    ///
    /// # Errors
    /// Errors of `out`; [`io::ErrorKind::InvalidInput`] if a side is 0 or above [`AnimatedWebP::LARGEST`].
    pub fn new(out: W, size: [u32; 2], rate: f64) -> io::Result<Self> {
        if size.into_iter().any(|side| side == 0 || side > Self::LARGEST) {
            let what = format!("{} × {} pixels, expected 1 to {} each", size[0], size[1], Self::LARGEST);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
        }
        let mut webp = Self { out, size, rate: rate.clamp(0.1, 600.0), pictures: 0, written: 4 };
        // The size is written at the end.
        webp.out.write_all(b"RIFF\0\0\0\0WEBP")?;
        let [width, height] = size.map(|side| bytes_24(side - 1));
        webp.chunk(b"VP8X", &[&[OPACITY | MOVES, 0, 0, 0], &width, &height])?;
        // The background is transparent, and the animation repeats without end.
        webp.chunk(b"ANIM", &[&[0; 4], &[0; 2]])?;
        Ok(webp)
    }

    /// The next picture.
    ///
    /// # Errors
    /// Errors of `out`; [`io::ErrorKind::InvalidInput`] if the picture has another size, or the file would
    /// exceed the 4 GiB of a WebP.
    pub fn add(&mut self, picture: &Picture) -> io::Result<()> {
        if picture.size != self.size {
            let what = format!("a picture of {:?} pixels among those of {:?}", picture.size, self.size);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
        }
        let mut still = Vec::new();
        WebPEncoder::new(&mut still)
            .encode(&picture.pixels, self.size[0], self.size[1], ColorType::Rgba8)
            .map_err(io::Error::other)?;
        let [width, height] = self.size.map(|side| bytes_24(side - 1));
        // Times are rounded, not durations, so the durations add up.
        let [begin, end] = [0, 1].map(|i| (1000.0 * f64::from(self.pictures + i) / self.rate).round());
        let duration = bytes_24((end - begin) as u32);
        let at = [0; 6];
        self.chunk(b"ANMF", &[&at, &width, &height, &duration, &[REPLACES], &still[FILE_HEADER..]])?;
        self.pictures += 1;
        Ok(())
    }

    /// Writes the size.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn finish(mut self) -> io::Result<()> {
        self.out.seek(SeekFrom::Start(4))?;
        self.out.write_all(&(self.written as u32).to_le_bytes())
    }

    /// A chunk of the file, of an even number of bytes.
    fn chunk(&mut self, name: &[u8; 4], parts: &[&[u8]]) -> io::Result<()> {
        let size = parts.iter().map(|part| part.len()).sum::<usize>();
        self.written += 8 + size as u64;
        if self.written > u32::MAX.into() {
            let what = "more than the 4 GiB of a WebP; write fewer or smaller pictures, or a film (.mp4)";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
        }
        self.out.write_all(name)?;
        self.out.write_all(&(size as u32).to_le_bytes())?;
        parts.iter().try_for_each(|part| self.out.write_all(part))
    }
}

/// The lower 24 bits, from the lowest.
fn bytes_24(number: u32) -> [u8; 3] {
    let [a, b, c, _] = number.to_le_bytes();
    [a, b, c]
}

#[cfg(test)]
mod tests {
    use super::*;
    use image_webp::{LoopCount, WebPDecoder};
    use std::io::Cursor;

    #[test]
    fn pictures_and_their_times_come_back() {
        let pictures: Vec<Picture> =
            (0..7).map(|i| Picture::filled([5, 4], [i * 30, 10, 20, 255 - i * 20])).collect();
        let mut bytes = Cursor::new(Vec::new());
        let mut animated = AnimatedWebP::new(&mut bytes, [5, 4], 24.0).unwrap();
        assert!(animated.add(&Picture::filled([4, 4], [0; 4])).is_err());
        pictures.iter().for_each(|picture| animated.add(picture).unwrap());
        animated.finish().unwrap();
        let mut decoder = WebPDecoder::new(Cursor::new(bytes.into_inner())).unwrap();
        assert_eq!((decoder.dimensions(), decoder.num_frames()), ((5, 4), 7));
        assert!(decoder.is_animated() && decoder.has_alpha());
        assert_eq!(decoder.loop_count(), LoopCount::Forever);
        let mut durations = Vec::new();
        for picture in &pictures {
            let mut pixels = vec![0; decoder.output_buffer_size().unwrap()];
            durations.push(decoder.read_frame(&mut pixels).unwrap());
            assert!(pixels == picture.pixels);
        }
        assert_eq!(durations, [42, 41, 42, 42, 41, 42, 42]);
    }

    #[test]
    fn sizes_that_a_webp_cannot_have_are_refused() {
        for size in [[0, 4], [4, 16_385]] {
            assert!(AnimatedWebP::new(Cursor::new(Vec::new()), size, 24.0).is_err());
        }
        assert!(AnimatedWebP::new(Cursor::new(Vec::new()), [16_384, 1], 24.0).is_ok());
    }
}
