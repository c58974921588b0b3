//! The wgpu backend on every device of wgpu. (`tests/leaks.rs` tests that sessions release their memory.)

mod agreement;
mod host_device;
#[path = "../support/mod.rs"]
mod support;
