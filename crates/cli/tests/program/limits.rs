//! Too small a stack, too few threads, too little memory: the work is done, or one sentence gives the reason.

use crate::common::{Fixture, list};
use std::process::{Command, Output};

const SOLVE: &str = "solve face.toml -o face.safetensors";

fn limited(f: &Fixture, script: &str) -> Output {
    let program = env!("CARGO_BIN_EXE_rhytid");
    let script = format!("{script} {program} {SOLVE}");
    let mut shell = Command::new("sh");
    // A backtrace is only for users who ask for one.
    shell.args(["-c", &script]).current_dir(f.path(".")).env_remove("RUST_BACKTRACE").output().unwrap()
}

#[test]
fn a_small_stack_is_enough() {
    let f = Fixture::new();
    let output = limited(&f, "ulimit -s 64; exec");
    assert!(output.status.success(), "{output:?}");
}

#[test]
fn a_system_that_refuses_threads_is_named() {
    let f = Fixture::new();
    // The superuser may start any number.
    let is_root = Command::new("id").arg("-u").output().unwrap().stdout == b"0\n";
    let mut refused = 0;
    for most in 0..8 {
        let output = match is_root {
            true => limited(&f, &format!("exec setpriv --reuid 65533 --clear-groups prlimit --nproc={most}")),
            false => limited(&f, &format!("ulimit -u {most}; exec")),
        };
        let said = String::from_utf8_lossy(&output.stderr);
        if said.contains("a thread cannot be started: ") {
            assert_eq!(output.status.code(), Some(2), "{said}");
            assert_eq!(said.matches("error: ").count(), 1, "{said}");
            assert!(said.contains("`ulimit -u`") && !said.contains("panicked"), "{said}");
            refused += 1;
        }
    }
    assert!(refused > 0, "no number of threads was too small");
}

/// Rust ends a program without free memory: with a line, and without a half-written file.
#[test]
fn without_memory_nothing_is_left_behind() {
    let f = Fixture::with_side(61);
    f.write("face.safetensors", "precious");
    let before = list(&f.path("."));
    let mut stopped = 0;
    for kilobytes in (20_000..200_000).step_by(15_000) {
        let output = limited(&f, &format!("ulimit -v {kilobytes}; exec"));
        if output.status.success() {
            break;
        }
        stopped += 1;
        assert_eq!(list(&f.path(".")), before, "{output:?}");
        assert_eq!(f.read_text("face.safetensors"), "precious");
    }
    assert!(stopped > 1, "no memory was too small");
}
