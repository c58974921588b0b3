//! Image files: which can be kept as they are, and which become PNG.

use image::{
    DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageFormat, ImageReader, Rgba, RgbaImage,
};
use rhytid_core::{TextureFormat, check_pixels};
use std::io::Cursor;

/// A page in a browser draws rigs, whose images are PNG or JPEG already. Decoders would make it larger.
const IN_BROWSER: bool = cfg!(target_arch = "wasm32");

/// An image as a texture has it.
pub(super) struct Converted {
    pub(super) bytes: Vec<u8>,
    pub(super) format: TextureFormat,
    /// Whether the bytes are others than those of the file.
    pub(super) is_converted: bool,
}

/// Why an image is left out.
#[derive(Debug)]
pub(super) struct Refused {
    /// A phrase that follows the image's name.
    pub(super) what: String,
    /// What to do.
    pub(super) remedy: &'static str,
}

impl<S: Into<String>> From<S> for Refused {
    fn from(what: S) -> Self {
        Self { what: what.into(), remedy: "save it as PNG or JPEG" }
    }
}

/// Where the alpha of an image is taken from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(in super::super) enum AlphaOf {
    /// Its alpha.
    Alpha,
    /// Its brightness: the mean of red, green and blue as the file has them.
    Brightness,
    /// Its alpha if it has one, else its brightness.
    Either,
}

/// A PNG or JPEG as it is. A TGA, TIFF, BMP, WebP or JPEG of printing inks becomes a PNG. Any other file is
/// refused with a phrase that says what it is.
pub(super) fn converted(bytes: Vec<u8>) -> Result<Converted, Refused> {
    let format = recognised(&bytes)?;
    let kept = match format {
        ImageFormat::Png => Some(TextureFormat::Png),
        ImageFormat::Jpeg => Some(TextureFormat::Jpeg),
        _ => None,
    };
    if let Some(kept) = kept {
        // The head of the file says whether it is one that can be shown.
        if !IN_BROWSER {
            size(&bytes, format)?;
        }
        // Many programs cannot show inks.
        if kept == TextureFormat::Png || !is_of_inks(&bytes) {
            return Ok(Converted { bytes, format: kept, is_converted: false });
        }
    }
    if IN_BROWSER {
        return Err("is neither PNG nor JPEG, and a page in a browser converts nothing".into());
    }
    let image = decoded(&bytes, format)?;
    Ok(Converted { bytes: png(&image)?, format: TextureFormat::Png, is_converted: true })
}

/// Whether a JPEG has four printing inks in place of colours. A page in a browser does not know.
fn is_of_inks(jpeg: &[u8]) -> bool {
    #[cfg(not(target_arch = "wasm32"))]
    {
        use zune_jpeg::JpegDecoder;
        use zune_jpeg::zune_core::bytestream::ZCursor;
        use zune_jpeg::zune_core::colorspace::ColorSpace;
        let mut decoder = JpegDecoder::new(ZCursor::new(jpeg));
        decoder.decode_headers().is_ok()
            && matches!(decoder.input_colorspace(), Some(ColorSpace::CMYK | ColorSpace::YCCK))
    }
    #[cfg(target_arch = "wasm32")]
    {
        let _ = jpeg;
        false
    }
}

/// A PNG with the colours of one image, white if it is `None`, and the alpha of another. If their sizes
/// differ, each pixel of the colours takes the nearest alpha.
pub(super) fn with_alpha(color: Option<&[u8]>, alpha: &[u8], of: AlphaOf) -> Result<Vec<u8>, Refused> {
    if IN_BROWSER {
        return Err("is a file of its own, and a page in a browser converts nothing".into());
    }
    let alpha = decoded(alpha, recognised(alpha)?)?;
    let has_alpha = alpha.color().has_alpha();
    let alpha = alpha.into_rgba8();
    let mut image = match color {
        Some(color) => decoded(color, recognised(color)?)?.into_rgba8(),
        None => RgbaImage::from_pixel(alpha.width(), alpha.height(), Rgba([255; 4])),
    };
    let takes_alpha = of == AlphaOf::Alpha || (of == AlphaOf::Either && has_alpha);
    let nearest = |at: u32, size: u32, of: u32| (u64::from(at) * u64::from(of) / u64::from(size)) as u32;
    let (width, height) = image.dimensions();
    for (x, y, pixel) in image.enumerate_pixels_mut() {
        let at = [nearest(x, width, alpha.width()), nearest(y, height, alpha.height())];
        let Rgba([red, green, blue, opacity]) = *alpha.get_pixel(at[0], at[1]);
        let brightness = (u16::from(red) + u16::from(green) + u16::from(blue)) / 3;
        pixel.0[3] = if takes_alpha { opacity } else { brightness as u8 };
    }
    png(&DynamicImage::ImageRgba8(image))
}

