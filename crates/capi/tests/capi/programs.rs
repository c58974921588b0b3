//! C and C++ programs: with each compiler, with AddressSanitizer, and under valgrind.
use crate::support::{
    CLANG, CLANGXX, Compiler, FILES, GCC, GXX, command, command_without_drivers, has, own, said,
};
use rhytid::{AnimatorOptions, Stage, UploadOptions};
use std::path::{Path, PathBuf};

const PLAY: &str = "examples/play_take.c";
/// Fails at the first wrong access, and at the end if memory has leaked.
const SANITIZED: &[&str] = &["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];

fn program(name: &str) -> String {
    format!("tests/capi/programs/{name}")
}

fn rig() -> &'static Path {
    &FILES.rig_file
}

fn take() -> &'static Path {
    &FILES.take_file
}

/// Each program, its files, and what it says at the end.
fn each(run: impl Fn(&str, &[&Path], &str)) {
    run("wrong.c", &[rig()], "wrong arguments are errors");
    run("memory.c", &[rig(), take()], "memory is the file");
    run("threads.c", &[rig(), take()], "threads do not disturb each other");
}

fn all_of(c: Compiler, cpp: Compiler, flags: &[&str]) {
    let run = |compiler: Compiler, name: &str, files: &[&Path], end: &str| {
        if let Some(built) = compiler.build(&program(name), flags) {
            let said = said(command_without_drivers(built).args(files));
            assert_eq!(said.trim(), end, "{name} of {}", compiler.program);
        }
    };
    each(|name, files, end| run(c, name, files, end));
    run(cpp, "wrapper.cpp", &[rig(), take()], "the wrapper is the library");
}

#[test]
fn of_gcc() {
    all_of(GCC, GXX, &[]);
}

#[test]
fn of_clang() {
    all_of(CLANG, CLANGXX, &[]);
}

#[test]
fn with_sanitizers() {
    all_of(GCC, GXX, SANITIZED);
}

/// Valgrind sees the whole library, and not only the program, as AddressSanitizer does.
#[test]
fn under_valgrind() {
    if !has(&["valgrind"]) {
        return;
    }
    each(|name, files, end| {
        let Some(built) = GCC.build(&program(name), &[]) else { return };
        let mut valgrind = command_without_drivers("valgrind");
        // Threads of the pool outlive the program, so that what they hold is not freed.
        valgrind.args(["--error-exitcode=9", "--leak-check=full", "--errors-for-leak-kinds=definite"]);
        let said = said(valgrind.arg("--quiet").arg(built).args(files));
        assert_eq!(said.trim(), end, "{name}");
    });
}

/// With all drivers that are here.
#[test]
fn of_every_device() {
    let Some(program) = GCC.build(&program("devices.c"), &[]) else { return };
    assert_eq!(said(&mut command(program)).trim(), "the devices are listed");
}

/// The programs of docs/c.md, within a main function.
#[test]
fn the_page_has_programs_that_work() {
    let page = std::fs::read_to_string(own().join("../../docs/c.md")).unwrap();
    let block = |language: &str| {
        let (_, rest) = page.split_once(&format!("```{language}\n")).unwrap();
        rest.split_once("```").unwrap().0.to_owned()
    };
    let c =
        format!("#include <rhytid.h>\n#include <stdio.h>\nint main(void) {{\n{}return 0;\n}}\n", block("c"));
    let cpp = format!(
        "#include <rhytid.hpp>\n#include <cstdio>\nstatic int seen = 0;\nstatic void use(float x) {{ seen += x == x; }}\n\
         int main() {{\n{}std::printf(\"%d\", seen);\n}}\n",
        block("cpp")
    );
    let said_by = |compiler: Compiler, name: &str, source: String| {
        let file = FILES.folder.path().join(name);
        std::fs::write(&file, source).unwrap();
        let program = compiler.build(file.to_str().unwrap(), &[])?;
        Some(said(&mut command_without_drivers(program)))
    };
    // The program of C only speaks of errors.
    assert_eq!(said_by(GCC, "page.c", c).unwrap_or_default(), "");
    let numbers = (3 * FILES.rig.vertices()).to_string();
    assert!(said_by(GXX, "page.cpp", cpp).is_none_or(|said| said == numbers));
}

/// The example's frames, written by it.
fn frames(program: PathBuf) -> Vec<u32> {
    let raw = FILES.folder.path().join("frames.raw");
    let said = said(command(program).env("RHYTID_DEVICE", "cpu:0").args([rig(), take(), &raw]));
    assert!(said.contains("20 frames of") && said.contains("cpu:0"), "{said}");
    let bytes = std::fs::read(raw).unwrap();
    bytes.chunks_exact(4).map(|b| u32::from_ne_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn the_example_plays_a_take_with_the_bits_of_rust() {
    let files = &*FILES;
    let options = AnimatorOptions { device: Some("cpu:0"), upload: UploadOptions::frames(20) };
    let mut animator = rhytid::animator(&files.rig, &options).unwrap();
    animator.evaluate(&files.take.handle_positions(&files.rig.handles().labels).unwrap()).unwrap();
    let mut positions = Vec::new();
    animator.read(Stage::Positions, &mut positions).unwrap();
    let expected: Vec<u32> = positions.iter().map(|x| x.to_bits()).collect();
    if let Some(program) = GCC.build(PLAY, &[]) {
        assert!(frames(program) == expected, "the example's frames are others");
    }
}

#[test]
fn the_example_has_sixty_lines() {
    let source = std::fs::read_to_string(own().join(PLAY)).unwrap();
    assert!(source.lines().count() <= 60, "{} lines", source.lines().count());
}

#[test]
fn the_example_says_what_is_wrong() {
    let Some(program) = GCC.build(PLAY, &["-DFOR_ERRORS"]) else { return };
    let output = command(program).args(["nowhere.safetensors", "take.csv"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(said.starts_with("error 2: nowhere.safetensors: "), "{said}");
}
