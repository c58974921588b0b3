//! Oclgrind runs the kernels instruction by instruction. It reports data races, accesses outside of buffers,
//! numbers that were never written, and misuse of the API. A planted fault of each kind shows that the
//! reports work.
use super::support::{
    assert_agreement, devices, frames, is_child_for, on_cpu, output_of_success, rig, run_child,
};
use crate::OpenCl;
use rhytid_core::{Animator, BasisStorage, UploadOptions};
use rhytid_kernels::table::Kernel;
use std::process::Command;

const CASE: &str = "tests::oclgrind::small_case";

/// The fault that is planted in the kernels of a child.
const PLANT: &str = "RHYTID_PLANTED_FAULT";

/// The index in [`SIZES`] that a child evaluates.
const SIZE: &str = "RHYTID_SIZE";

/// Checks of races, the API and accesses, on the kernels as they are built.
const RACES: [&str; 3] = ["oclgrind", "--data-races", "--check-api"];

/// The check for numbers that were never written. Oclgrind 21.10 crashes in this check on optimised kernels.
const UNINITIALIZED: [&str; 4] = ["oclgrind", "--uninitialized", "--build-options", "-cl-opt-disable"];

/// V, H, F, P, K. V is around the workgroup's 64.
const SIZES: [[usize; 5]; 4] = [[1, 1, 0, 0, 0], [64, 3, 4, 1, 2], [65, 4, 65, 2, 3], [130, 3, 17, 2, 16]];

/// The source of the kernel, with the child's planted fault if there is one.
fn source(kernel: Kernel) -> String {
    let source = kernel.entry().opencl;
    let (of, from, to) = match std::env::var(PLANT).as_deref() {
        // Several tiles write to one place.
        Ok("race") => (Kernel::Normals, "v + lane, vertex_normals)", "first + lane, vertex_normals)"),
        // The last frame is written behind the end.
        Ok("overrun") => (Kernel::Strain, "features[frame *", "features[(frame + 1) *"),
        // One component is left out.
        Ok("unwritten") => (Kernel::Detail, "local_detail[result + 1] = sum[g][1].of[lane];", ""),
        _ => return source.to_owned(),
    };
    if kernel != of {
        return source.to_owned();
    }
    assert!(source.contains(from), "{} has no longer {from}", of.name());
    source.replace(from, to)
}

/// The work of the children, each with one rig. After a rig of another size in the same process, Oclgrind
/// 21.10 reports unwritten numbers that it does not report for that rig alone.
#[test]
fn small_case() {
    if !is_child_for(CASE) {
        return;
    }
    let sizes = SIZES[std::env::var(SIZE).unwrap().parse::<usize>().unwrap()];
    let fault = std::env::var(PLANT).ok();
    let devices = devices();
    assert!(devices.iter().all(|info| info.driver.starts_with("Oclgrind")), "{devices:?}");
    let mut device = OpenCl::open_with(&devices[0], source).unwrap();
    device.limits.max_binding_bytes = 7000;
    let rig = rig(sizes);
    for basis in [BasisStorage::F32, BasisStorage::F16] {
        let options = UploadOptions { max_frames: 6, basis };
        let mut session = Animator::new(&device, &rig, options).unwrap();
        let mut cpu = on_cpu(&rig, options);
        for count in [6, 1] {
            let positions = frames(&rig, count, count as u64);
            cpu.evaluate(&positions).unwrap();
            session.evaluate(&positions).unwrap();
            if fault.is_none() {
                assert_agreement(&mut session, &mut cpu, &format!("{sizes:?}"));
            }
        }
    }
    if fault.as_deref() == Some("call") {
        assert!(device.kernels(Kernel::Strain).unwrap()[0].1.set_words(99, &[0]).is_err());
    }
    println!("evaluated {sizes:?}");
}

/// Oclgrind's report on a child. `None` where Oclgrind is not installed.
fn report(launcher: &[&str], size: usize, fault: &str) -> Option<String> {
    if Command::new("oclgrind").arg("--version").output().is_err() {
        rhytid_test_support::skip("oclgrind is not installed, which looks for data races");
        return None;
    }
    let size_name = size.to_string();
    let mut environment = vec![(SIZE, size_name.as_str())];
    if !fault.is_empty() {
        environment.push((PLANT, fault));
    }
    let output = run_child(CASE, launcher, &environment);
    // Oclgrind's exit code is always that of the child, even if it reports faults.
    let all = output_of_success(&output);
    assert!(all.contains(&format!("evaluated {:?}", SIZES[size])), "{all}");
    // The first of thousands of reports are enough.
    Some(String::from_utf8_lossy(&output.stderr).trim().chars().take(2000).collect())
}

#[test]
fn nothing_is_found_in_the_small_cases() {
    for launcher in [&RACES[..], &UNINITIALIZED] {
        for (size, sizes) in SIZES.iter().enumerate() {
            if let Some(report) = report(launcher, size, "") {
                assert!(report.is_empty(), "{launcher:?}, {sizes:?}:\n{report}");
            }
        }
    }
}

#[test]
fn planted_faults_are_found() {
    for (launcher, fault, expected, where_it_is) in [
        (&RACES[..], "race", "Write-write data race at global memory address", "Kernel: normals"),
        (&RACES, "overrun", "Invalid write of size 4 at global memory address", "Kernel: strain"),
        (&RACES, "call", "OpenCL runtime error detected", "Function: clSetKernelArg"),
        (&UNINITIALIZED, "unwritten", "Uninitialized value written", "Kernel: fine_scale"),
    ] {
        if let Some(report) = report(launcher, 2, fault) {
            assert!(report.contains(expected) && report.contains(where_it_is), "{fault}:\n{report}");
        }
    }
}
