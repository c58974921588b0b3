//! What a program that draws with wgpu already has: a device, a texture to draw into, and a pass.
use rhytid::render::Target;
use std::error::Error;

pub(crate) struct Host {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub color: wgpu::Texture,
    depth: wgpu::Texture,
}

impl Host {
    pub(crate) fn open(target: Target, [width, height]: [u32; 2]) -> Result<Self, Box<dyn Error>> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = wgpu::util::initialize_adapter_from_env_or_default(&instance, None);
        let adapter = pollster::block_on(adapter)?;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))?;
        let texture = |format, more| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: target.samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | more,
                view_formats: &[],
            })
        };
        let color = texture(target.color, wgpu::TextureUsages::COPY_SRC);
        let depth = texture(target.depth, wgpu::TextureUsages::empty());
        Ok(Self { device, queue, color, depth })
    }

    /// Draws a picture; `draw` adds to it.
    pub(crate) fn frame<T>(&self, draw: impl FnOnce(&mut wgpu::RenderPass<'_>) -> T) -> T {
        let [color, depth] = [&self.color, &self.depth]
            .map(|texture| texture.create_view(&wgpu::TextureViewDescriptor::default()));
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &color,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        let drawn = draw(&mut pass);
        drop(pass);
        self.queue.submit([encoder.finish()]);
        drawn
    }
}
