//! Agreement of every device with the CPU backend.
use super::support::{assert_agreement, devices, frames, on_cpu, rig};
use crate::OpenCl;
use rhytid_core::plan::{Plan, PlanLimits};
use rhytid_core::{Animator, Backend, BasisStorage, DeviceInfo, DeviceKind, Stage, UploadOptions};
use std::time::Instant;

/// V, H, F, P, K. V is around the workgroup's 64. Some have no edges, no examples, or one of each.
const SIZES: [[usize; 5]; 7] = [
    [1, 1, 0, 0, 0],
    [2, 2, 1, 1, 1],
    [63, 5, 0, 2, 0],
    [64, 8, 20, 0, 4],
    [65, 9, 63, 6, 16],
    [129, 65, 65, 40, 16],
    [1000, 89, 243, 6, 16],
];

const F16: UploadOptions = UploadOptions { max_frames: 31, basis: BasisStorage::F16 };

/// Every device, both as a processor and as a GPU. Kernels for processors must be right on GPUs, and the
/// reverse.
fn as_both_classes() -> Vec<DeviceInfo> {
    let as_kind = |kind| devices().into_iter().map(move |info| DeviceInfo { kind, ..info });
    [DeviceKind::Cpu, DeviceKind::DiscreteGpu].into_iter().flat_map(as_kind).collect()
}

#[test]
fn every_stage_agrees_with_the_cpu() {
    for info in as_both_classes() {
        let device = OpenCl::open(&info).unwrap();
        for sizes in SIZES {
            let rig = rig(sizes);
            for options in [UploadOptions::frames(31), F16] {
                let mut cpu = on_cpu(&rig, options);
                let mut session = Animator::new(&device, &rig, options).unwrap();
                for (seed, count) in [31, 1, 2, 31].into_iter().enumerate() {
                    let positions = frames(&rig, count, seed as u64);
                    cpu.evaluate(&positions).unwrap();
                    session.evaluate(&positions).unwrap();
                    let what = format!(
                        "{}, {:?}, {sizes:?}, {:?}, {count} frames",
                        info.id(),
                        info.kind,
                        options.basis
                    );
                    assert_agreement(&mut session, &mut cpu, &what);
                }
            }
        }
    }
}

#[test]
fn parts_and_slices_agree_with_the_cpu() {
    let rig = rig([300, 20, 30, 6, 16]);
    let limits = PlanLimits { max_binding_bytes: 11_000, max_workgroups: u32::MAX };
    for options in [UploadOptions::frames(31), F16] {
        let plan = Plan::new(&rig, options, limits, "opencl").unwrap();
        let parts = plan.dispatches(1).iter().filter(|dispatch| dispatch.stage == Stage::Normals).count();
        assert!(parts > 1 && plan.slices(31).count() > 1, "{parts} parts");
    }
    for info in as_both_classes() {
        let mut device = OpenCl::open(&info).unwrap();
        device.limits = limits;
        for options in [UploadOptions::frames(31), F16] {
            let mut cpu = on_cpu(&rig, options);
            let mut session = Animator::new(&device, &rig, options).unwrap();
            for count in [31, 1, 4, 30] {
                let positions = frames(&rig, count, count as u64);
                cpu.evaluate(&positions).unwrap();
                session.evaluate(&positions).unwrap();
                assert_agreement(&mut session, &mut cpu, &format!("{}, {count} frames", info.id()));
            }
        }
    }
}

/// A kernel's buffers are `restrict`, so no buffer may be bound twice.
#[test]
fn no_buffer_is_bound_twice_at_once() {
    let limits = PlanLimits { max_binding_bytes: 11_000, max_workgroups: u32::MAX };
    let plan = Plan::new(&rig([300, 20, 30, 6, 16]), UploadOptions::frames(31), limits, "opencl").unwrap();
    for dispatch in plan.dispatches(31) {
        let mut buffers = dispatch.buffers.clone();
        buffers.sort_unstable();
        buffers.dedup();
        assert_eq!(buffers.len(), dispatch.buffers.len(), "{}", dispatch.kernel.name());
    }
}

#[test]
fn sessions_on_several_threads_do_not_disturb_each_other() {
    for info in devices() {
        let device = OpenCl::open(&info).unwrap();
        std::thread::scope(|scope| {
            for thread in 0..4u64 {
                let device = &device;
                scope.spawn(move || {
                    let rig = rig([500 + thread as usize, 20, 30, 6, 16]);
                    let mut cpu = on_cpu(&rig, UploadOptions::frames(3));
                    for round in 0..5 {
                        let mut session = Animator::new(device, &rig, UploadOptions::frames(3)).unwrap();
                        for count in [3, 1, 2] {
                            let positions = frames(&rig, count, 100 * thread + round);
                            cpu.evaluate(&positions).unwrap();
                            session.evaluate(&positions).unwrap();
                            assert_agreement(&mut session, &mut cpu, &format!("thread {thread}"));
                        }
                    }
                });
            }
        });
    }
}

#[test]
fn the_last_batch_counts_and_the_caller_keeps_its_memory() {
    let rig = rig([700, 20, 30, 6, 16]);
    for info in devices() {
        let mut session = {
            let device = OpenCl::open(&info).unwrap();
            Animator::new(&device, &rig, UploadOptions::frames(8)).unwrap()
        };
        let mut cpu = on_cpu(&rig, UploadOptions::frames(8));
        for round in 0..10 {
            // Several batches are in flight. The caller's memory is gone before the device reads it.
            for seed in 0..5 {
                session.evaluate(&frames(&rig, 8 - seed, 10 * round + seed as u64)).unwrap();
            }
            cpu.evaluate(&frames(&rig, 4, 10 * round + 4)).unwrap();
            assert_agreement(&mut session, &mut cpu, &info.id());
        }
        session.evaluate(&frames(&rig, 8, 0)).unwrap();
    }
}

#[test]
fn stage_times_are_the_devices_own() {
    let rig = rig([20_000, 89, 243, 6, 16]);
    for info in devices() {
        let mut session =
            Animator::new(&OpenCl::open(&info).unwrap(), &rig, UploadOptions::frames(4)).unwrap();
        let positions = frames(&rig, 4, 0);
        for _ in 0..3 {
            let start = Instant::now();
            session.evaluate(&positions).unwrap();
            let times = session.stage_times().unwrap().expect("the queue measures");
            let passed = start.elapsed();
            assert!(times.iter().all(|time| !time.is_zero()), "{times:?}");
            assert!(times.iter().sum::<std::time::Duration>() <= passed, "{times:?} in {passed:?}");
        }
    }
}
