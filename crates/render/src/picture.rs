//! Pictures in memory, beside each other and as PNG.

use rhytid_core::{Error, Result};

/// A picture. Rows begin at the top. A pixel has 8 bits each of red, green, blue and opacity, in sRGB.
/// Colours are not multiplied by the opacity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Width × height × 4.
    pub pixels: Vec<u8>,
}

impl Picture {
    /// A picture of one colour.
    pub fn filled(size: [u32; 2], colour: [u8; 4]) -> Self {
        Self { size, pixels: colour.repeat(size[0] as usize * size[1] as usize) }
    }

    /// From pixels that a device has drawn. Their linear colours were multiplied by the opacity, and then
    /// converted to sRGB.
    pub(crate) fn from_multiplied(size: [u32; 2], mut pixels: Vec<u8>) -> Self {
        for pixel in pixels.as_chunks_mut::<4>().0 {
            let opacity = f32::from(pixel[3]) / 255.0;
            if opacity > 0.0 && opacity < 1.0 {
                for part in &mut pixel[..3] {
                    *part = to_srgb(from_srgb(*part) / opacity);
                }
            }
        }
        Self { size, pixels }
    }

    /// Whether no pixel lets anything be seen behind it.
    pub fn is_opaque(&self) -> bool {
        self.pixels.as_chunks::<4>().0.iter().all(|pixel| pixel[3] == 255)
    }

    /// Leaves out the opacity.
    pub fn make_opaque(&mut self) {
        self.pixels.as_chunks_mut::<4>().0.iter_mut().for_each(|pixel| pixel[3] = 255);
    }

    /// Red, green, blue and opacity of the pixel that is x to the right and y down from the upper left
    /// corner.
    ///
    /// # Panics
    /// If the pixel is outside the picture.
    pub fn pixel(&self, [x, y]: [u32; 2]) -> [u8; 4] {
        assert!(x < self.size[0] && y < self.size[1], "{x}, {y} is outside of {:?}", self.size);
        let at = 4 * (y as usize * self.size[0] as usize + x as usize);
        std::array::from_fn(|i| self.pixels[at + i])
    }

    /// Copies `other` into the picture, with its upper left corner at `at`. Pixels outside the picture are
    /// left out.
    pub fn put(&mut self, other: &Self, at: [u32; 2]) {
        let width = other.size[0].min(self.size[0].saturating_sub(at[0])) as usize;
        let height = other.size[1].min(self.size[1].saturating_sub(at[1]));
        if width == 0 {
            return;
        }
        for y in 0..height {
            let from = 4 * (y as usize * other.size[0] as usize);
            let to = 4 * ((at[1] + y) as usize * self.size[0] as usize + at[0] as usize);
            self.pixels[to..to + 4 * width].copy_from_slice(&other.pixels[from..from + 4 * width]);
        }
    }

    /// The picture as a PNG file.
    ///
    /// # Errors
    /// [`Error::Internal`] if the encoder refuses.
    pub fn png(&self) -> Result<Vec<u8>> {
        let failed = |e: png::EncodingError| Error::Internal(format!("a picture as PNG: {e}"));
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.size[0], self.size[1]);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(&self.pixels).map_err(failed)?;
        writer.finish().map_err(failed)?;
        Ok(bytes)
    }
}

/// From 8 bits of sRGB to linear, 0 to 1.
pub(crate) fn from_srgb(part: u8) -> f32 {
    let x = f32::from(part) / 255.0;
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// From linear to 8 bits of sRGB.
pub fn to_srgb(x: f32) -> u8 {
    let x = x.clamp(0.0, 1.0);
    let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u8
}
