//! `cargo xtask test`: everything that must hold before a change lands.
use crate::programs::{Program, Runs, build};
use crate::run::{Result, cargo, root, run, succeeds};
use crate::steps::Steps;
use crate::{debian, deny, library, package, prose, setup};
use std::collections::VecDeque;
use std::process::Command;
use std::sync::Mutex;

/// The whole workspace, for any of cargo's commands.
pub(crate) const WORKSPACE: [&str; 1] = ["--workspace"];

/// The test program that runs under Vulkan's validation layer. The layer keeps memory of its own. Tests for
/// leaking sessions therefore run in other programs without it.
const VALIDATED: &str = "devices";

/// The test program that runs first, with nothing beside it. It starts `target/debug/rhytid` some thousand
/// times, and some of its tests have time limits. The packages later replace that file by a slow one.
const ALONE: &str = "program";

/// The first of the programs that run beside others, because it takes longest: the pages in a browser.
const FIRST: &str = "browser";

/// How many of the other programs run at the same time. Some wait, and most end with one long test.
const LANES: usize = 2;

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
    steps.step("tests", || tests(&programs, runs))
}

/// A part of the tests that runs beside others.
enum Work<'a> {
    Program(&'a Program),
    Packages,
    DocumentationExamples,
}

/// Runs every test program, the packages and the documentation's examples.
fn tests(programs: &[Program], runs: &mut Runs) -> Result {
    let mut queue = queue(programs)?;
    if let Some(alone) = queue.pop_front() {
        alone.run(runs)?;
    }
    let queue = Mutex::new(queue);
    let mut outcomes: Vec<_> = std::thread::scope(|scope| {
        let lanes: Vec<_> = (0..LANES).map(|_| scope.spawn(|| lane(&queue))).collect();
        lanes.into_iter().map(|lane| lane.join().expect("a lane does not panic")).collect()
    });
    for (done, _) in &mut outcomes {
        runs.append(done);
    }
    outcomes.into_iter().try_for_each(|(_, outcome)| outcome)?;
    outcome(runs)
}

/// All work in the order in which it starts. The first runs alone.
fn queue(programs: &[Program]) -> Result<VecDeque<Work<'_>>> {
    let named = |target: &str| {
        let program = programs.iter().find(|program| program.target == target);
        program.ok_or_else(|| format!("there is no test program named {target}"))
    };
    named(VALIDATED)?;
    let first = [Work::Program(named(ALONE)?), Work::Program(named(FIRST)?), Work::Packages];
    let others = programs.iter().filter(|program| ![ALONE, FIRST].contains(&program.target.as_str()));
    let others = others.map(Work::Program).chain([Work::DocumentationExamples]);
    Ok(first.into_iter().chain(others).collect())
}

/// Takes work from the queue until nothing is left. If work cannot be done, nothing more starts.
fn lane(queue: &Mutex<VecDeque<Work<'_>>>) -> (Runs, Result) {
    let mut runs = Runs::default();
    let next = || queue.lock().expect("no lane panics").pop_front();
    while let Some(work) = next() {
        if let Err(error) = work.run(&mut runs) {
            queue.lock().expect("no lane panics").clear();
            return (runs, Err(error));
        }
    }
    (runs, Ok(()))
}

impl Work<'_> {
    fn run(&self, runs: &mut Runs) -> Result {
        match self {
            Self::Program(program) => {
                let mut command = program.command(&[]);
                with_drivers(&mut command);
                if program.target == VALIDATED {
                    command.env("RHYTID_VULKAN_VALIDATION", "1");
                }
                runs.run(&program.name(), command)
            }
            Self::Packages => runs.time("packages", package::package),
            Self::DocumentationExamples => {
                runs.run("documentation's examples", cargo(&[&["test", "--doc"], &WORKSPACE[..]].concat()))
            }
        }
    }
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
    // With an example, dependencies have the same features as in the lints, which have compiled them.
    let targets = ["--lib", "--bins", "--example", "101_solve"];
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
