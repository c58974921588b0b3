//! The Vulkan loader and an instance.
use crate::error::{error, failed};
use crate::validation::{self, Messages};
use ash::{ext, khr, vk};
use rhytid_core::{DeviceErrorKind, Result};
use std::ffi::CStr;
use std::sync::Arc;

/// Errors before a device is reached name the backend.
const BACKEND: &str = "vulkan";

pub(crate) struct Instance {
    pub(crate) raw: ash::Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    /// `None` where validation was not asked for.
    pub(crate) messages: Option<Arc<Messages>>,
    /// The loader's library, which stays loaded as long as this value exists.
    _entry: ash::Entry,
}

impl Instance {
    /// `None` where there is no loader, no driver, or only Vulkan 1.0.
    ///
    /// # Errors
    /// `Unsupported` if validation is requested and the layer is not installed. Errors of the driver.
    pub(crate) fn new(validation: bool) -> Result<Option<Self>> {
        // SAFETY: the system's Vulkan loader is trusted to do nothing strange when it is loaded.
        let entry = match unsafe { ash::Entry::load() } {
            Ok(entry) => entry,
            Err(cause) => {
                log::debug!("there is no Vulkan loader: {cause}");
                return Ok(None);
            }
        };
        // SAFETY: `entry` is a loaded loader.
        let version = unsafe { entry.try_enumerate_instance_version() };
        if version.map_err(failed(BACKEND, "asking for Vulkan's version"))?.is_none() {
            log::warn!(
                "the Vulkan loader knows Vulkan 1.0 only, and 1.1 is needed: its devices are left out"
            );
            return Ok(None);
        }

        let mut extensions = Vec::new();
        let mut layers = Vec::new();
        let mut flags = vk::InstanceCreateFlags::empty();
        // Drivers on top of another API of the system (MoltenVK) are listed only if they are requested.
        if has_extension(&entry, khr::portability_enumeration::NAME)? {
            extensions.push(khr::portability_enumeration::NAME.as_ptr());
            flags |= vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR;
        }
        if validation {
            require_layer(&entry)?;
            layers.push(validation::LAYER.as_ptr());
            extensions.extend(validation::EXTENSIONS.map(CStr::as_ptr));
        }
        let application = vk::ApplicationInfo::default()
            .engine_name(c"rhytid")
            // The newest version that this backend may use if a device has it.
            .api_version(vk::API_VERSION_1_3);
        let mut create = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_extension_names(&extensions)
            .enabled_layer_names(&layers)
            .flags(flags);
        let messages = validation.then(Arc::<Messages>::default);
        let mut features =
            vk::ValidationFeaturesEXT::default().enabled_validation_features(&validation::FEATURES);
        let mut messenger = messages.as_ref().map(|messages| messages.messenger());
        if let Some(messenger) = &mut messenger {
            create = create.push_next(&mut features).push_next(messenger);
        }

        // SAFETY: all that `create` points to is alive; layers and extensions are present.
        let raw = match unsafe { entry.create_instance(&create, None) } {
            Ok(raw) => raw,
            Err(vk::Result::ERROR_INCOMPATIBLE_DRIVER) => {
                log::debug!("there is no Vulkan driver");
                return Ok(None);
            }
            Err(result) => return Err(failed(BACKEND, "making an instance")(result)),
        };
        let mut instance = Self { raw, messenger: None, messages, _entry: entry };
        if let Some(messages) = &instance.messages {
            let debug_utils = ext::debug_utils::Instance::new(&instance._entry, &instance.raw);
            // SAFETY: the extension is enabled, and the messages outlive the messenger.
            let raw = unsafe { debug_utils.create_debug_utils_messenger(&messages.messenger(), None) };
            let raw = raw.map_err(failed(BACKEND, "listening to the validation layer"))?;
            instance.messenger = Some((debug_utils, raw));
        }
        Ok(Some(instance))
    }

    /// Whether the validation layer is silent.
    pub(crate) fn check(&self) -> Result<()> {
        self.messages.as_ref().map_or(Ok(()), |messages| messages.check(BACKEND))
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: both were made by `new`. Users of the instance keep this value alive. The destruction may
        // add messages, and these are dropped after it.
        unsafe {
            if let Some((debug_utils, messenger)) = self.messenger.take() {
                debug_utils.destroy_debug_utils_messenger(messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

fn has_extension(entry: &ash::Entry, name: &CStr) -> Result<bool> {
    // SAFETY: `entry` is a loaded loader.
    let found = unsafe { entry.enumerate_instance_extension_properties(None) };
    let found = found.map_err(failed(BACKEND, "listing the instance's extensions"))?;
    Ok(found.iter().any(|extension| extension.extension_name_as_c_str() == Ok(name)))
}

fn require_layer(entry: &ash::Entry) -> Result<()> {
    // SAFETY: `entry` is a loaded loader.
    let found = unsafe { entry.enumerate_instance_layer_properties() };
    let found = found.map_err(failed(BACKEND, "listing the instance's layers"))?;
    if found.iter().any(|layer| layer.layer_name_as_c_str() == Ok(validation::LAYER)) {
        return Ok(());
    }
    let message = "validation is asked for, but VK_LAYER_KHRONOS_validation is not installed: install the Vulkan \
                   validation layers, or unset RHYTID_VULKAN_VALIDATION";
    Err(error(DeviceErrorKind::Unsupported, BACKEND, message.into()))
}
