//! The folder that programs install, with pkg-config and with CMake, after it was moved.
use crate::layout::lay_out;
use crate::support::{FILES, command, has, libraries, own, said};
use std::path::PathBuf;
use std::process::Command;

/// The installation, at another place than where it was laid out.
fn installed(name: &str) -> PathBuf {
    let (first, moved) = (FILES.folder.path().join(format!("{name} first")), FILES.folder.path().join(name));
    lay_out(own(), &libraries(), &first).unwrap();
    std::fs::rename(first, &moved).unwrap();
    moved
}

/// Plays the take with a program that needs the installation's library.
fn plays(program: PathBuf, installed: &std::path::Path) {
    let mut play = command(program);
    play.env("LD_LIBRARY_PATH", installed.join("lib")).env("RHYTID_DEVICE", "cpu:0");
    let said = said(play.args([&FILES.rig_file, &FILES.take_file]));
    assert!(said.starts_with("20 frames of"), "{said}");
}

#[test]
fn pkg_config_finds_it() {
    if !has(&["pkg-config", "gcc"]) {
        return;
    }
    let installed = installed("with pkg-config");
    let mut ask = Command::new("pkg-config");
    ask.env("PKG_CONFIG_PATH", installed.join("lib/pkgconfig")).args(["--cflags", "--libs", "rhytid"]);
    let version = said(
        Command::new("pkg-config")
            .args(["--modversion", "rhytid"])
            .env("PKG_CONFIG_PATH", installed.join("lib/pkgconfig")),
    );
    assert_eq!(version.trim(), env!("CARGO_PKG_VERSION"));
    let flags = said(&mut ask);
    let program = FILES.folder.path().join("play with pkg-config");
    // A shell splits the flags, as in a makefile: the folder's name has blanks.
    let script = format!("gcc \"$1\" {} -o \"$2\"", flags.trim());
    said(
        Command::new("sh").args(["-c", &script, "sh"]).arg(own().join("examples/play_take.c")).arg(&program),
    );
    plays(program, &installed);
}

#[test]
fn cmake_finds_it() {
    if !has(&["cmake", "gcc", "g++", "make"]) {
        return;
    }
    let installed = installed("with cmake");
    let build = FILES.folder.path().join("build with cmake");
    let mut configure = Command::new("cmake");
    configure.arg("-S").arg(own().join("examples")).arg("-B").arg(&build);
    said(configure.arg(format!("-DCMAKE_PREFIX_PATH={}", installed.display())));
    said(Command::new("cmake").arg("--build").arg(&build));
    plays(build.join("play_take"), &installed);
    let has_vulkan = PathBuf::from("/usr/include/vulkan/vulkan.h").is_file() && has(&["glslangValidator"]);
    assert_eq!(build.join("draw_take").is_file(), has_vulkan);
}
