//! Every device of wgpu gives the CPU's results, for any batch.

use crate::support::{Sizes, agree, all_stages, expected, frames, rig, tested};
use rhytid_backend_wgpu::Wgpu;
use rhytid_core::{
    Animator, Backend, BasisStorage, DeviceErrorKind, DeviceInfo, Error, Stage, UploadOptions,
};

const SIZES: Sizes = Sizes { vertices: 1025, handles: 89, edges: 243, examples: 6, influences: 16 };

/// Each device, listed and opened.
fn devices() -> Vec<(DeviceInfo, Wgpu)> {
    let devices = tested(Wgpu::devices().unwrap()).into_iter();
    devices.map(|info| (info.clone(), Wgpu::open(&info).unwrap())).collect()
}

#[test]
fn batches_of_every_size_agree_with_the_cpu() {
    let rig = rig(1, SIZES);
    for (info, wgpu) in devices() {
        let mut animator = Animator::new(&wgpu, &rig, UploadOptions::frames(40)).unwrap();
        for (seed, batch) in [31, 1, 40, 2, 2].into_iter().enumerate() {
            let positions = frames(seed as u64, &rig, batch);
            animator.evaluate(&positions).unwrap();
            let context = format!("{}, {batch} frames", info.id());
            agree(&all_stages(&mut animator), &expected(&rig, &positions, BasisStorage::F32), &context);
        }
    }
}

#[test]
fn sizes_around_a_workgroup_and_empty_parts_agree_with_the_cpu() {
    let devices = devices();
    for (vertices, handles, edges, examples, influences) in
        [(4, 1, 0, 0, 0), (63, 2, 1, 0, 1), (64, 3, 63, 1, 2), (65, 8, 65, 40, 16), (129, 5, 64, 6, 3)]
    {
        let rig = rig(vertices as u64, Sizes { vertices, handles, edges, examples, influences });
        let positions = frames(9, &rig, 3);
        let expected = expected(&rig, &positions, BasisStorage::F32);
        for (info, wgpu) in &devices {
            let mut animator = Animator::new(wgpu, &rig, UploadOptions::frames(3)).unwrap();
            animator.evaluate(&positions).unwrap();
            agree(&all_stages(&mut animator), &expected, &format!("{}, V = {vertices}", info.id()));
        }
    }
}

#[test]
fn an_fp16_basis_agrees_with_the_cpus() {
    let rig = rig(2, SIZES);
    let positions = frames(3, &rig, 5);
    let options = UploadOptions { max_frames: 5, basis: BasisStorage::F16 };
    let fp16 = expected(&rig, &positions, BasisStorage::F16);
    let singles = expected(&rig, &positions, BasisStorage::F32);
    assert!(fp16[1] != singles[1], "fp16 is to be told from f32");
    for (info, wgpu) in devices() {
        let mut animator = Animator::new(&wgpu, &rig, options).unwrap();
        animator.evaluate(&positions).unwrap();
        agree(&all_stages(&mut animator), &fp16, &info.id());
    }
}

#[test]
fn batches_may_follow_without_a_read_in_between() {
    let rig = rig(3, SIZES);
    for (info, wgpu) in devices() {
        let mut animator = Animator::new(&wgpu, &rig, UploadOptions::frames(3)).unwrap();
        for seed in 0..20 {
            animator.evaluate(&frames(seed, &rig, 1 + seed as usize % 3)).unwrap();
        }
        let last = frames(19, &rig, 2);
        agree(&all_stages(&mut animator), &expected(&rig, &last, BasisStorage::F32), &info.id());
    }
}

#[test]
fn two_threads_can_each_have_a_session_on_one_device() {
    let rig = rig(4, SIZES);
    for (info, wgpu) in devices() {
        std::thread::scope(|scope| {
            for thread in 0..2 {
                let (rig, wgpu, info) = (&rig, &wgpu, &info);
                scope.spawn(move || {
                    for seed in 0..8 {
                        let mut animator = Animator::new(wgpu, rig, UploadOptions::frames(4)).unwrap();
                        let positions = frames(thread * 100 + seed, rig, 4);
                        animator.evaluate(&positions).unwrap();
                        let expected = expected(rig, &positions, BasisStorage::F32);
                        agree(&all_stages(&mut animator), &expected, &info.id());
                    }
                });
            }
        });
    }
}

#[test]
fn two_threads_can_each_open_every_device() {
    let rig = rig(5, SIZES);
    let positions = frames(0, &rig, 2);
    let expected = &expected(&rig, &positions, BasisStorage::F32);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                for (info, wgpu) in devices() {
                    let mut animator = Animator::new(&wgpu, &rig, UploadOptions::frames(2)).unwrap();
                    animator.evaluate(&positions).unwrap();
                    agree(&all_stages(&mut animator), expected, &info.id());
                }
            });
        }
    });
}

#[test]
fn the_times_of_the_stages_fit_into_the_time_of_the_batch() {
    let rig = rig(6, Sizes { vertices: 20_000, ..SIZES });
    for (info, wgpu) in devices() {
        let timed = wgpu.device().features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let mut animator = Animator::new(&wgpu, &rig, UploadOptions::frames(4)).unwrap();
        let positions = frames(0, &rig, 4);
        animator.evaluate(&positions).unwrap();
        animator.read(Stage::Normals, &mut Vec::new()).unwrap();
        let start = std::time::Instant::now();
        animator.evaluate(&positions).unwrap();
        let times = animator.stage_times().unwrap();
        let elapsed = start.elapsed();
        assert_eq!(times.is_some(), timed, "{}", info.id());
        if let Some(times) = times {
            let sum: std::time::Duration = times.iter().sum();
            assert!(sum <= elapsed, "{}: {times:?} in {elapsed:?}", info.id());
            assert!(
                times[Stage::LargeScale as usize] > elapsed / 100,
                "{}: {times:?} in {elapsed:?}",
                info.id()
            );
        }
    }
}

#[test]
fn a_device_that_is_gone_is_not_found() {
    let gone = DeviceInfo {
        backend: "wgpu",
        index: 99,
        name: "Gone".into(),
        driver: "none".into(),
        kind: rhytid_core::DeviceKind::Other,
        memory_bytes: None,
        max_binding_bytes: None,
    };
    let error = Wgpu::open(&gone).unwrap_err();
    assert!(matches!(error, Error::Device { kind: DeviceErrorKind::NotFound, .. }), "{error}");
}

#[test]
fn devices_are_numbered_and_say_which_api_they_are_reached_by() {
    let devices = tested(Wgpu::devices().unwrap());
    assert_eq!(devices, Wgpu::devices().unwrap());
    // Devices of OpenGL never get another device's index, even if that device's driver fails.
    let (gl, newer): (Vec<_>, Vec<_>) =
        devices.iter().partition(|device| device.driver.starts_with("OpenGL"));
    for (index, device) in newer.into_iter().enumerate().chain((8..).zip(gl)) {
        assert_eq!((device.backend, device.index), ("wgpu", index));
        let apis = ["Vulkan", "Metal", "Direct3D 12", "OpenGL"];
        assert!(apis.iter().any(|api| device.driver.starts_with(api)), "{}", device.driver);
        assert!(device.max_binding_bytes.is_some_and(|bytes| bytes <= 128 << 20));
    }
}
