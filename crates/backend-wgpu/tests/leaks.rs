//! Sessions release their memory. (The test has a process of its own, since the memory of the whole process
//! is measured.)
#![cfg(target_os = "linux")]
#[allow(dead_code, reason = "not every test uses all of it")]
mod support;

use rhytid_backend_wgpu::Wgpu;
use rhytid_core::{Animator, Backend, Stage, UploadOptions};
use rhytid_test_support::resident;
use support::{Sizes, frames, rig, tested};

#[test]
fn two_hundred_uploads_and_drops_leave_memory_as_it_was() {
    let rig = rig(1, Sizes { vertices: 5_000, handles: 60, edges: 100, examples: 6, influences: 16 });
    // Sessions have room for eight frames and evaluate one. The memory is the same, in an eighth of the time.
    let positions = frames(0, &rig, 1);
    for info in tested(Wgpu::devices().unwrap()) {
        let wgpu = Wgpu::open(&info).unwrap();
        let uploads = |count: usize| {
            for _ in 0..count {
                let mut animator = Animator::new(&wgpu, &rig, UploadOptions::frames(8)).unwrap();
                animator.evaluate(&positions).unwrap();
                animator.read(Stage::Normals, &mut Vec::new()).unwrap();
            }
            resident()
        };
        let before = uploads(50);
        let after = uploads(200);
        // One session has above 4 MB, so a leak of all is 800 MB. A leak of the smallest buffer of each, 60
        // kB, is 12 MB.
        assert!(after < before + (10 << 20), "{}: from {before} to {after} bytes", info.id());
        eprintln!("{}: from {before} to {after} bytes", info.id());
    }
}
