//! Where the result goes: folders, disks, Ctrl-C and pipes.

use crate::common::{Fixture, assert_refused, list, stderr};
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn solved() -> Fixture {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    f
}

/// Every command that writes one file: its start up to the file's name without ending, and the endings.
const WRITERS: [(&str, &[&str]); 5] = [
    ("solve face.toml -o", &["safetensors"]),
    ("animate face.safetensors take.csv --device cpu:0 -o", &["usd", "usda", "usdz", "glb", "gltf"]),
    (
        "animate face.safetensors take.csv --device cpu:0 --compressed --max-error 0.00001 -o",
        &["glb", "gltf"],
    ),
    ("export-shapes face.safetensors --device cpu:0 -o", &["usd", "usda", "usdz", "glb", "gltf"]),
    ("pack face.safetensors -o", &["safetensors"]),
];

fn writers() -> impl Iterator<Item = (&'static str, &'static str)> {
    WRITERS.into_iter().flat_map(|(command, endings)| endings.iter().map(move |&ending| (command, ending)))
}

#[test]
fn a_folder_that_does_not_exist() {
    let f = solved();
    for (command, ending) in writers() {
        f.refused(&format!("{command} nowhere/face.{ending}"), &["nowhere", "does not exist"]);
        assert!(!f.path("nowhere").exists());
    }
}

#[test]
fn a_folder_under_the_files_name() {
    let f = solved();
    for (command, ending) in writers() {
        let name = format!("folder.{ending}");
        std::fs::create_dir_all(f.path(&name)).unwrap();
        f.refused(&format!("{command} {name}"), &[&name, "is a folder"]);
        assert_eq!(list(&f.path(&name)), Vec::<String>::new());
    }
}

/// Root may write everywhere. A test that runs as root therefore runs the program as nobody.
#[test]
#[cfg(unix)]
fn a_folder_without_the_right_to_write() {
    use std::os::unix::{fs::PermissionsExt, process::CommandExt};
    const NOBODY: u32 = 65534;
    let f = solved();
    let allow = |name: &str, mode| {
        std::fs::set_permissions(f.path(name), std::fs::Permissions::from_mode(mode)).unwrap();
    };
    allow("out", 0o555);
    let is_root = std::fs::write(f.path("out/probe"), "").is_ok();
    if is_root {
        // The user nobody may not be allowed to read the program's folder.
        std::fs::remove_file(f.path("out/probe")).unwrap();
        std::fs::copy(env!("CARGO_BIN_EXE_rhytid"), f.path("rhytid")).unwrap();
        allow(".", 0o755);
    }
    for (command, ending) in writers() {
        let program = if is_root { f.path("rhytid") } else { env!("CARGO_BIN_EXE_rhytid").into() };
        let mut program = Command::new(program);
        if is_root {
            program.uid(NOBODY).gid(NOBODY);
        }
        let args = format!("{command} out/face.{ending}");
        program.args(args.split_whitespace()).current_dir(f.path("."));
        let output =
            program.output().expect("nobody should be able to start programs in the temporary folder");
        assert_refused(&output, &["out/face", "permission denied"]);
    }
    f.assert_nothing_written();
    allow("out", 0o755);
}

#[test]
fn what_stood_under_the_name_survives_a_failure() {
    let f = solved();
    f.write("out/face.usda", "precious");
    f.write("take.csv", "time\n");
    let output = f.rhytid("animate face.safetensors take.csv -o out/face.usda").output().unwrap();
    assert_refused(&output, &["take.csv"]);
    assert_eq!(list(&f.path("out")), ["face.usda"]);
    assert_eq!(f.read("out/face.usda"), b"precious");
}

/// The limit on a file's size stands for a full disk.
#[test]
#[cfg(unix)]
fn a_limit_on_the_files_size() {
    let f = solved();
    for (command, ending) in writers() {
        let script = r#"ulimit -f 8; exec "$0" $1"#;
        let output = Command::new("sh")
            .args(["-c", script, env!("CARGO_BIN_EXE_rhytid"), &format!("{command} out/face.{ending}")])
            .current_dir(f.path("."))
            .output()
            .unwrap();
        assert_refused(&output, &["out/face", "no space left", "not written"]);
        f.assert_nothing_written();
    }
}

/// A disk that is really full, if this user may make one.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk() {
    let f = Fixture::with_side(61);
    f.done("solve face.toml -o face.safetensors");
    let out = f.path("out");
    let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=20k", "tmpfs"]).arg(&out).output();
    if !mount.is_ok_and(|output| output.status.success()) {
        rhytid_test_support::skip("this user may not mount a small disk");
        return;
    }
    let _unmount = Unmount(&out);
    for (command, ending) in writers() {
        let output = f.rhytid(&format!("{command} out/face.{ending}")).output().unwrap();
        assert_refused(&output, &["out/face", "no space left", "not written"]);
        f.assert_nothing_written();
    }
}

struct Unmount<'a>(&'a Path);

impl Drop for Unmount<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0).status();
    }
}

