//! Uploads leave the memory of the process unchanged.
use super::support::{devices, frames, is_child_for, output_of_success, rig, run_child};
use crate::OpenCl;
use rhytid_core::{Animator, Backend, Stage, UploadOptions};

const TEST: &str = "tests::memory::uploads_and_drops_keep_memory_flat";

/// The test runs in a process of its own, whose memory no other test changes.
#[test]
fn uploads_and_drops_keep_memory_flat() {
    if !cfg!(target_os = "linux") {
        rhytid_test_support::skip("memory is measured on Linux alone");
        return;
    }
    if !is_child_for(TEST) {
        println!("{}", output_of_success(&run_child(TEST, &[], &[])));
        return;
    }
    let rig = rig([2000, 20, 30, 6, 16]);
    let positions = frames(&rig, 4, 0);
    for info in devices() {
        let device = OpenCl::open(&info).unwrap();
        let mut result = Vec::new();
        let mut use_and_drop = |count: usize| {
            for i in 0..count {
                let mut session = Animator::new(&device, &rig, UploadOptions::frames(4)).unwrap();
                session.evaluate(&positions).unwrap();
                // Some batches are never waited for.
                if i % 2 == 0 {
                    session.read(Stage::Normals, &mut result).unwrap();
                    session.stage_times().unwrap();
                }
            }
            rhytid_test_support::resident() / 1024
        };
        let before = use_and_drop(100);
        let after = use_and_drop(300);
        println!("{}: {before} kB, then {after} kB", info.id());
        // Each session has 1.5 MB in buffers, and 6 kernels.
        assert!(after < before + 1000, "{}: from {before} kB to {after} kB", info.id());
    }
}
