//! Many sessions, several threads, and more data than fit.
use super::support::{SMALL, assert_close, devices, evaluate, on_cpu, rig, take, validated};
use crate::Vulkan;
use crate::buffer::Buffer;
use ash::vk;
use gpu_allocator::MemoryLocation;
use rhytid_core::plan::Plan;
use rhytid_core::{DeviceErrorKind, Error, UploadOptions};
use std::sync::Arc;

#[test]
fn two_hundred_uploads_need_no_more_memory_than_one() {
    let rig = rig(SMALL);
    let options = UploadOptions::frames(2);
    for device in devices() {
        let vulkan = Vulkan::open_with(&device, false).unwrap();
        let capacity = || vulkan.context.with_allocator(|allocator| allocator.generate_report());
        let mut after_first = None;
        for i in 0..200 {
            let mut session = vulkan.upload_within(&rig, options, vulkan.context.limits).unwrap();
            let positions = take(&rig, 2, i);
            if i % 50 == 0 {
                assert_close(&evaluate(&mut session, &rig, &positions), &on_cpu(&rig, options, &positions));
            }
            drop(session);
            let report = capacity();
            assert_eq!(report.total_allocated_bytes, 0);
            assert_eq!(*after_first.get_or_insert(report.total_capacity_bytes), report.total_capacity_bytes);
        }
    }
}

#[test]
fn sessions_work_side_by_side_and_outlive_the_device() {
    let rig = rig(SMALL);
    let options = UploadOptions::frames(5);
    for device in devices() {
        let Some(vulkan) = validated(&device) else { continue };
        let messages = vulkan.context.messages().unwrap();
        let sessions =
            [1, 2].map(|seed| (seed, vulkan.upload_within(&rig, options, vulkan.context.limits).unwrap()));
        drop(vulkan);
        std::thread::scope(|scope| {
            for (seed, mut session) in sessions {
                let rig = &rig;
                scope.spawn(move || {
                    for round in 0..10 {
                        let positions = take(rig, 1 + round % 5, 100 * seed + round as u64);
                        let expected = on_cpu(rig, options, &positions);
                        assert_close(&evaluate(&mut session, rig, &positions), &expected);
                    }
                });
            }
        });
        assert_eq!(messages.all(), [""; 0]);
    }
}

#[test]
fn a_buffer_larger_than_the_memory_is_refused() {
    for device in devices() {
        let vulkan = Vulkan::open_with(&device, false).unwrap();
        let bytes = 2 * vulkan.context.info.memory_bytes.unwrap();
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let refused = Buffer::new(&vulkan.context, "everything", bytes, usage, MemoryLocation::GpuOnly);
        let Err(Error::Device { kind, message, .. }) = refused else { panic!("it was not refused") };
        assert_eq!(kind, DeviceErrorKind::OutOfMemory);
        assert!(message.contains("everything"), "{message}");
    }
}

#[test]
fn more_than_the_memory_is_refused() {
    let rig = rig(SMALL);
    for device in devices() {
        let Some(vulkan) = validated(&device) else { continue };
        let memory = vulkan.context.info.memory_bytes.unwrap();
        let frame_bytes = 5 * 12 * rig.vertices() as u64;
        let max_frames = (memory / frame_bytes) as usize + 1;
        let refused = vulkan.upload_within(&rig, UploadOptions::frames(max_frames), vulkan.context.limits);
        let Err(Error::Device { kind, message, .. }) = refused else { panic!("it was not refused") };
        assert_eq!(kind, DeviceErrorKind::OutOfMemory);
        assert!(message.contains(&memory.to_string()), "{message}");
    }
}

#[test]
fn sessions_share_the_memory() {
    let rig = rig(SMALL);
    let options = UploadOptions::frames(2);
    for device in devices() {
        let mut vulkan = Vulkan::open_with(&device, false).unwrap();
        let limits = vulkan.context.limits;
        let needed = Plan::new(&rig, options, limits, "").unwrap().bytes();
        Arc::get_mut(&mut vulkan.context).unwrap().info.memory_bytes = Some(2 * needed);
        let first = vulkan.upload_within(&rig, options, limits).unwrap();
        let refused = vulkan.upload_within(&rig, options, limits);
        assert!(matches!(refused, Err(Error::Device { kind: DeviceErrorKind::OutOfMemory, .. })));
        drop(first);
        vulkan.upload_within(&rig, options, limits).unwrap();
    }
}
