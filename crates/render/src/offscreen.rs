//! Pictures without a window.

use crate::picture::{Picture, from_srgb};
use crate::read_back::mapped;
use crate::target::Target;
use rhytid_core::{Error, Result};

/// A texture to draw into and read back.
#[derive(Debug)]
pub struct Offscreen {
    device: wgpu::Device,
    queue: wgpu::Queue,
    size: [u32; 2],
    /// The texture with several samples for each pixel.
    fine: wgpu::TextureView,
    color: wgpu::Texture,
    depth: wgpu::TextureView,
}

impl Offscreen {
    /// The target for which a [`crate::Renderer`] has to be made.
    pub const TARGET: Target = Target {
        color: wgpu::TextureFormat::Rgba8UnormSrgb,
        depth: wgpu::TextureFormat::Depth32Float,
        samples: 4,
    };

    /// A texture of `size` pixels, width and height.
    ///
    /// # Errors
    /// [`Error::Input`] if the device has no textures of that size; [`Error::Device`], such as for lack of
    /// memory.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, size: [u32; 2]) -> Result<Self> {
        let [width, height] = size;
        let most = device.limits().max_texture_dimension_2d;
        if size.iter().any(|n| !(1..=most).contains(n)) {
            return Err(Error::out_of_range(format!(
                "a picture of {width} × {height} pixels: expected 1 to {most} each way on this device"
            )));
        }
        let (needed, most) =
            (u64::from(row_bytes(width)) * u64::from(height), device.limits().max_buffer_size);
        let what = format!("a picture of {width} × {height} pixels");
        crate::allowed(&what, &[("max_buffer_size", needed, most)], "ask for a smaller picture")?;
        let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let texture = |format, sample_count, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some("picture"),
                size: extent,
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            })
        };
        let Target { color, depth, samples } = Self::TARGET;
        let none = wgpu::TextureUsages::empty();
        crate::checked(device, "making room for a picture", || Self {
            device: device.clone(),
            queue: queue.clone(),
            size,
            fine: texture(color, samples, none).create_view(&wgpu::TextureViewDescriptor::default()),
            color: texture(color, 1, wgpu::TextureUsages::COPY_SRC),
            depth: texture(depth, samples, none).create_view(&wgpu::TextureViewDescriptor::default()),
        })
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The width over the height.
    pub fn aspect(&self) -> f32 {
        self.size[0] as f32 / self.size[1] as f32
    }

    /// Runs `draw` over a `background`, whose colour is as in pictures. Waits, and gives the picture.
    ///
    /// # Errors
    /// As `draw`; [`Error::Device`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn draw(
        &self,
        background: [u8; 4],
        draw: impl FnOnce(&mut wgpu::RenderPass<'_>) -> Result<()>,
    ) -> Result<Picture> {
        self.paint(background, draw)?;
        Picture::read(&self.device, &self.queue, &self.color)
    }

    /// The texture into which it draws. It has the color format of [`Offscreen::TARGET`], and can be copied
    /// from.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.color
    }

    /// Has the picture's bytes copied into a texture of the same size. The texture has the same format, with
    /// or without the suffix of sRGB, and the usage `COPY_DST`.
    pub fn copy_to(&self, encoder: &mut wgpu::CommandEncoder, texture: &wgpu::Texture) {
        let extent = self.color.size();
        let is_webgl =
            cfg!(target_arch = "wasm32") && self.device.adapter_info().backend == wgpu::Backend::Gl;
        if !is_webgl {
            encoder.copy_texture_to_texture(self.color.as_image_copy(), texture.as_image_copy(), extent);
            return;
        }
        // WebGL copies no texture of sRGB to one of another kind. So the bytes go through a buffer.
        let [width, height] = self.size;
        let between = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("copied picture"),
            size: u64::from(row_bytes(width)) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let bytes_per_row = Some(row_bytes(width));
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
        let rows = wgpu::TexelCopyBufferInfo { buffer: &between, layout };
        encoder.copy_texture_to_buffer(self.color.as_image_copy(), rows, extent);
        encoder.copy_buffer_to_texture(rows, texture.as_image_copy(), extent);
    }

    /// Runs `draw` over a `background`, for callers that use the [texture](Offscreen::texture) on the device.
    /// It reads nothing back, and does not wait.
    ///
    /// # Errors
    /// As `draw`; [`Error::Device`].
    pub fn paint(
        &self,
        background: [u8; 4],
        draw: impl FnOnce(&mut wgpu::RenderPass<'_>) -> Result<()>,
    ) -> Result<()> {
        let a = f64::from(background[3]) / 255.0;
        let [r, g, b] = [0, 1, 2].map(|i| a * f64::from(from_srgb(background[i])));
        crate::checked(&self.device, "drawing", || {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let resolved = self.color.create_view(&wgpu::TextureViewDescriptor::default());
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &self.fine,
                    depth_slice: None,
                    resolve_target: Some(&resolved),
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a }),
                        store: wgpu::StoreOp::Discard,
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.depth,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(1.0),
                        store: wgpu::StoreOp::Discard,
                    }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            draw(&mut pass)?;
            drop(pass);
            self.queue.submit([encoder.finish()]);
            Ok(())
        })?
    }
}

impl Picture {
    /// Reads the picture in `texture`, which has the format `Rgba8UnormSrgb` and the usage `COPY_SRC`. Work
    /// that was submitted to `queue` before is included. Waits for it.
    ///
    /// # Errors
    /// [`Error::Device`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Result<Self> {
        pollster::block_on(Self::read_async(device, queue, texture))
    }

    /// [`Picture::read`] for browsers, which do not allow waiting. Elsewhere it waits within the first poll.
    ///
    /// # Errors
    /// [`Error::Device`].
    pub async fn read_async(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        texture: &wgpu::Texture,
    ) -> Result<Self> {
        const DOING: &str = "reading a picture";
        let size = [texture.width(), texture.height()];
        let buffer = crate::checked(device, DOING, || {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("picture"),
                size: u64::from(row_bytes(size[0])) * u64::from(size[1]),
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            });
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let bytes_per_row = Some(row_bytes(size[0]));
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
            let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
            encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
            queue.submit([encoder.finish()]);
            buffer
        })?;
        let mapped = mapped(device, &buffer, DOING).await?;
        let rows = mapped.chunks_exact(row_bytes(size[0]) as usize);
        let pixels = rows.flat_map(|row| &row[..4 * size[0] as usize]).copied().collect();
        Ok(Self::from_multiplied(size, pixels))
    }
}

/// The bytes of a row in copies on devices.
fn row_bytes(width: u32) -> u32 {
    (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}
