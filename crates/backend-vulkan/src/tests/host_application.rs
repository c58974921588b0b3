//! A small renderer. It has its own device, waits for the results with a semaphore, and copies them itself.
use super::support::{SMALL, assert_close, devices, on_cpu, read, rig, take, validated};
use crate::instance::Instance;
use crate::physical::{Physical, physical_devices};
use crate::{HostDevice, Vulkan, VulkanSession};
use ash::vk;
use rhytid_core::plan::PlanLimits;
use rhytid_core::{Backend, DeviceErrorKind, Error, HandleFrames, Stage, UploadOptions};
use std::sync::{Arc, Mutex};

/// The objects of the renderer.
struct Renderer {
    device: ash::Device,
    queue: Arc<Mutex<vk::Queue>>,
    pool: vk::CommandPool,
    memory: vk::DeviceMemory,
    buffer: vk::Buffer,
    /// Signalled when Rhytid's results are complete.
    evaluated: vk::Semaphore,
    /// Signalled when the renderer is done with them.
    copied: vk::Semaphore,
}

impl Renderer {
    fn new(instance: &Instance, physical: &Physical, bytes: u64) -> Self {
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(physical.queue_family)
            .queue_priorities(&[1.0])];
        let create = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
        let create_pool = vk::CommandPoolCreateInfo::default().queue_family_index(physical.queue_family);
        let create_buffer =
            vk::BufferCreateInfo::default().size(bytes).usage(vk::BufferUsageFlags::TRANSFER_DST);
        let create_semaphore = vk::SemaphoreCreateInfo::default();
        let wanted = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        // SAFETY: plain Vulkan; the validation layer watches.
        unsafe {
            let device = instance.raw.create_device(physical.raw, &create, None).unwrap();
            let buffer = device.create_buffer(&create_buffer, None).unwrap();
            let requirements = device.get_buffer_memory_requirements(buffer);
            let types = instance.raw.get_physical_device_memory_properties(physical.raw);
            let memory_type = types.memory_types_as_slice().iter().enumerate().position(|(i, memory)| {
                requirements.memory_type_bits & (1 << i) != 0 && memory.property_flags.contains(wanted)
            });
            let allocate = vk::MemoryAllocateInfo::default()
                .allocation_size(requirements.size)
                .memory_type_index(memory_type.unwrap() as u32);
            let memory = device.allocate_memory(&allocate, None).unwrap();
            device.bind_buffer_memory(buffer, memory, 0).unwrap();
            Self {
                queue: Arc::new(Mutex::new(device.get_device_queue(physical.queue_family, 0))),
                pool: device.create_command_pool(&create_pool, None).unwrap(),
                evaluated: device.create_semaphore(&create_semaphore, None).unwrap(),
                copied: device.create_semaphore(&create_semaphore, None).unwrap(),
                device,
                memory,
                buffer,
            }
        }
    }

    fn lend(&self, instance: &Instance, physical: &Physical) -> HostDevice {
        HostDevice {
            instance: instance.raw.clone(),
            physical_device: physical.raw,
            device: self.device.clone(),
            queue: self.queue.clone(),
            queue_family: physical.queue_family,
        }
    }

    /// Submits a copy of the session's positions to `at`, after `evaluated` and before `copied`. Does not
    /// wait.
    fn copy_positions(&self, session: &VulkanSession, frame_bytes: u64, at: u64) {
        let allocate =
            vk::CommandBufferAllocateInfo::default().command_pool(self.pool).command_buffer_count(1);
        // SAFETY: plain Vulkan; the validation layer watches.
        unsafe {
            let commands = self.device.allocate_command_buffers(&allocate).unwrap();
            self.device.begin_command_buffer(commands[0], &vk::CommandBufferBeginInfo::default()).unwrap();
            for slice in session.result(Stage::Positions) {
                let region = vk::BufferCopy {
                    src_offset: 0,
                    dst_offset: at + slice.first_frame as u64 * frame_bytes,
                    size: slice.frames as u64 * frame_bytes,
                };
                self.device.cmd_copy_buffer(commands[0], slice.buffer, self.buffer, &[region]);
            }
            self.device.end_command_buffer(commands[0]).unwrap();
            let (wait, signal) = ([self.evaluated], [self.copied]);
            let submit = vk::SubmitInfo::default()
                .command_buffers(&commands)
                .wait_semaphores(&wait)
                .wait_dst_stage_mask(&[vk::PipelineStageFlags::TRANSFER])
                .signal_semaphores(&signal);
            self.device.queue_submit(*self.queue.lock().unwrap(), &[submit], vk::Fence::null()).unwrap();
        }
    }

    fn copied_positions(&self, numbers: usize) -> Vec<f32> {
        // SAFETY: the device is idle, and the buffer is larger than this.
        unsafe {
            self.device.device_wait_idle().unwrap();
            let mapped =
                self.device.map_memory(self.memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty()).unwrap();
            let copied = std::slice::from_raw_parts(mapped.cast::<f32>(), numbers).to_vec();
            self.device.unmap_memory(self.memory);
            copied
        }
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        // SAFETY: tests are done with the device.
        unsafe {
            self.device.device_wait_idle().unwrap();
            self.device.destroy_semaphore(self.evaluated, None);
            self.device.destroy_semaphore(self.copied, None);
            self.device.destroy_buffer(self.buffer, None);
            self.device.free_memory(self.memory, None);
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_device(None);
        }
    }
}