/// Whether an image has an alpha below 1 anywhere.
pub(super) fn has_alpha(bytes: &[u8]) -> bool {
    let Ok(format) = recognised(bytes) else { return false };
    // A JPEG never has one. A PNG may say that it has one and be opaque.
    if IN_BROWSER || format == ImageFormat::Jpeg {
        return false;
    }
    let Ok(image) = decoded(bytes, format) else { return false };
    image.color().has_alpha() && image.into_rgba8().pixels().any(|pixel| pixel.0[3] < 255)
}

/// The format of a file, by its first bytes.
fn recognised(bytes: &[u8]) -> Result<ImageFormat, Refused> {
    let others: [(&[u8], &str); 6] = [
        (b"DDS ", "is a DDS file, which cannot be read"),
        (&[0xab, b'K', b'T', b'X', b' '], "is a KTX file, which cannot be read"),
        (&[0x76, 0x2f, 0x31, 0x01], "is an OpenEXR file, which cannot be read"),
        (b"#?RADIANCE", "is a Radiance HDR file, which cannot be read"),
        (b"8BPS", "is a Photoshop file, which cannot be read"),
        (b"GIF8", "is a GIF file, which cannot be read"),
    ];
    if let Some((_, what)) = others.iter().find(|(begin, _)| bytes.starts_with(begin)) {
        return Err((*what).into());
    }
    match image::guess_format(bytes) {
        Ok(
            format @ (ImageFormat::Png
            | ImageFormat::Jpeg
            | ImageFormat::Bmp
            | ImageFormat::Tiff
            | ImageFormat::WebP),
        ) => Ok(format),
        Ok(format) => Err(format!("is a {format:?} file, which cannot be read").into()),
        // TGA is the only format without a mark at its begin.
        Err(_) if !IN_BROWSER && size(bytes, ImageFormat::Tga).is_ok() => Ok(ImageFormat::Tga),
        Err(_) => Err("is of no known format".into()),
    }
}

/// The decoder of an image whose size is allowed.
fn decoder(bytes: &[u8], format: ImageFormat) -> Result<impl ImageDecoder + '_, Refused> {
    let damaged = |error: image::ImageError| format!("cannot be read ({error})");
    let decoder = ImageReader::with_format(Cursor::new(bytes), format).into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 {
        return Err("has no pixels".into());
    }
    check_pixels(width.into(), height.into()).map_err(|_| Refused {
        what: format!("is too large ({width} × {height} pixels)"),
        remedy: "save it smaller, or allow more pixels",
    })?;
    Ok(decoder)
}

/// Whether the head of an image can be read.
fn size(bytes: &[u8], format: ImageFormat) -> Result<(), Refused> {
    decoder(bytes, format).map(|_| ())
}

fn decoded(bytes: &[u8], format: ImageFormat) -> Result<DynamicImage, Refused> {
    let decoder = decoder(bytes, format)?;
    DynamicImage::from_decoder(decoder).map_err(|error| format!("cannot be read ({error})").into())
}

/// The image as PNG: of 8 bits a channel, grey images as colours.
fn png(image: &DynamicImage) -> Result<Vec<u8>, Refused> {
    let mut bytes = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
    let (width, height) = (image.width(), image.height());
    let written = match image.color().has_alpha() {
        true => encoder.write_image(&image.to_rgba8(), width, height, ExtendedColorType::Rgba8),
        false => encoder.write_image(&image.to_rgb8(), width, height, ExtendedColorType::Rgb8),
    };
    written.map_err(|error| format!("cannot be converted ({error})"))?;
    Ok(bytes)
}
