//! The results of a device are those of the CPU.
use super::support::{SMALL, Size, assert_close, devices, evaluate, on_cpu, read, rig, take, validated};
use crate::Vulkan;
use crate::context::Clock;
use rhytid_core::plan::PlanLimits;
use rhytid_core::{
    Animator, Backend, BasisStorage, DeviceErrorKind, Error, HandleFrames, Session, Stage, UploadOptions,
};
use std::time::Duration;

#[test]
fn batches_of_any_size() {
    let rig = rig(SMALL);
    let options = UploadOptions::frames(40);
    for device in devices() {
        let vulkan = Vulkan::open(&device).unwrap();
        let mut animator = Animator::new(&vulkan, &rig, options).unwrap();
        for frames in [1, 2, 31, 40, 3] {
            let positions = take(&rig, frames, frames as u64);
            assert_close(
                &evaluate(animator.session_mut(), &rig, &positions),
                &on_cpu(&rig, options, &positions),
            );
        }
    }
}

/// A stage of one buffer has the same numbers in the session's memory. One of several buffers is not lent.
#[test]
fn a_stage_in_the_memory_of_the_session() {
    let rig = rig(SMALL);
    let options = UploadOptions::frames(3);
    let positions = take(&rig, 3, 8);
    for device in devices() {
        let vulkan = Vulkan::open_with(&device, false).unwrap();
        let mut session = vulkan.upload_within(&rig, options, vulkan.context.limits).unwrap();
        session.evaluate(HandleFrames { positions: &positions, frames: 3 }).unwrap();
        for stage in Stage::ALL {
            let lent = session.map(stage).unwrap().expect("one small buffer").to_vec();
            assert_eq!(lent, read(&mut session, stage), "{stage:?}");
        }
        let limits = PlanLimits { max_binding_bytes: 8448, ..vulkan.context.limits };
        let mut session = vulkan.upload_within(&rig, options, limits).unwrap();
        session.evaluate(HandleFrames { positions: &positions, frames: 3 }).unwrap();
        assert_eq!(session.map(Stage::Positions).unwrap(), None);
    }
}

#[test]
fn basis_as_fp16() {
    let rig = rig(SMALL);
    let options = UploadOptions { max_frames: 2, basis: BasisStorage::F16 };
    let positions = take(&rig, 2, 5);
    let expected = on_cpu(&rig, options, &positions);
    let of_floats = on_cpu(&rig, UploadOptions::frames(2), &positions);
    assert_ne!(expected, of_floats);
    for device in devices() {
        let vulkan = Vulkan::open_with(&device, false).unwrap();
        let mut session = vulkan.upload_within(&rig, options, vulkan.context.limits).unwrap();
        assert_close(&evaluate(&mut session, &rig, &positions), &expected);
    }
}

#[test]
fn lower_limits_give_the_same() {
    let rig = rig(SMALL);
    let options = UploadOptions::frames(31);
    for device in devices() {
        let vulkan = Vulkan::open_with(&device, false).unwrap();
        // For 64 vertices, the largest array has 3072 bytes, a frame has 4692 bytes, and the triangles have
        // 8448 bytes.
        for limits in [
            PlanLimits { max_binding_bytes: 8448, max_workgroups: 65535 },
            PlanLimits { max_binding_bytes: 15000, max_workgroups: 2 },
        ] {
            let mut session = vulkan.upload_within(&rig, options, limits).unwrap();
            for frames in [1, 31, 2] {
                let positions = take(&rig, frames, frames as u64);
                assert_close(&evaluate(&mut session, &rig, &positions), &on_cpu(&rig, options, &positions));
                assert_eq!(
                    session.result(Stage::Normals).iter().map(|slice| slice.frames).sum::<usize>(),
                    frames
                );
            }
            assert!(session.stage_times().unwrap().is_some());
            session.evaluate(HandleFrames { positions: &take(&rig, 31, 7), frames: 31 }).unwrap();
            assert!(session.result(Stage::Normals).len() > 10);
            assert!(session.plan.dispatches(1).len() > 15);
        }
    }
}

#[test]
fn rigs_without_edges_and_poses() {
    let rig = rig(Size { edges: 0, poses: 0, influences: 0, handles: 1, ..SMALL });
    let options = UploadOptions::frames(2);
    let positions = take(&rig, 2, 3);
    for device in devices() {
        let Some(vulkan) = validated(&device) else { continue };
        let mut session = vulkan.upload_within(&rig, options, vulkan.context.limits).unwrap();
        assert_close(&evaluate(&mut session, &rig, &positions), &on_cpu(&rig, options, &positions));
        session.stage_times().unwrap();
    }
}

#[test]
fn stage_times_are_of_the_device() {
    let rig = rig(Size { columns: 200, rows: 150, ..SMALL });
    for device in devices() {
        let vulkan = Vulkan::open_with(&device, false).unwrap();
        let mut session =
            vulkan.upload_within(&rig, UploadOptions::frames(8), vulkan.context.limits).unwrap();
        assert_eq!(session.stage_times().unwrap(), Some([Duration::ZERO; 6]));
        let start = std::time::Instant::now();
        evaluate(&mut session, &rig, &take(&rig, 8, 1));
        let wall = start.elapsed();
        let times = session.stage_times().unwrap().unwrap();
        assert!(times[1..].iter().all(|time| *time > Duration::ZERO), "{times:?}");
        assert!(times.iter().sum::<Duration>() <= wall, "{times:?} in {wall:?}");
    }
}

#[test]
fn the_clock_may_start_anew() {
    let clock = Clock { period: 2.5, mask: (1 << 36) - 1 };
    assert_eq!(clock.between(10, 14), Duration::from_nanos(10));
    assert_eq!(clock.between((1 << 36) - 1, 3), Duration::from_nanos(10));
}

#[test]
fn a_batch_of_the_wrong_size_is_refused() {
    let rig = rig(SMALL);
    for device in devices() {
        let vulkan = Vulkan::open_with(&device, false).unwrap();
        let mut session =
            vulkan.upload_within(&rig, UploadOptions::frames(2), vulkan.context.limits).unwrap();
        let positions = take(&rig, 3, 1);
        for (n, frames) in [(3, 3), (0, 0), (3, 2), (1, 2), (3, usize::MAX)] {
            let positions = &positions[..n * 3 * rig.handles().len()];
            let refused = session.evaluate(HandleFrames { positions, frames }).unwrap_err();
            assert!(matches!(refused, Error::Input(_)), "{refused}");
        }
    }
}

#[test]
fn an_absent_device_is_an_error() {
    for device in devices() {
        let mut absent = device.clone();
        absent.index = 99;
        let mut renamed = device.clone();
        renamed.name = "Voodoo".into();
        let mut of_another_backend = device;
        of_another_backend.backend = "opencl";
        for device in [absent, renamed, of_another_backend] {
            let Err(refused) = Vulkan::open_with(&device, false) else { panic!("{device:?} was opened") };
            assert!(matches!(&refused, Error::Device { kind: DeviceErrorKind::NotFound, device: id, .. }
                if *id == device.id()));
        }
    }
}
