//! Pictures on every device of this machine.

mod limits;
mod looks;
mod posed;
mod skin;

use rhytid_backend_wgpu::Wgpu;
use rhytid_core::Backend;

/// Runs `test` on each device of this machine, with its name for messages of failures.
fn each_device(test: impl Fn(&str, &Wgpu)) {
    let devices = Wgpu::devices().unwrap();
    assert!(!devices.is_empty(), "there is no device of wgpu's here");
    for info in devices {
        test(&format!("{} {}", info.name, info.driver), &Wgpu::open(&info).unwrap());
    }
}
