//! Pictures as textures. They are read from files. Their mipmaps keep distant surfaces from shimmering.

use crate::picture::{Picture, from_srgb, to_srgb};
use rhytid_core::{Error, InputErrorKind, Result, check_palette, check_pixels};
use std::io::Cursor;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

impl Picture {
    /// Reads a PNG or JPEG. Fewer channels or other depths are converted to 8 bits of red, green, blue and
    /// opacity.
    ///
    /// # Errors
    /// [`Error::Input`], without the file's name, if the bytes are neither format, are damaged, or have more
    /// pixels than [`check_pixels`] allows.
    pub fn decode(bytes: &[u8]) -> Result<Self> {
        let read = match bytes {
            [0x89, b'P', b'N', b'G', ..] => png(bytes),
            [0xff, 0xd8, ..] => jpeg(bytes),
            _ => Err(Error::unsupported_format("is neither")),
        };
        read.map_err(|error| match error.input_kind() {
            Some(InputErrorKind::TooLarge) => error,
            _ => error.reworded(|why| format!("{why}, expected a sound PNG or JPEG; export the image again")),
        })
    }

    /// The picture at half its size, with at least one pixel along each side. A pixel is the mean of the
    /// pixels that it covers, as linear light.
    fn halved(&self) -> Self {
        let [width, height] = self.size;
        let size = self.size.map(|n| (n / 2).max(1));
        let covered = |i: u32, n: u32, of: u32| (i * of / n)..((i + 1) * of).div_ceil(n);
        let mut pixels = Vec::with_capacity(4 * size[0] as usize * size[1] as usize);
        for y in 0..size[1] {
            for x in 0..size[0] {
                let (mut sum, mut count) = ([0.0_f32; 4], 0.0);
                for row in covered(y, size[1], height) {
                    for column in covered(x, size[0], width) {
                        let [r, g, b, opacity] = self.pixel([column, row]);
                        let light = [from_srgb(r), from_srgb(g), from_srgb(b), f32::from(opacity)];
                        sum = std::array::from_fn(|c| sum[c] + light[c]);
                        count += 1.0;
                    }
                }
                let [r, g, b, opacity] = sum.map(|part| part / count);
                pixels.extend([to_srgb(r), to_srgb(g), to_srgb(b), opacity.round() as u8]);
            }
        }
        Self { size, pixels }
    }
}

fn png(bytes: &[u8]) -> Result<Picture> {
    let fault = |e: png::DecodingError| Error::malformed(format!("is not read as a PNG: {e}"));
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8() | png::Transformations::ALPHA);
    let header = decoder.read_header_info().map_err(fault)?;
    let size = [header.width, header.height];
    check_pixels(size[0].into(), size[1].into())?;
    let mut reader = decoder.read_info().map_err(fault)?;
    check_palette(reader.info().palette.as_deref())?;
    let mut pixels = vec![0; reader.output_buffer_size().ok_or_else(|| Error::too_large("is too large"))?];
    let found = reader.next_frame(&mut pixels).map_err(fault)?;
    if found.color_type == png::ColorType::GrayscaleAlpha {
        pixels =
            pixels.as_chunks().0.iter().flat_map(|&[grey, opacity]| [grey, grey, grey, opacity]).collect();
    }
    Ok(Picture { size, pixels })
}

fn jpeg(bytes: &[u8]) -> Result<Picture> {
    let options = DecoderOptions::default()
        .jpeg_set_out_colorspace(ColorSpace::RGBA)
        .set_max_width(usize::MAX)
        .set_max_height(usize::MAX);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    let fault = |e: zune_jpeg::errors::DecodeErrors| Error::malformed(format!("is not read as a JPEG: {e}"));
    decoder.decode_headers().map_err(fault)?;
    let (width, height) =
        decoder.dimensions().ok_or_else(|| Error::malformed("is not read as a JPEG: it has no size"))?;
    check_pixels(width as u64, height as u64)?;
    let pixels = decoder.decode().map_err(fault)?;
    match decoder.output_colorspace() {
        Some(ColorSpace::RGBA) => Ok(Picture { size: [width as u32, height as u32], pixels }),
        other => Err(Error::unsupported_format(format!(
            "is a JPEG of other colours than red, green and blue ({other:?})"
        ))),
    }
}

