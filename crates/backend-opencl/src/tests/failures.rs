//! Failures of builds, of memory and of drivers, each an error.
use super::support::{devices, frames, is_child_for, output_of_success, rig, run_child};
use crate::OpenCl;
use rhytid_core::{Animator, Backend, DeviceErrorKind, Error, UploadOptions};
use rhytid_kernels::table::Kernel;

fn kind_and_message<T>(result: rhytid_core::Result<T>) -> (DeviceErrorKind, String) {
    match result {
        Err(Error::Device { kind, device, message }) => (kind, format!("{device}: {message}")),
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("it succeeded"),
    }
}

#[test]
fn a_kernel_that_does_not_build_gives_the_compilers_log() {
    for info in devices() {
        let broken = |kernel: Kernel| match kernel {
            Kernel::Detail => kernel.entry().opencl.replace("params.centers", "params.no_such_field"),
            _ => kernel.entry().opencl.to_owned(),
        };
        let (kind, message) = kind_and_message(OpenCl::open_with(&info, broken));
        assert_eq!(kind, DeviceErrorKind::Build);
        assert!(message.contains("detail") && message.contains("no_such_field"), "{message}");
        assert!(message.lines().count() > 1, "{message}");
    }
}

#[test]
fn a_device_that_is_not_there_is_not_found() {
    for mut info in devices() {
        info.index += 1000;
        let (kind, message) = kind_and_message(OpenCl::open(&info));
        assert_eq!(kind, DeviceErrorKind::NotFound, "{message}");
        assert!(message.starts_with(&info.id()), "{message}");
    }
}

#[test]
fn a_rig_too_large_is_out_of_memory_or_unsupported() {
    let rig = rig([300, 20, 30, 6, 16]);
    for info in devices() {
        let mut device = OpenCl::open(&info).unwrap();
        let memory = device.memory_bytes;
        device.memory_bytes = 100_000;
        let (kind, message) = kind_and_message(device.upload(&rig, UploadOptions::frames(100)));
        assert_eq!(kind, DeviceErrorKind::OutOfMemory, "{message}");
        device.memory_bytes = memory;
        device.limits.max_binding_bytes = 1000;
        let (kind, message) = kind_and_message(device.upload(&rig, UploadOptions::frames(100)));
        assert_eq!(kind, DeviceErrorKind::Unsupported, "{message}");
    }
}

/// The driver refuses buffers above its limit. The error has the driver's status.
#[test]
fn the_drivers_refusal_names_the_buffer() {
    for info in devices() {
        let device = OpenCl::open(&info).unwrap();
        let refused = crate::cl::Buffer::with_bytes(&device.context, 0, usize::MAX / 2)
            .map_err(crate::status::Status::error(&device.name, "making the buffer basis"));
        let (_, message) = kind_and_message(refused);
        assert!(message.contains("making the buffer basis failed with CL_"), "{message}");
    }
}

#[test]
fn without_a_platform_there_are_no_devices() {
    const TEST: &str = "tests::failures::without_a_platform_there_are_no_devices";
    if is_child_for(TEST) {
        let start = std::time::Instant::now();
        let devices = OpenCl::devices().unwrap();
        println!("found {} devices", devices.len());
        assert!(start.elapsed().as_secs() < 10, "it waits for a platform");
        return;
    }
    // The two loaders, Khronos' and Debian's, search for drivers in these places.
    let nowhere = [("OCL_ICD_FILENAMES", ""), ("OCL_ICD_VENDORS", "/nowhere/")];
    let output = output_of_success(&run_child(TEST, &[], &nowhere));
    if output.contains("found 0 devices") {
        return;
    }
    rhytid_test_support::skip("the loader finds drivers in spite of OCL_ICD_VENDORS");
}

/// Files that are no libraries have the loader's names. For the child, this is a system without the loader.
#[cfg(target_os = "linux")]
#[test]
fn without_a_loader_there_are_no_devices() {
    const TEST: &str = "tests::failures::without_a_loader_there_are_no_devices";
    if is_child_for(TEST) {
        assert!(!crate::has_loader());
        println!("found {} devices", OpenCl::devices().unwrap().len());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for name in ["libOpenCL.so.1", "libOpenCL.so"] {
        std::fs::write(folder.path().join(name), "").unwrap();
    }
    let environment = [("LD_LIBRARY_PATH", folder.path().to_str().unwrap())];
    let output = output_of_success(&run_child(TEST, &[], &environment));
    assert!(output.contains("found 0 devices"), "{output}");
}

#[test]
fn what_is_told_of_a_device_is_plausible() {
    for (index, info) in devices().into_iter().enumerate() {
        assert_eq!((info.backend, info.index, info.id()), ("opencl", index, format!("opencl:{index}")));
        assert!(!info.name.is_empty() && info.driver.contains(", "), "{info:?}");
        let (memory, largest) = (info.memory_bytes.unwrap(), info.max_binding_bytes.unwrap());
        // This is the minimum of a full profile.
        assert!(largest >= 128 << 20 && largest <= memory, "{info:?}");
        println!("{info:?}");
        let device = OpenCl::open(&info).unwrap();
        let rig = rig([2, 2, 1, 1, 1]);
        Animator::new(&device, &rig, UploadOptions::frames(1))
            .unwrap()
            .evaluate(&frames(&rig, 1, 0))
            .unwrap();
    }
}