/// Starts a command, waits for a line on stderr that begins with `line`, sends it `signals` and waits.
#[cfg(unix)]
fn interrupted(f: &Fixture, args: &str, line: &str, signals: &[&str]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_rhytid"))
        .args(args.split_whitespace())
        .current_dir(f.path("."))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut reader = BufReader::new(child.stderr.take().unwrap());
    let mut text = String::new();
    while !text.lines().any(|l| l.starts_with(line)) {
        assert!(reader.read_line(&mut text).unwrap() > 0, "{args}: ended without {line:?}: {text}");
    }
    for signal in signals {
        // The shell's own kill: the program is not on every system.
        let kill = Command::new("sh").args(["-c", &format!("kill {signal} {}", child.id())]).status();
        assert!(kill.unwrap().success());
    }
    let sent = Instant::now();
    reader.read_to_string(&mut text).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(sent.elapsed() < Duration::from_secs(20), "{args}: it took {:?} to stop", sent.elapsed());
    Output { stderr: text.into_bytes(), ..output }
}

/// A face and a take that need a long time.
#[cfg(unix)]
fn long_work() -> Fixture {
    let f = Fixture::with_side(101);
    f.write("take.csv", f.take(20_000));
    f.done("solve face.toml -o face.safetensors");
    f
}

#[test]
#[cfg(unix)]
fn ctrl_c_stops_and_leaves_nothing() {
    let f = long_work();
    for out in ["usd", "usda", "usdz", "glb --force", "gltf --force", "glb --compressed"] {
        let args =
            format!("animate face.safetensors take.csv --device cpu:0 --frames 0..2048 -o out/face.{out}");
        let output = interrupted(&f, &args, "animate", &["-INT"]);
        assert_refused(&output, &["stopped before the end"]);
        assert!(stderr(&output).contains("stopping…"));
        f.assert_nothing_written();
    }
}

#[test]
#[cfg(all(unix, feature = "film"))]
fn ctrl_c_stops_a_film() {
    let f = long_work();
    let args = "render face.safetensors take.csv -o out/face.mp4 --size 64x48";
    let output = interrupted(&f, args, "render", &["-INT"]);
    assert_refused(&output, &["stopped before the end"]);
    f.assert_nothing_written();
}

/// The second request comes while the first still waits for the end of a frame; several tries may be needed.
#[test]
#[cfg(target_os = "linux")]
fn ctrl_c_twice_stops_at_once() {
    let f = Fixture::with_side(301);
    f.done("solve face.toml -o face.safetensors");
    f.write("take.csv", f.take(2000));
    let stopped_at_once = || {
        let args = "animate face.safetensors take.csv --device cpu:0 -o out/face.usda";
        let output = interrupted(&f, args, "animate", &["-INT", "-TERM"]);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        f.assert_nothing_written();
        !stderr(&output).contains("nothing was written")
    };
    assert!((0..20).any(|_| stopped_at_once()), "the second Ctrl-C was never needed");
}

#[test]
#[cfg(unix)]
fn ctrl_c_stops_a_solve() {
    let f = Fixture::with_side(301);
    let output = interrupted(&f, "solve face.toml -o out/face.safetensors", "", &["-INT"]);
    assert_refused(&output, &["stopped before the end"]);
    f.assert_nothing_written();
}

/// Work that cannot be asked to stop: a factorisation in a library, or a pipe that nobody writes to.
#[test]
#[cfg(unix)]
fn ctrl_c_ends_work_that_does_not_listen() {
    let f = solved();
    assert!(Command::new("mkfifo").arg(f.path("pipe.csv")).status().unwrap().success());
    let output =
        interrupted(&f, "animate face.safetensors pipe.csv -o out/face.usd", "read the rig", &["-INT"]);
    let said = assert_refused(&output, &["stopped before the end"]);
    assert!(!said.contains("nothing was written"), "{said}");
    f.assert_nothing_written();
}

#[test]
#[cfg(unix)]
fn ctrl_c_stops_the_demo() {
    let f = Fixture::new();
    let output = interrupted(&f, "demo demo --vertices 60000", "write the input", &["-INT"]);
    assert_refused(&output, &["stopped", "demo"]);
    let files = list(&f.path("demo"));
    assert!(!files.iter().any(|name| name.ends_with(".partial") || name == "face.glb"), "{files:?}");
}

/// A reader that goes away is not an error, and no panic.
#[test]
#[cfg(unix)]
fn a_closed_pipe() {
    let f = solved();
    for args in ["--help", "info face.safetensors --json", "completions bash", "devices", "doctor face.toml"]
    {
        let mut child = Command::new(env!("CARGO_BIN_EXE_rhytid"))
            .args(args.split_whitespace())
            .current_dir(f.path("."))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""), "{args}");
    }
}

/// A full disk behind `>` is an error.
#[test]
#[cfg(target_os = "linux")]
fn standard_output_to_a_full_device() {
    let f = solved();
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_rhytid"))
        .args(["info", "neutral.obj"])
        .current_dir(f.path("."))
        .stdout(full)
        .stderr(Stdio::piped())
        .output()
        .unwrap();
    assert_refused(&output, &["standard output", "no space left"]);
}
