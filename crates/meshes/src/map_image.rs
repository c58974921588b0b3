//! Images over a mesh's texture coordinates whose colours are numbers.

use glam::DVec2;
use rhytid_core::{Error, Result, Uvs, check_palette, check_pixels, input_file};
use std::io::Cursor;
use std::path::Path;

/// An image of numbers: rows of pixels from the top, where the middle grey is 0.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MapImage {
    pub width: usize,
    pub height: usize,
    /// Numbers of each pixel: 1 of a grey image, 3 of a coloured one.
    pub channels: usize,
    samples_per_pixel: usize,
    /// Whether a sample has two bytes, the high one first.
    is_wide: bool,
    /// As the file has them: numbers take four times as much memory.
    samples: Vec<u8>,
}

impl MapImage {
    /// Reads a PNG of 8 or 16 bits: grey or coloured. Opacity is ignored.
    ///
    /// # Errors
    /// [`Error::Input`] if it is no such image; [`Error::Io`].
    pub(super) fn read(path: &Path) -> Result<Self> {
        let fault = |what: String| Error::unsupported_format(format!("{}: {what}", path.display()));
        let no_png = |e: png::DecodingError| {
            fault(format!("is no PNG that can be read ({e}); save the map as PNG, grey or RGB, of 16 bits"))
        };
        let bytes = input_file::read(path, input_file::LARGEST_MESH_OR_TAKE)?;
        let mut decoder = png::Decoder::new(Cursor::new(bytes));
        // Palettes and fewer bits become whole bytes.
        decoder.set_transformations(png::Transformations::EXPAND);
        let info = decoder.read_header_info().map_err(no_png)?;
        check_pixels(info.width.into(), info.height.into()).map_err(|error| error.in_file(path.display()))?;
        let mut reader = decoder.read_info().map_err(no_png)?;
        check_palette(reader.info().palette.as_deref()).map_err(|error| error.in_file(path.display()))?;
        let size = reader.output_buffer_size().ok_or_else(|| fault("is too large".into()))?;
        let mut samples = vec![0; size];
        let info = reader.next_frame(&mut samples).map_err(no_png)?;
        let (samples_per_pixel, channels) = match info.color_type {
            png::ColorType::Grayscale => (1, 1),
            png::ColorType::GrayscaleAlpha => (2, 1),
            png::ColorType::Rgba => (4, 3),
            _ => (3, 3),
        };
        let is_wide = info.bit_depth == png::BitDepth::Sixteen;
        let (width, height) = (info.width as usize, info.height as usize);
        Ok(Self { width, height, channels, samples_per_pixel, is_wide, samples })
    }

    /// A number of a pixel, from −1 for black to 1 for white.
    fn number(&self, pixel: usize, channel: usize) -> f32 {
        let at = pixel * self.samples_per_pixel + channel;
        match self.is_wide {
            true => {
                signed(u16::from_be_bytes([self.samples[2 * at], self.samples[2 * at + 1]]).into(), 65_535)
            }
            false => signed(self.samples[at].into(), 255),
        }
    }

    /// The numbers at texture coordinates, with v pointing up. Missing numbers repeat the first. Pixel
    /// centres have the values, and between them the image is linear. Beyond the image all numbers are 0:
    /// other images (UDIM) cover that part.
    pub(super) fn at(&self, uv: DVec2) -> [f64; 3] {
        // Some write the border itself a little beyond it.
        let is_there = |x: f64| (-1e-4..=1.0 + 1e-4).contains(&x);
        if !(is_there(uv.x) && is_there(uv.y)) {
            return [0.0; 3];
        }
        let place = |x: f64, size: usize| {
            let x = (x * size as f64 - 0.5).clamp(0.0, (size - 1) as f64);
            let low = x.floor() as usize;
            (low, (low + 1).min(size - 1), x - x.floor())
        };
        let ((x0, x1, s), (y0, y1, t)) = (place(uv.x, self.width), place(1.0 - uv.y, self.height));
        let pixel = |x: usize, y: usize, channel: usize| f64::from(self.number(y * self.width + x, channel));
        let between = |channel: usize| {
            let row = |y: usize| (1.0 - s) * pixel(x0, y, channel) + s * pixel(x1, y, channel);
            (1.0 - t) * row(y0) + t * row(y1)
        };
        [0, 1, 2].map(|channel: usize| between(channel.min(self.channels - 1)))
    }
}

/// Texture coordinates of a mesh by its corners, counted through all faces, and the corner's vertex.
///
/// # Errors
/// [`Error::Input`] if there are none.
pub(super) fn corner_uvs(uvs: Option<&Uvs>) -> Result<impl Fn(usize, u32) -> DVec2> {
    let Some(uvs) = uvs else {
        return Err(Error::bad_topology(
            "has no texture coordinates, which the map needs; export the mesh with them",
        ));
    };
    Ok(move |corner: usize, vertex: u32| {
        let at = uvs.corners.as_ref().map_or(vertex, |corners| corners[corner]);
        DVec2::from_array(uvs.values[at as usize].map(f64::from))
    })
}

/// −1 to 1 from 0 to `most`; both numbers in its middle are 0, so that a flat map moves nothing.
fn signed(value: u32, most: u32) -> f32 {
    let middle = most / 2;
    match value {
        v if v <= middle => -((middle - v) as f32) / middle as f32,
        v => (v - middle - 1) as f32 / middle as f32,
    }
}