/// A picture as a texture with all its mipmaps. A picture that is too large for the device is reduced.
fn texture(device: &wgpu::Device, queue: &wgpu::Queue, picture: &Picture) -> wgpu::TextureView {
    let most = device.limits().max_texture_dimension_2d;
    let mut level = picture.clone();
    while level.size.iter().any(|n| *n > most) {
        level = level.halved();
    }
    let [width, height] = level.size;
    let levels = width.max(height).ilog2() + 1;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("image"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for mip_level in 0..levels {
        let [width, height] = level.size;
        queue.write_texture(
            wgpu::TexelCopyTextureInfo { mip_level, ..texture.as_image_copy() },
            &level.pixels,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width), rows_per_image: None },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        level = level.halved();
    }
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// How shaders get an image.
#[derive(Debug)]
pub(crate) struct Images {
    /// A texture and a sampler.
    pub layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
}

impl Images {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let filtering = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        Self {
            layout: device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("image"),
                entries: &[entry(0, texture), entry(1, filtering)],
            }),
            sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("image"),
                address_mode_u: wgpu::AddressMode::Repeat,
                address_mode_v: wgpu::AddressMode::Repeat,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..Default::default()
            }),
        }
    }

    /// A picture for a shader.
    pub(crate) fn group(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        picture: &Picture,
    ) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("image"),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&texture(device, queue, picture)),
                },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(&self.sampler) },
            ],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_halved_and_not_its_codes() {
        let (black, white) = ([0, 0, 0, 255], [255, 255, 255, 255]);
        let board = Picture { size: [2, 2], pixels: [black, white, white, black].concat() };
        // Half the light of white is 188 of 255.
        assert_eq!(board.halved(), Picture { size: [1, 1], pixels: vec![188, 188, 188, 255] });
        let greys = Picture { size: [1, 2], pixels: [[50, 50, 50, 255], [200, 200, 200, 255]].concat() };
        assert_eq!(greys.halved().pixel([0, 0]), [150, 150, 150, 255]);
        // Half of five pixels is two and a half. Each half takes three.
        let row = Picture { size: [5, 1], pixels: [white, black, black, black, black].concat() };
        let half = row.halved();
        assert_eq!((half.size, half.pixel([0, 0])[0], half.pixel([1, 0])[0]), ([2, 1], 156, 0));
    }

    #[test]
    fn what_is_no_image_is_refused_in_a_sentence() {
        let picture = Picture { size: [3, 2], pixels: (0..24).map(|i| 10 * i).collect() };
        assert_eq!(Picture::decode(&picture.png().unwrap()).unwrap(), picture);
        let png = picture.png().unwrap();
        for bytes in [&b"nonsense"[..], &[], &png[..png.len() / 2], &[0xff, 0xd8, 0xff, 0xe0]] {
            let refused = Picture::decode(bytes).unwrap_err().to_string();
            assert!(refused.contains("expected a sound PNG or JPEG"), "{refused}");
        }
    }

    #[test]
    fn grey_images_of_any_depth_are_read() {
        for (depth, bytes) in
            [(png::BitDepth::Eight, vec![0, 200]), (png::BitDepth::Sixteen, vec![0, 0, 200, 9])]
        {
            let mut file = Vec::new();
            let mut encoder = png::Encoder::new(&mut file, 2, 1);
            encoder.set_color(png::ColorType::Grayscale);
            encoder.set_depth(depth);
            encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
            let read = Picture::decode(&file).unwrap();
            assert_eq!(
                read,
                Picture { size: [2, 1], pixels: vec![0, 0, 0, 255, 200, 200, 200, 255] },
                "{depth:?}"
            );
        }
    }

    #[test]
    fn a_jpeg_is_read() {
        // Another program wrote this grey of 128, 8 by 8 pixels.
        let picture = Picture::decode(include_bytes!("../tests/grey.jpg")).unwrap();
        assert_eq!(picture.size, [8, 8]);
        assert!(picture.pixels.chunks(4).all(|p| p[3] == 255 && p[..3].iter().all(|x| x.abs_diff(128) < 2)));
    }
}
