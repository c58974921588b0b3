//! A kernel on a device.
use crate::error::{error, failed};
use ash::vk;
use rhytid_core::{DeviceErrorKind, Result};
use rhytid_kernels::table::Kernel;
use std::ffi::CString;
use std::io::Cursor;

/// A kernel's pipeline. Handles are null where it could not be made. Destroying it is sound in any case.
pub(crate) struct Pipeline {
    pub(crate) kernel: Kernel,
    /// The kernel's constant `FRAMES`.
    pub(crate) frames_at_once: u32,
    pub(crate) set_layout: vk::DescriptorSetLayout,
    pub(crate) layout: vk::PipelineLayout,
    pub(crate) raw: vk::Pipeline,
}

impl Pipeline {
    pub(crate) fn new(kernel: Kernel, frames_at_once: u32) -> Self {
        Self {
            kernel,
            frames_at_once,
            set_layout: vk::DescriptorSetLayout::null(),
            layout: vk::PipelineLayout::null(),
            raw: vk::Pipeline::null(),
        }
    }

    /// Makes the objects that `new` left null.
    pub(crate) fn build(&mut self, device: &ash::Device, id: &str, cache: vk::PipelineCache) -> Result<()> {
        let entry = self.kernel.entry();
        let name = entry.name;
        let failed = |what: &'static str| {
            move |result| failed(id, &format!("making the {what} of the kernel {name}"))(result)
        };
        let bindings: Vec<_> = (0..entry.bindings.len() as u32)
            .map(|binding| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(binding)
                    .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            })
            .collect();
        let create = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: here and below, the device and everything that the structures point to are alive.
        let set_layout = unsafe { device.create_descriptor_set_layout(&create, None) };
        self.set_layout = set_layout.map_err(failed("descriptor set layout"))?;

        let params = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
            .size(4 * entry.params.len() as u32)];
        let set_layouts = [self.set_layout];
        let create =
            vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts).push_constant_ranges(&params);
        // SAFETY: as above.
        let layout = unsafe { device.create_pipeline_layout(&create, None) };
        self.layout = layout.map_err(failed("pipeline layout"))?;

        let broken = |cause: String| {
            error(DeviceErrorKind::Build, id, format!("the kernel {name} is not a SPIR-V module: {cause}"))
        };
        let words = ash::util::read_spv(&mut Cursor::new(entry.spirv));
        let words = words.map_err(|cause| broken(cause.to_string()))?;
        let entry_point = CString::new(name).map_err(|cause| broken(cause.to_string()))?;
        let create = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: as above; the words are a valid module, as is shown where they are made.
        let module =
            unsafe { device.create_shader_module(&create, None) }.map_err(failed("shader module"))?;
        let frames = self.frames_at_once.to_ne_bytes();
        let constants = [vk::SpecializationMapEntry::default().constant_id(0).size(frames.len())];
        let constants = vk::SpecializationInfo::default().map_entries(&constants).data(&frames);
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .specialization_info(&constants)
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(&entry_point);
        let create = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(self.layout)];
        // SAFETY: as above; the module has this entry point, and the layout fits to its bindings.
        let pipelines = unsafe { device.create_compute_pipelines(cache, &create, None) };
        // SAFETY: the pipeline, if there is one, does not need its module any more.
        unsafe { device.destroy_shader_module(module, None) };
        self.raw = pipelines.map_err(|(_, result)| failed("pipeline")(result))?[0];
        Ok(())
    }

    /// # Safety
    /// `device` is the one it was built on, and no longer uses it.
    pub(crate) unsafe fn destroy(&self, device: &ash::Device) {
        // SAFETY: the caller guarantees this. Objects that were not made are null, which is ignored.
        unsafe {
            device.destroy_pipeline(self.raw, None);
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}
