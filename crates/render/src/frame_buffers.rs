//! Frames that come from the host.

use crate::heat::NO_NUMBER;
use crate::vertices::Vertices;
use rhytid_core::{Result, human};

/// The buffers of one frame on a device.
#[derive(Debug)]
pub struct FrameBuffers {
    queue: wgpu::Queue,
    /// Positions, normals and numbers.
    buffers: [wgpu::Buffer; 3],
}

impl FrameBuffers {
    /// For a mesh of V `vertices`.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`] if the mesh is too large for `device`; [`rhytid_core::Error::Device`],
    /// as for want of memory.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, vertices: usize) -> Result<Self> {
        let what = format!("a mesh of {} vertices", human::count(vertices));
        let limits = [("max_buffer_size", 12 * vertices as u64, device.limits().max_buffer_size)];
        crate::allowed(&what, &limits, crate::FEWER)?;
        let buffer = |(label, floats): (&str, usize)| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: 4 * (floats * vertices).max(1) as u64,
                usage: wgpu::BufferUsages::VERTEX
                    | wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_DST
                    | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        };
        let buffers = || [("positions", 3), ("normals", 3), ("numbers", 1)].map(buffer);
        Ok(Self {
            queue: queue.clone(),
            buffers: crate::checked(device, "making room for a frame", buffers)?,
        })
    }

    /// Takes a frame: V × 3 positions and normals, and V numbers or none. A number that is NaN is grey in a
    /// heat map.
    pub fn set(&self, positions: &[f32], normals: &[f32], numbers: &[f32]) {
        let known: Vec<f32>;
        let mut numbers = numbers;
        if numbers.iter().any(|x| x.is_nan()) {
            known = numbers.iter().map(|x| if x.is_nan() { NO_NUMBER } else { *x }).collect();
            numbers = &known;
        }
        for (buffer, floats) in self.buffers.iter().zip([positions, normals, numbers]) {
            self.queue.write_buffer(buffer, 0, bytemuck::cast_slice(floats));
        }
    }

    /// The frame that was set last.
    pub fn vertices(&self) -> Vertices<'_> {
        let [positions, normals, numbers] = self.buffers.each_ref().map(|buffer| buffer.slice(..));
        Vertices { positions, normals, numbers: Some(numbers) }
    }
}
