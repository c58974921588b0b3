//! Processors as the system describes them: with one, three or four levels of cache, or not at all.
#![cfg(all(target_os = "linux", target_arch = "x86_64"))]

use crate::common::Fixture;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;

/// Describes two processors in the folder `cpu`, as `/sys/devices/system/cpu` does.
fn describe(f: &Fixture, levels: usize) {
    for processor in 0..2 {
        for level in 1..=levels {
            let folder = format!("cpu/cpu{processor}/cache/index{level}");
            let size = format!("{}K", 32 << (2 * level));
            for (name, value) in [
                ("level", level.to_string().as_str()),
                ("type", "Unified"),
                ("size", &size),
                ("shared_cpu_list", "0-1"),
                ("coherency_line_size", "64"),
                ("ways_of_associativity", "8"),
            ] {
                f.write(&format!("{folder}/{name}"), format!("{value}\n"));
            }
        }
    }
}

/// Runs `script` without `sh`'s own PATH. A program `lscpu` reports if it is run.
fn run(f: &Fixture, script: &str) -> Option<String> {
    let output = Command::new("unshare")
        .args(["--mount", "sh", "-c", script])
        .current_dir(f.path(""))
        .env("RHYTID", env!("CARGO_BIN_EXE_rhytid"))
        .output()
        .ok()?;
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    output.status.success().then_some(()).ok_or(said).map_or_else(Some, |()| None)
}

#[test]
fn caches_of_any_kind_give_the_same_bytes_and_no_program_is_run() {
    let f = Fixture::new();
    f.write("bin/lscpu", "#!/bin/sh\ntouch ran\n");
    std::fs::set_permissions(f.path("bin/lscpu"), std::fs::Permissions::from_mode(0o755)).unwrap();
    f.done("solve face.toml -o face.safetensors");
    f.done("animate face.safetensors take.csv --device cpu:0 --compressed -o face.glb");
    let expected = [f.read("face.safetensors"), f.read("face.glb")];
    let commands = "PATH=\"$PWD/bin\"; \"$RHYTID\" solve face.toml -o out/face.safetensors && \
                    \"$RHYTID\" animate out/face.safetensors take.csv --device cpu:0 --compressed -o out/face.glb";
    if let Some(why) = run(&f, "mkdir none && mount --bind none /sys") {
        // A lent machine may forbid it. The list of features is compared below.
        eprintln!("no made-up processors here: {why}");
    } else {
        for (levels, over) in [(1, "cpu /sys/devices/system/cpu"), (3, "cpu /sys/devices/system/cpu")]
            .into_iter()
            .chain([(4, "cpu /sys/devices/system/cpu"), (0, "none /sys")])
        {
            describe(&f, levels);
            let failed = run(&f, &format!("mount --bind {over} && {commands}"));
            assert_eq!(failed, None, "{levels} levels");
            for (name, expected) in ["out/face.safetensors", "out/face.glb"].into_iter().zip(&expected) {
                assert!(f.read(name) == *expected, "{levels} levels: {name}");
            }
            assert!(!f.path("ran").exists(), "{levels} levels: lscpu was run");
        }
    }

    // This feature of the matrix crate reads /sys and runs programs.
    let tree = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "-p", "rhytid-cli", "-e", "features,no-dev", "-i", "private-gemm-x86"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let tree = String::from_utf8_lossy(&tree.stdout).into_owned();
    assert!(
        tree.contains("private-gemm-x86") && !tree.contains("private-gemm-x86 feature \"std\""),
        "{tree}"
    );
}
