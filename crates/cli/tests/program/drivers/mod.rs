//! Drivers that crash, hang, end the program or compute nothing. None of them ends `rhytid`, and the
//! processor's results are right.
#![cfg(target_os = "linux")]

use crate::common::{Fixture, stderr};
use assert_cmd::Command;
use std::path::PathBuf;
use std::process::Output;
use std::time::{Duration, Instant};

/// Longer than any wait for a driver, on a busy machine too.
const ENDS_WELL: Duration = Duration::from_secs(60);

/// Where the Vulkan driver for processors has its manifest.
const LAVAPIPE: &str = "/usr/share/vulkan/icd.d/lvp_icd.x86_64.json";

struct Driver {
    f: Fixture,
    manifest: PathBuf,
}

impl Driver {
    /// Builds `bad.c` as `kind` of driver.
    fn new(kind: &str) -> Self {
        let f = Fixture::new();
        f.write("bad.c", include_str!("bad.c"));
        let built = std::process::Command::new("cc")
            .args(["-shared", "-fPIC", "-O1", &format!("-D{kind}"), "bad.c", "-o", "bad.so", "-ldl"])
            .current_dir(f.path(""))
            .status()
            .unwrap();
        assert!(built.success());
        let library = f.path("bad.so").display().to_string();
        f.write("bad.json", manifest(&library));
        f.done("solve face.toml -o face.safetensors");
        f.done("animate face.safetensors take.csv --device cpu:0 -o expected.usd");
        let manifest = f.path("bad.json");
        Self { f, manifest }
    }

    /// A command that sees this driver beside the one that works, with a cache of its own.
    fn rhytid(&self, args: &str) -> Command {
        let mut command = self.f.rhytid(args);
        let both = format!("{}:{LAVAPIPE}", self.manifest.display());
        command.env("VK_DRIVER_FILES", &both).env("VK_ICD_FILENAMES", &both);
        command.env("XDG_CACHE_HOME", self.f.path("cache")).env("REAL", library_of(LAVAPIPE));
        command.env_remove("REQUIRE_BACKENDS").env_remove("REQUIRE_DEVICES").timeout(ENDS_WELL);
        command
    }

    fn run(&self, args: &str) -> (Output, Duration) {
        let start = Instant::now();
        let output = self.rhytid(args).output().unwrap();
        (output, start.elapsed())
    }
}

fn manifest(library: &str) -> String {
    format!(
        r#"{{"file_format_version": "1.0.0", "ICD": {{"library_path": "{library}", "api_version": "1.3.0"}}}}"#
    )
}

fn library_of(manifest: &str) -> String {
    let text = std::fs::read(manifest).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&text).unwrap();
    json["ICD"]["library_path"].as_str().unwrap().to_owned()
}

#[test]
fn a_driver_that_crashes_is_named_and_passed_over() {
    is_named_and_passed_over("CRASHES", "its driver crashes (a wrong address, signal 11)");
}

#[test]
fn a_driver_that_ends_its_process_is_named_and_passed_over() {
    is_named_and_passed_over("EXITS", "its driver ends the program that tries it, with exit code 0");
}

#[test]
fn a_driver_that_hangs_is_named_and_passed_over() {
    is_named_and_passed_over("HANGS", "its driver hangs");
}

/// Every command works beside this `kind` of driver, and says `what` it does.
fn is_named_and_passed_over(kind: &str, what: &str) {
    let driver = Driver::new(kind);
    let named = |said: &str| {
        assert!(said.contains(what) && said.contains("bad.json"), "{kind}: {said}");
        assert!(said.contains("VK_LOADER_DRIVERS_DISABLE=bad.json"), "{kind}: {said}");
        assert!(!said.contains("lvp_icd"), "{kind}: {said}");
    };
    let (output, took) = driver.run("devices");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success() && said.contains("cpu:0"), "{kind}: {said} {}", stderr(&output));
    named(&said);
    eprintln!("{kind}: devices {took:.1?}");

    let (output, took) = driver.run("conform --quick");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success() && said.contains("[cpu/"), "{kind}: {said} {}", stderr(&output));
    named(&said);
    eprintln!("{kind}: conform {took:.1?}");

    for round in ["first", "second"] {
        let (output, took) = driver.run("animate face.safetensors take.csv -o out/face.usd");
        let said = stderr(&output);
        assert!(output.status.success() && said.contains("device: cpu:0"), "{kind}, {round}: {said}");
        named(&said);
        assert!(said.contains("so it was before") == (round == "second"), "{kind}, {round}: {said}");
        assert!(driver.f.read("out/face.usd") == driver.f.read("expected.usd"), "{kind}, {round}");
        eprintln!("{kind}: animate, {round}, {took:.1?}");
    }

    // As the message says, everything works without the driver. A new query gets a new answer.
    let output = driver.rhytid("devices").env("VK_LOADER_DRIVERS_DISABLE", "bad.json").output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("vulkan:0"), "{kind}: {said}");
    assert!(!driver.f.read_text("cache/rhytid/devices.json").contains("hangs"), "{kind}");
}

#[test]
fn a_driver_that_is_asked_for_and_crashes_is_one_sentence() {
    let driver = Driver::new("CRASHES");
    let (output, _) = driver.run("animate face.safetensors take.csv --device vulkan:0 -o out/face.usd");
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.starts_with("error: vulkan:0: its driver crashes") && said.lines().count() == 1, "{said}");
    driver.f.assert_nothing_written();
}

/// Memory that the device may still be using is not freed. Uploaded data goes to the next device or is given
/// up.
#[test]
fn a_wait_that_fails_frees_nothing() {
    let driver = Driver::new("NEVER_WAITS");
    let alone = driver.manifest.as_os_str().to_owned();
    for _ in 0..5 {
        let mut command =
            driver.rhytid("animate face.safetensors take.csv --device vulkan:0 -o out/face.usd");
        let output = command.env("VK_DRIVER_FILES", &alone).env("VK_ICD_FILENAMES", &alone).output().unwrap();
        let said = stderr(&output);
        assert!(
            output.status.code() == Some(1) && said.contains("waiting for the device"),
            "{said} {output:?}"
        );
        driver.f.assert_nothing_written();
    }
}

/// A driver that reports success.
#[test]
fn a_driver_that_computes_nothing_is_found_out() {
    let driver = Driver::new("IS_SILENT");
    let silent = |command: &mut Command| {
        let alone = driver.manifest.as_os_str().to_owned();
        command.env("VK_DRIVER_FILES", &alone).env("VK_ICD_FILENAMES", &alone).output().unwrap()
    };
    let output = silent(&mut driver.rhytid("conform --quick --device vulkan:0"));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.code() == Some(1) && said.contains("FAILED"), "{said} {}", stderr(&output));

    let mut command = driver.rhytid("animate face.safetensors take.csv --device vulkan:0 -o out/face.usd");
    let output = silent(&mut command);
    let said = stderr(&output);
    assert!(
        output.status.code() == Some(1) && said.contains("error: vulkan:0: its driver computes wrongly"),
        "{said}"
    );
    driver.f.assert_nothing_written();

    let output = silent(&mut driver.rhytid("animate face.safetensors take.csv -o out/face.usd"));
    let said = stderr(&output);
    assert!(output.status.success() && said.contains("device: cpu:0"), "{said}");
    assert!(driver.f.read("out/face.usd") == driver.f.read("expected.usd"));
}