#[test]
fn a_renderer_takes_the_results_without_the_host() {
    let rig = rig(SMALL);
    let frames = 3;
    let options = UploadOptions::frames(frames);
    let batches = [take(&rig, frames, 1), take(&rig, frames, 2)];
    let frame_numbers = 3 * rig.vertices();
    for info in devices() {
        if validated(&info).is_none() {
            continue;
        }
        let instance = Instance::new(true).unwrap().unwrap();
        let messages = instance.messages.clone().unwrap();
        let physical = &physical_devices(&instance.raw).unwrap()[info.index];
        let renderer = Renderer::new(&instance, physical, (8 * frames * frame_numbers) as u64);
        // SAFETY: the renderer outlives it, and locks the queue.
        let vulkan = unsafe { Vulkan::from_device(renderer.lend(&instance, physical)) }.unwrap();
        assert_eq!(*vulkan.info(), info);
        // With this limit, a slice has one frame.
        let limits = PlanLimits { max_binding_bytes: 8448, ..vulkan.context.limits };
        let mut session = vulkan.upload_within(&rig, options, limits).unwrap();
        drop(vulkan);
        let frame_bytes = 4 * frame_numbers as u64;
        for (i, positions) in batches.iter().enumerate() {
            let wait: &[vk::Semaphore] = if i == 0 { &[] } else { &[renderer.copied] };
            let batch = HandleFrames { positions, frames };
            // SAFETY: both semaphores are waited for once for each signal.
            unsafe { session.evaluate_with(batch, wait, &[renderer.evaluated]) }.unwrap();
            assert_eq!(session.result(Stage::Positions).len(), frames);
            renderer.copy_positions(&session, frame_bytes, (i * frames) as u64 * frame_bytes);
        }
        let copied = renderer.copied_positions(2 * frames * frame_numbers);
        let (first, second) = copied.split_at(frames * frame_numbers);
        let expected = |positions| on_cpu(&rig, options, positions)[4].clone();
        assert_close(&[first.to_vec()], &[expected(&batches[0])]);
        assert_close(&[second.to_vec()], &[expected(&batches[1])]);
        assert_eq!(second, read(&mut session, Stage::Positions));
        drop(session);
        // The device still belongs to the renderer. When it is destroyed, no object of Rhytid is left on it.
        drop(renderer);
        drop(instance);
        assert_eq!(messages.all(), [""; 0]);
    }
}

#[test]
fn a_device_of_another_instance_is_refused() {
    for info in devices() {
        let instance = Instance::new(false).unwrap().unwrap();
        let physical = &physical_devices(&instance.raw).unwrap()[info.index];
        let renderer = Renderer::new(&instance, physical, 16);
        let mut host = renderer.lend(&instance, physical);
        host.physical_device = vk::PhysicalDevice::null();
        // SAFETY: a device that does not belong to the instance is detected before it is used.
        let Err(refused) = (unsafe { Vulkan::from_device(host) }) else { panic!("it was accepted") };
        assert!(matches!(&refused, Error::Device { kind: DeviceErrorKind::NotFound, device, .. }
            if device == Vulkan::NAME));
    }
}
