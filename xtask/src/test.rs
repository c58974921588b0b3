//! `cargo xtask test`: everything that must hold before a change lands.
use crate::programs::{Program, Runs, build};
use crate::run::{Result, cargo, root, run, succeeds};
use crate::steps::Steps;
use crate::{debian, deny, library, package, prose, setup};
use std::process::Command;

/// The whole workspace, for any of cargo's commands.
pub(crate) const WORKSPACE: [&str; 1] = ["--workspace"];

/// The test program that runs under Vulkan's validation layer. The layer keeps memory of its own. Tests for
/// leaking sessions therefore run in other programs without it.
const VALIDATED: &str = "devices";

/// The test program that runs at the same time as the others. It waits a lot: for the pages' last crate,
/// which one processor compiles, and for a browser.
const BESIDE: &str = "browser";

/// Makes every skipped test a failure. The tests read the variable too, and name the skipped one.
const FORBID_SKIPS: &str = "RHYTID_FORBID_SKIPS";

/// Sets up, then runs every check, and stops at the first step that fails. Prints the time of each step and
/// each test program.
pub(crate) fn test() -> Result {
    let mut steps = Steps::default();
    let mut runs = Runs::default();
    let outcome = all(&mut steps, &mut runs);
    steps.print();
    runs.print();
    runs.print_counts();
    outcome
}

fn all(steps: &mut Steps, runs: &mut Runs) -> Result {
    steps.step("setup", setup::setup)?;
    steps.step("format", format)?;
    steps.step("prose", prose::prose)?;
    steps.step("lints", lints)?;
    steps.step("documentation", documentation)?;
    steps.step("dependencies", deny::deny_where_installed)?;
    steps.step("runtime alone", library::runtime)?;
    let programs = steps.step("build tests", || build(&WORKSPACE))?;
    steps.step("tests", || tests(&programs, runs))?;
    steps.step("packages", package::package)
}

/// Runs every test program, and the documentation's examples.
fn tests(programs: &[Program], runs: &mut Runs) -> Result {
    for target in [VALIDATED, BESIDE] {
        if !programs.iter().any(|program| program.target == target) {
            return Err(format!("there is no test program named {target}"));
        }
    }
    let (beside, others): (Vec<_>, Vec<_>) = programs.iter().partition(|program| program.target == BESIDE);
    std::thread::scope(|scope| {
        let beside = scope.spawn(|| {
            let mut runs = Runs::default();
            run_each(&beside, &mut runs).map(|()| runs)
        });
        let outcome = run_each(&others, runs).and_then(|()| {
            runs.run("documentation's examples", cargo(&[&["test", "--doc"], &WORKSPACE[..]].concat()))
        });
        runs.append(beside.join().expect("what runs beside does not panic")?);
        outcome
    })?;
    outcome(runs)
}

/// Runs programs one after the other.
fn run_each(programs: &[&Program], runs: &mut Runs) -> Result {
    for program in programs {
        let mut command = program.command(&[]);
        with_drivers(&mut command);
        if program.target == VALIDATED {
            command.env("RHYTID_VULKAN_VALIDATION", "1");
        }
        runs.run(&program.name(), command)?;
    }
    Ok(())
}

/// Adds a second Vulkan driver to those that the loader finds. Compiled drivers are cached where the
/// program's own tests cache them.
fn with_drivers(command: &mut Command) {
    let target = root().join("target/tmp");
    command.env("VK_ADD_DRIVER_FILES", debian::SWIFTSHADER_ICD);
    command.env("MESA_SHADER_CACHE_DIR", &target).env("POCL_CACHE_DIR", target.join("pocl"));
}

/// Checks the formatting by `rustfmt.toml`.
pub(crate) fn format() -> Result {
    component("fmt", "rustfmt")?;
    run(cargo(&["fmt", "--all", "--check"])).map_err(|e| format!("{e}: run `cargo fmt --all`"))
}

/// Allows no warning of the compiler or Clippy, in any target.
pub(crate) fn lints() -> Result {
    component("clippy", "clippy")?;
    run(cargo(&[&["clippy"], &WORKSPACE[..], &["--all-targets", "--", "-D", "warnings"]].concat()))
}

/// Allows no warning of rustdoc, including broken links.
pub(crate) fn documentation() -> Result {
    // With the examples, dependencies have the same features as in the lints, which have compiled them.
    let targets = ["--lib", "--bins", "--examples"];
    let mut doc = cargo(&[&["doc", "--no-deps"], &WORKSPACE[..], &targets].concat());
    doc.env("RUSTDOCFLAGS", "-D warnings");
    run(doc)
}

/// A component of the Rust toolchain may be left out of an installation.
fn component(subcommand: &str, component: &str) -> Result {
    if succeeds(cargo(&[subcommand, "--version"])) {
        return Ok(());
    }
    Err(format!("`cargo {subcommand}` is missing: run `rustup component add {component}`"))
}

/// An error if tests failed, if none passed, or if some were skipped and none may be.
pub(crate) fn outcome(runs: &Runs) -> Result {
    let forbids_skips = std::env::var_os(FORBID_SKIPS).is_some_and(|value| !value.is_empty());
    match (runs.passed(), runs.failed(), runs.skipped()) {
        (_, failed @ 1.., _) => Err(format!("{failed} tests failed")),
        (0, ..) => Err("no test passed".into()),
        (_, _, skipped @ 1..) if forbids_skips => {
            Err(format!("{skipped} tests were skipped, and {FORBID_SKIPS} is set"))
        }
        _ => Ok(()),
    }
}
