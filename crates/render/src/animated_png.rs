//! Moving pictures in PNG.

use crate::picture::Picture;
use std::io::{self, Write};

/// An animated PNG (APNG), written picture by picture: without loss, and in every browser. Programs that do not know it show its
/// first picture.
pub struct AnimatedPng<W: Write> {
    writer: png::Writer<W>,
    size: [u32; 2],
}

impl<W: Write> AnimatedPng<W> {
    /// Of `pictures`, at least one, of `size` pixels, `rate` of them a second (0.1 to 600), again and again.
    ///
    /// # Errors
    /// As `out`.
    pub fn new(out: W, size: [u32; 2], pictures: u32, rate: f64) -> io::Result<Self> {
        let mut encoder = png::Encoder::new(out, size[0], size[1]);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_animated(pictures, 0).map_err(plain)?;
        encoder.set_frame_delay(100, (100.0 * rate).round().clamp(1.0, 65_535.0) as u16).map_err(plain)?;
        Ok(Self { writer: encoder.write_header().map_err(plain)?, size })
    }

    /// The next picture.
    ///
    /// # Errors
    /// As what is written to; [`io::ErrorKind::InvalidInput`] if its size is another.
    pub fn add(&mut self, picture: &Picture) -> io::Result<()> {
        if picture.size != self.size {
            let what = format!("a picture of {:?} pixels among those of {:?}", picture.size, self.size);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
        }
        self.writer.write_image_data(&picture.pixels).map_err(plain)
    }

    /// Writes the end.
    ///
    /// # Errors
    /// As what is written to, or if pictures are missing.
    pub fn finish(self) -> io::Result<()> {
        self.writer.finish().map_err(plain)
    }
}

/// What was written to says what is wrong, in its own words.
fn plain(error: png::EncodingError) -> io::Error {
    match error {
        png::EncodingError::IoError(error) => error,
        other => other.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_and_their_times_come_back() {
        let pictures: Vec<Picture> = (0..3).map(|i| Picture::filled([5, 4], [i * 80, 10, 20, 255])).collect();
        let mut bytes = Vec::new();
        let mut animated = AnimatedPng::new(&mut bytes, [5, 4], 3, 24.0).unwrap();
        assert!(animated.add(&Picture::filled([4, 4], [0; 4])).is_err());
        pictures.iter().for_each(|picture| animated.add(picture).unwrap());
        animated.finish().unwrap();
        let mut reader = png::Decoder::new(io::Cursor::new(&bytes)).read_info().unwrap();
        assert_eq!(reader.info().animation_control.unwrap().num_frames, 3);
        let full = AnimatedPng::new(&mut [0; 60][..], [5, 4], 3, 24.0).err().map(|error| error.kind());
        assert_eq!(full, Some(io::ErrorKind::WriteZero));
        for picture in &pictures {
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            let control = reader.info().frame_control.unwrap();
            assert_eq!(f64::from(control.delay_num) / f64::from(control.delay_den), 1.0 / 24.0);
            assert!(pixels == picture.pixels);
        }
    }
}
