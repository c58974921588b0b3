//! Arrays in textures, for shaders without storage buffers.

/// Texels of a row, in every texture: what any device with WebGL 2 has.
pub(crate) const WIDTH: usize = 2_048;

/// A texture for so many texels.
pub(crate) fn texture(
    device: &wgpu::Device,
    format: wgpu::TextureFormat,
    texels: usize,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("rig"),
        size: wgpu::Extent3d {
            width: WIDTH as u32,
            height: texels.div_ceil(WIDTH).max(1) as u32,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC | usage,
        view_formats: &[],
    })
}

/// A texture of words.
pub(crate) fn filled(device: &wgpu::Device, queue: &wgpu::Queue, words: &[u32]) -> wgpu::Texture {
    let texture = texture(device, wgpu::TextureFormat::R32Uint, words.len(), wgpu::TextureUsages::COPY_DST);
    write(queue, &texture, bytemuck::cast_slice(words));
    texture
}

/// Writes the first bytes of a texture: whole rows, and then a part of one.
pub(crate) fn write(queue: &wgpu::Queue, texture: &wgpu::Texture, bytes: &[u8]) {
    let texel = bytes_of_texel(texture);
    let row = WIDTH * texel;
    let (whole, part) = bytes.split_at(bytes.len() / row * row);
    let rows = (whole.len() / row) as u32;
    for (first, rows, bytes) in [(0, rows, whole), (rows, 1, part)] {
        let width = (bytes.len() / texel / rows.max(1) as usize) as u32;
        if bytes.is_empty() {
            continue;
        }
        let to = wgpu::TexelCopyTextureInfo {
            origin: wgpu::Origin3d { x: 0, y: first, z: 0 },
            ..texture.as_image_copy()
        };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * texel as u32),
            rows_per_image: None,
        };
        let size = wgpu::Extent3d { width, height: rows, depth_or_array_layers: 1 };
        queue.write_texture(to, bytes, layout, size);
    }
}

/// The bytes of a texel: one word, or four.
pub(crate) fn bytes_of_texel(texture: &wgpu::Texture) -> usize {
    if texture.format() == wgpu::TextureFormat::R32Uint { 4 } else { 16 }
}

/// The bytes of a whole texture.
pub(crate) fn bytes_of(texture: &wgpu::Texture) -> u64 {
    u64::from(texture.width()) * u64::from(texture.height()) * bytes_of_texel(texture) as u64
}
