//! Copies from a device to the host.

use futures_channel::oneshot;
use rhytid_core::{DeviceErrorKind, Error, Result};

/// The bytes of a buffer with the usage `MAP_READ`, after all work that was submitted before. Outside of
/// browsers it waits within the first poll.
pub(crate) async fn mapped(device: &wgpu::Device, buffer: &wgpu::Buffer, doing: &str) -> Result<Vec<u8>> {
    let failed = |what: String| Error::Device {
        kind: DeviceErrorKind::Driver,
        device: crate::name(device),
        message: format!("{doing} failed: {what}"),
    };
    let (sender, is_mapped) = oneshot::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver may be gone.
        let _ = sender.send(result);
    });
    if cfg!(not(target_arch = "wasm32")) {
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| failed(e.to_string()))?;
    }
    let never = || failed("it was never handed over".to_owned());
    is_mapped.await.map_err(|_| never())?.map_err(|e| failed(e.to_string()))?;
    let bytes = buffer.get_mapped_range(..).map_err(|e| failed(e.to_string()))?.to_vec();
    Ok(bytes)
}

/// The floats of a part of a buffer with the usage `COPY_SRC`, after all work that was submitted before.
/// Outside of browsers it waits within the first poll.
///
/// # Errors
/// [`Error::Device`].
pub async fn read_floats(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
    bytes: std::ops::Range<u64>,
) -> Result<Vec<f32>> {
    const DOING: &str = "reading numbers";
    let staging = crate::checked(device, DOING, || {
        let staging = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("staging"),
            size: bytes.end - bytes.start,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, bytes.start, &staging, 0, bytes.end - bytes.start);
        queue.submit([encoder.finish()]);
        staging
    })?;
    Ok(bytemuck::pod_collect_to_vec(&mapped(device, &staging, DOING).await?))
}
