//! Tests on the Vulkan devices of this machine.
mod host_application;
mod memory;
mod results;
mod support;
mod synchronization;
