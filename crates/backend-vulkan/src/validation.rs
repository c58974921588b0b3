//! Khronos' validation layer: turned on by request, and its messages are remembered.
use crate::error::error;
use ash::{ext, vk};
use rhytid_core::{DeviceErrorKind, Result};
use std::borrow::Cow;
use std::ffi::{CStr, c_void};
use std::sync::{Mutex, PoisonError};

pub(crate) const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";
pub(crate) const EXTENSIONS: [&CStr; 2] = [ext::debug_utils::NAME, ext::validation_features::NAME];
/// On top of what the layer checks by itself.
pub(crate) const FEATURES: [vk::ValidationFeatureEnableEXT; 1] =
    [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];

/// Whether the user asks for validation.
pub(crate) fn requested() -> bool {
    std::env::var_os("RHYTID_VULKAN_VALIDATION").is_some_and(|value| value == "1")
}

/// What the layer said of an instance and all that was made from it.
#[derive(Debug, Default)]
pub(crate) struct Messages(Mutex<Vec<String>>);

impl Messages {
    /// All messages so far.
    pub(crate) fn all(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// A message is a failure, and remains one: what was evaluated since cannot be trusted.
    pub(crate) fn check(&self, device: &str) -> Result<()> {
        let messages = self.all();
        if messages.is_empty() {
            return Ok(());
        }
        let message = format!("the Vulkan validation layer says: {}", messages.join("; "));
        Err(error(DeviceErrorKind::Driver, device, message))
    }

    /// Has the layer's warnings and errors remembered here, which must outlive the messenger.
    pub(crate) fn messenger(&self) -> vk::DebugUtilsMessengerCreateInfoEXT<'_> {
        use vk::{DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Type};
        vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(Severity::WARNING | Severity::ERROR)
            // Hints about performance are not asked for, nor what the loader says of other drivers.
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
    // SAFETY: `Messages::messenger` made this pointer, and what it points to outlives the messenger.
    let messages = unsafe { &*messages.cast::<Messages>() };
    // SAFETY: the layer gives a valid structure with a null-terminated message, for the time of this call.
    let text = unsafe { (*data).message_as_c_str() }.map_or(Cow::Borrowed(""), CStr::to_string_lossy);
    log::error!("Vulkan validation: {text}");
    messages.0.lock().unwrap_or_else(PoisonError::into_inner).push(text.into_owned());
    vk::FALSE
}
