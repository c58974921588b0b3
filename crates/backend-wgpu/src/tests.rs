//! Tests of internals: lowered limits, and the handling of errors.
#[allow(dead_code, reason = "not every test uses all of it")]
#[path = "../tests/support/mod.rs"]
mod support;

use crate::faults::{Pending, error_of, scoped};
use crate::{Wgpu, WgpuSession};
use rhytid_core::plan::PlanLimits;
use rhytid_core::{
    Animator, Backend, BasisStorage, DeviceErrorKind, DeviceInfo, Error, HandleFrames, Result, Session,
    Stage, UploadOptions,
};
use support::{Sizes, agree, expected, frames, rig, tested};

const SIZES: Sizes = Sizes { vertices: 1025, handles: 89, edges: 243, examples: 6, influences: 16 };

fn devices() -> Vec<Wgpu> {
    tested(Wgpu::devices().unwrap()).iter().map(|info| Wgpu::open(info).unwrap()).collect()
}

fn kind<T>(result: Result<T>) -> DeviceErrorKind {
    match result {
        Err(Error::Device { kind, device, message }) => {
            eprintln!("{device}: {message}");
            assert!(device.starts_with("wgpu") && !message.contains('\n'), "{device}: {message}");
            kind
        }
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("there was no error"),
    }
}

#[test]
fn rigs_and_batches_are_split_where_limits_are_low() {
    let rig = rig(1, SIZES);
    for (limits, basis) in [
        (PlanLimits { max_binding_bytes: 64 << 10, max_workgroups: 65_535 }, BasisStorage::F32),
        (PlanLimits { max_binding_bytes: 64 << 10, max_workgroups: 65_535 }, BasisStorage::F16),
        (PlanLimits { max_binding_bytes: 128 << 20, max_workgroups: 4 }, BasisStorage::F32),
    ] {
        for wgpu in devices() {
            let options = UploadOptions { max_frames: 13, basis };
            let mut session = WgpuSession::new(wgpu.gpu.clone(), &rig, options, limits).unwrap();
            for batch in [13, 1, 6] {
                let positions = frames(batch as u64, &rig, batch);
                session.evaluate(HandleFrames { positions: &positions, frames: batch }).unwrap();
                let found = Stage::ALL.map(|stage| {
                    let mut out = Vec::new();
                    session.read(stage, &mut out).unwrap();
                    out
                });
                let context = format!("{}, {limits:?}, {batch} frames", wgpu.gpu.id);
                agree(&found, &expected(&rig, &positions, basis), &context);

                let slices: Vec<_> = session.results(Stage::Normals).map(|(frames, _)| frames).collect();
                assert_eq!(slices.len() > 1, batch > 5, "{context}: {slices:?}");
                let all: Vec<usize> = slices.into_iter().flatten().collect();
                assert_eq!(all, (0..batch).collect::<Vec<_>>(), "{context}");
            }
            if let Some(times) = session.stage_times().unwrap() {
                assert!(times.iter().all(|time| !time.is_zero()), "{}: {times:?}", wgpu.gpu.id);
            }
        }
    }
}

#[test]
fn a_device_says_what_it_is_and_splits_further_where_it_is_told_to() {
    let rig = rig(1, SIZES);
    for info in tested(Wgpu::devices().unwrap()) {
        let wgpu = Wgpu::open(&info).unwrap();
        assert_eq!(DeviceInfo { index: info.index, ..wgpu.info() }, info);
        let low = wgpu.clone().with_bindings_of_at_most(64 << 10);
        assert_eq!(low.info().max_binding_bytes, Some(64 << 10));
        let slices = |wgpu: &Wgpu| {
            let mut animator = Animator::new(wgpu, &rig, UploadOptions::frames(13)).unwrap();
            animator.evaluate(&frames(13, &rig, 13)).unwrap();
            animator.session().results(Stage::Positions).count()
        };
        assert!(slices(&wgpu) == 1 && slices(&low) > 1, "{}", info.id());
        assert_eq!(low.with_bindings_of_at_most(u64::MAX).info().max_binding_bytes, Some(64 << 10));
    }
}

#[test]
fn a_device_that_is_lost_is_an_error() {
    let rig = rig(2, SIZES);
    let positions = frames(0, &rig, 1);
    for wgpu in devices() {
        let mut animator = Animator::new(&wgpu, &rig, UploadOptions::frames(1)).unwrap();
        animator.evaluate(&positions).unwrap();
        wgpu.device().destroy();
        let mut out = Vec::new();
        assert_eq!(kind(animator.read(Stage::Normals, &mut out)), DeviceErrorKind::Lost);
        assert_eq!(kind(animator.evaluate(&positions)), DeviceErrorKind::Lost);
        assert_eq!(kind(wgpu.upload(&rig, UploadOptions::frames(1))), DeviceErrorKind::Lost);
    }
}

#[test]
fn a_device_that_its_host_destroys_is_an_error_too() {
    let rig = rig(3, SIZES);
    let positions = frames(0, &rig, 1);
    for own in devices() {
        let wgpu = Wgpu::from_device(own.device().clone(), own.queue().clone()).unwrap();
        let mut animator = Animator::new(&wgpu, &rig, UploadOptions::frames(1)).unwrap();
        animator.evaluate(&positions).unwrap();
        wgpu.device().destroy();
        assert_eq!(kind(animator.read(Stage::Normals, &mut Vec::new())), DeviceErrorKind::Lost);
    }
}

#[test]
fn an_error_that_nobody_caught_is_reported_once() {
    let rig = rig(4, SIZES);
    let positions = frames(0, &rig, 1);
    for wgpu in devices() {
        let mut animator = Animator::new(&wgpu, &rig, UploadOptions::frames(1)).unwrap();
        // By default wgpu would panic here.
        too_large(wgpu.device());
        assert_eq!(kind(animator.evaluate(&positions)), DeviceErrorKind::Driver);
        animator.evaluate(&positions).unwrap();
    }
}

#[test]
fn errors_within_a_scope_are_known_at_once_and_say_what_was_refused() {
    for wgpu in devices() {
        let mut pending = Pending::default();
        scoped(wgpu.device(), &mut pending, || ());
        assert!(pending.known().is_none());
        scoped(wgpu.device(), &mut pending, || too_large(wgpu.device()));
        let result = wgpu.gpu.check(pending.known(), "uploading basis");
        let message = result.as_ref().unwrap_err().to_string();
        assert!(
            message.contains("uploading basis was refused") && message.contains("maximum buffer size"),
            "{message}"
        );
        assert_eq!(kind(result), DeviceErrorKind::Driver);
        assert!(pending.known().is_none());
    }
}

#[test]
fn out_of_memory_is_told_from_other_errors() {
    let fault = wgpu::Error::OutOfMemory { source: "Not enough memory left".into() };
    let error = error_of(&fault, "wgpu:0", "uploading basis");
    assert!(
        error.to_string().starts_with("wgpu:0: out of memory while uploading basis (Not enough memory left)")
    );
    assert_eq!(kind::<()>(Err(error)), DeviceErrorKind::OutOfMemory);
}

/// Breaks a limit.
fn too_large(device: &wgpu::Device) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 1 << 40,
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    })
}
