//! The devices of this machine, those that `auto` chooses and remembers, and what `conform` says about them.

use crate::common::{Fixture, assert_refused, list, rhytid, stderr};
use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;

const ANIMATE: &str = "animate face.safetensors take.csv -o out/face.usda";

fn listing(command: &mut Command) -> Value {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The backends that have a device, and those that are listed as having none.
fn backends(listing: &Value) -> [Vec<&str>; 2] {
    ["devices", "left_out"].map(|key| {
        let entries = listing[key].as_array().unwrap().iter();
        entries.map(|entry| entry["backend"].as_str().unwrap()).collect()
    })
}

#[test]
fn every_backend_is_either_there_or_said_to_be_missing() {
    let listing = listing(&mut rhytid("devices --json"));
    let [there, missing] = backends(&listing);
    for backend in ["cpu", "vulkan", "opencl", "wgpu"] {
        assert!(there.contains(&backend) != missing.contains(&backend), "{backend}: {listing}");
    }
    let required = std::env::var("REQUIRE_BACKENDS").unwrap_or_default();
    for backend in required.split(',').filter(|name| !name.is_empty()) {
        assert!(there.contains(&backend), "{backend} is required and not there: {listing}");
    }
}

#[test]
fn without_a_single_driver_the_processor_is_left() {
    let f = Fixture::new();
    let mut command = f.rhytid("devices --json");
    for name in ["VK_ICD_FILENAMES", "VK_DRIVER_FILES", "OCL_ICD_VENDORS", "__EGL_VENDOR_LIBRARY_FILENAMES"] {
        command.env(name, f.path("nothing-here"));
    }
    let listing = listing(&mut command);
    let [there, missing] = backends(&listing);
    assert!(there.contains(&"cpu"), "{listing}");
    assert!(!there.contains(&"vulkan") && !there.contains(&"opencl"), "{listing}");
    assert!(missing.contains(&"vulkan") && missing.contains(&"opencl"), "{listing}");
}

/// Files that are no libraries have the loader's names.
#[cfg(target_os = "linux")]
#[test]
fn a_missing_opencl_loader_is_told_from_a_missing_driver() {
    let f = Fixture::new();
    let why = |command: &mut Command| {
        let listing = listing(command);
        let entries = listing["left_out"].as_array().unwrap();
        let entry = entries.iter().find(|entry| entry["backend"] == "opencl");
        entry.unwrap_or_else(|| panic!("{listing}"))["why"].as_str().unwrap().to_owned()
    };
    for name in ["libOpenCL.so.1", "libOpenCL.so"] {
        std::fs::write(f.path(name), "").unwrap();
    }
    let no_loader = why(f.rhytid("devices --json").env("LD_LIBRARY_PATH", f.path("")));
    assert!(no_loader.starts_with("no OpenCL loader was found"), "{no_loader}");
    let nowhere = f.path("nothing-here");
    let no_driver =
        why(f.rhytid("devices --json").env("OCL_ICD_VENDORS", &nowhere).env("OCL_ICD_FILENAMES", ""));
    // On a machine without a loader, the missing loader is again the reason.
    assert!(no_driver.starts_with("no OpenCL platform was found") || no_driver == no_loader, "{no_driver}");
}

/// A named device does not suffer from other drivers. Here one of these is asked for a layer that does not
/// exist.
#[test]
fn a_device_that_is_named_is_the_only_one_looked_for() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    let broken = |args: &str| {
        let mut command = f.rhytid(args);
        command.env("RHYTID_VULKAN_VALIDATION", "1").env("VK_LAYER_PATH", f.path("out"));
        command.env_remove("VK_ADD_LAYER_PATH");
        command
    };
    let output = broken(&format!("{ANIMATE} --device cpu:0")).output().unwrap();
    assert!(output.status.success() && !stderr(&output).contains("vulkan"), "{}", stderr(&output));
    if backends(&listing(&mut rhytid("devices --json")))[0].contains(&"vulkan") {
        let output = broken(&format!("{ANIMATE} --device cpu:7")).output().unwrap();
        assert!(stderr(&output).contains("the backend vulkan is left out"), "{}", stderr(&output));
    }
}

/// A loader that is no library counts as missing.
#[cfg(target_os = "linux")]
#[test]
fn without_loaders_the_program_starts() {
    let f = Fixture::new();
    std::fs::create_dir(f.path("lib")).unwrap();
    for loader in ["libvulkan.so.1", "libvulkan.so", "libEGL.so.1", "libEGL.so"] {
        f.write(&format!("lib/{loader}"), "");
    }
    let listing = listing(f.rhytid("devices --json").env("LD_LIBRARY_PATH", f.path("lib")));
    let [there, missing] = backends(&listing);
    assert!(there.contains(&"cpu"), "{listing}");
    assert!(missing.contains(&"vulkan") && missing.contains(&"wgpu"), "{listing}");
}

