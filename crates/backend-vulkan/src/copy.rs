//! Copies from buffer to buffer, and the upload of the constants to the device.
use crate::barrier::Access;
use crate::buffer::Buffer;
use crate::commands::Commands;
use crate::context::Context;
use ash::vk;
use gpu_allocator::MemoryLocation;
use rhytid_core::plan::{Plan, Role};
use rhytid_core::{Result, Rig};
use std::sync::Arc;

/// Data are copied between host and device in pieces of at most this many bytes.
pub(crate) const STAGING_BYTES: u64 = 16 << 20;

pub(crate) fn region(from: usize, to: usize, bytes: usize) -> vk::BufferCopy {
    vk::BufferCopy { src_offset: from as u64, dst_offset: to as u64, size: bytes as u64 }
}

/// Fills the constants of `buffers`, one piece after the other through one staging buffer.
pub(crate) fn upload(
    plan: &Plan,
    rig: &Rig,
    buffers: &[Buffer],
    context: &Arc<Context>,
    commands: &mut Commands,
) -> Result<()> {
    let constants = plan.buffers().iter().filter(|buffer| matches!(buffer.role, Role::Constant { .. }));
    let bytes = constants.map(|buffer| buffer.bytes).sum::<u64>().clamp(4, STAGING_BYTES);
    let usage = vk::BufferUsageFlags::TRANSFER_SRC;
    let mut staging =
        Buffer::new(context, "constants from the host", bytes, usage, MemoryLocation::CpuToGpu)?;
    let mut filled = 0;
    let mut copies = Vec::new();
    for (i, buffer) in buffers.iter().enumerate() {
        let contents = plan.contents(rig, i);
        let mut done = 0;
        while done < contents.len() {
            let n = (contents.len() - done).min(staging.bytes - filled);
            staging.mapped()[filled..][..n].copy_from_slice(&contents[done..][..n]);
            copies.push((buffer.raw, region(filled, done, n)));
            filled += n;
            done += n;
            if filled == staging.bytes {
                copy(&staging, &copies, context, commands)?;
                copies.clear();
                filled = 0;
            }
        }
    }
    copy(&staging, &copies, context, commands)
}

/// Copies the contents of `staging`, and waits for the copy.
fn copy(
    staging: &Buffer,
    copies: &[(vk::Buffer, vk::BufferCopy)],
    context: &Context,
    commands: &mut Commands,
) -> Result<()> {
    let recording = commands.begin()?;
    for &(to, region) in copies {
        // SAFETY: both buffers are alive until the copy is done, and the region is within them.
        unsafe { context.device.cmd_copy_buffer(recording, staging.raw, to, &[region]) };
    }
    context.barrier(recording, Access::COPY_WRITE, Access::KERNEL_READ);
    // SAFETY: the commands are recorded above, and waited for below.
    unsafe { commands.submit(&[], &[]) }?;
    commands.wait()
}
