//! Khronos' validation layer. It is turned on by request, and its messages are remembered.
use crate::error::error;
use ash::{ext, vk};
use rhytid_core::{DeviceErrorKind, Result};
use std::borrow::Cow;
use std::ffi::{CStr, c_void};
use std::sync::{Mutex, PoisonError};

pub(crate) const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";
pub(crate) const EXTENSIONS: [&CStr; 2] = [ext::debug_utils::NAME, ext::validation_features::NAME];
/// Checks in addition to the layer's default ones.
pub(crate) const FEATURES: [vk::ValidationFeatureEnableEXT; 1] =
    [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];

/// Whether the user asks for validation.
pub(crate) fn requested() -> bool {
    std::env::var_os("RHYTID_VULKAN_VALIDATION").is_some_and(|value| value == "1")
}

/// The layer's messages about an instance and everything that was made from it.
#[derive(Debug, Default)]
pub(crate) struct Messages(Mutex<Vec<String>>);

impl Messages {
    /// All messages so far.
    pub(crate) fn all(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Fails if there is any message. The failure is permanent, since later results cannot be trusted.
    pub(crate) fn check(&self, device: &str) -> Result<()> {
        let messages = self.all();
        if messages.is_empty() {
            return Ok(());
        }
        let message = format!("the Vulkan validation layer says: {}", messages.join("; "));
        Err(error(DeviceErrorKind::Driver, device, message))
    }

    /// The setup of a messenger that stores the layer's warnings and errors here. This value must outlive the
    /// messenger.
    pub(crate) fn messenger(&self) -> vk::DebugUtilsMessengerCreateInfoEXT<'_> {
        use vk::{DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Type};
        vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(Severity::WARNING | Severity::ERROR)
            // Hints about performance and the loader's messages about other drivers are left out.
            .message_type(Type::VALIDATION)
            .pfn_user_callback(Some(remember))
            .user_data(std::ptr::from_ref(self).cast_mut().cast())
    }
}

unsafe extern "system" fn remember(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    messages: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: `Messages::messenger` made this pointer, and the messages outlive the messenger.
    let messages = unsafe { &*messages.cast::<Messages>() };
    // SAFETY: for the time of this call, the layer gives a valid structure with a null-terminated message.
    let text = unsafe { (*data).message_as_c_str() }.map_or(Cow::Borrowed(""), CStr::to_string_lossy);
    log::error!("Vulkan validation: {text}");
    messages.0.lock().unwrap_or_else(PoisonError::into_inner).push(text.into_owned());
    vk::FALSE
}