fn animate(f: &Fixture, cache: &Path, args: &str) -> String {
    let output = f.rhytid(&format!("{ANIMATE} {args}")).env("XDG_CACHE_HOME", cache).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    stderr(&output)
}

#[test]
fn auto_says_what_it_takes_and_tries_each_device_once() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    let cache = f.path("cache");
    let file = cache.join("rhytid/devices.json");

    let first = animate(&f, &cache, "");
    assert!(first.contains("try the devices") && first.contains("device: "), "{first}");
    let remembered: Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    // If the processor itself conforms, drivers that run on the processor are not tried.
    let listing = listing(&mut rhytid("devices --json"));
    let devices = listing["devices"].as_array().unwrap();
    let software = devices.iter().filter(|device| device["software_driver"] == true).count();
    assert_eq!(remembered["devices"].as_array().unwrap().len(), devices.len() - software);

    let second = animate(&f, &cache, "");
    assert!(!second.contains("try the devices") && second.contains("device: "), "{second}");

    // A new driver is a new device. A truncated file is no driver.
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace("\"driver\": \"", "\"driver\": \"old ")).unwrap();
    assert!(animate(&f, &cache, "").contains("try the devices"));
    std::fs::write(&file, &text[..text.len() / 2]).unwrap();
    assert!(animate(&f, &cache, "").contains("try the devices"));

    // A device that failed is not chosen, however fast it is, and the user is told. The remaining devices are
    // tried now.
    let mut failing = remembered.clone();
    for device in failing["devices"].as_array_mut().unwrap() {
        device["failed"] = serde_json::json!(["normals/holes"]);
    }
    if software > 0 {
        std::fs::write(&file, failing.to_string()).unwrap();
        let output = animate(&f, &cache, "");
        assert!(!output.contains("device: cpu:0") && output.contains("device: "), "{output}");
        assert!(output.contains("cpu:0 fails: normals/holes"), "{output}");
        // Listing the devices tries them anew.
        rhytid("devices").env("XDG_CACHE_HOME", &cache).output().unwrap();
        assert!(animate(&f, &cache, "").contains("device: cpu:0"));
    }

    // A named device is used, and no device is tried.
    let named = animate(&f, &f.path("empty"), "--device cpu:0");
    assert!(!named.contains("auto") && !f.path("empty/rhytid").exists(), "{named}");
}

#[test]
fn all_devices_animate_alike() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    let listing = listing(&mut rhytid("devices --json"));
    let mut files = Vec::new();
    for device in listing["devices"].as_array().unwrap() {
        let id = device["id"].as_str().unwrap();
        f.done(&format!("animate face.safetensors take.csv -o out/face.glb --quiet --device {id}"));
        files.push((id.to_owned(), binary_words(&f.read("out/face.glb"))));
    }
    let (_, first) = &files[0];
    for (id, words) in &files {
        assert_eq!(words.len(), first.len(), "{id}");
        let alike = |(a, b): (&u32, &u32)| a == b || (f32::from_bits(*a) - f32::from_bits(*b)).abs() < 1e-4;
        assert!(words.iter().zip(first).all(alike), "{id} and {}", files[0].0);
    }
}

/// The words of a GLB's binary chunk: numbers, and indices, which are the same for all.
fn binary_words(glb: &[u8]) -> Vec<u32> {
    let (words, _) = glb.as_chunks::<4>();
    let words: Vec<u32> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let json_words = words[3] as usize / 4;
    words[5 + json_words + 2..].to_vec()
}

#[test]
fn conform_reports_on_a_device() {
    let f = Fixture::new();
    let printed = f.done("conform --quick --device cpu:0 --report report");
    assert!(printed.contains("[cpu/") && printed.contains("PASSED"), "{printed}");
    assert_eq!(list(&f.path("report")), ["junit.xml", "report.json", "report.md"]);
    let json: Value = serde_json::from_slice(&f.read("report/report.json")).unwrap();
    assert!(json.to_string().contains("\"cpu\""), "{json}");
    assert!(f.read_text("report/junit.xml").contains("<testsuite "));
    assert!(f.read_text("report/report.md").starts_with("# "));

    let output = rhytid("conform --device vulkan:99").output().unwrap();
    assert_refused(&output, &["vulkan:99", "cpu:0"]);
}
