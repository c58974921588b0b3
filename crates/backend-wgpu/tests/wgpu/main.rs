//! The wgpu backend on every device of wgpu's. (That sessions give back their memory is tested in `tests/leaks.rs`.)

mod agreement;
mod host_device;
#[path = "../support/mod.rs"]
mod support;
