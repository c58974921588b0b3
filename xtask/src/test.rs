//! `cargo xtask test`: everything that must hold before a change lands.
use crate::run::{Result, cannot_run, cargo, root, run, shown, succeeds};
use crate::{debian, kernels, setup};
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Sets up, then runs every check, stopping at the first that fails; prints the time of each.
pub fn test() -> Result {
    let mut times: Vec<(&str, Duration)> = Vec::new();
    let mut counts = None;
    let outcome = (|| {
        let mut step = |name: &'static str, work: &mut dyn FnMut() -> Result| {
            eprintln!("\n── {name}");
            let start = Instant::now();
            let outcome = work();
            times.push((name, start.elapsed()));
            outcome
        };
        step("setup", &mut setup::setup)?;
        step("format", &mut || {
            component("fmt", "rustfmt")?;
            run(cargo(&["fmt", "--all", "--check"])).map_err(|e| format!("{e}: run `cargo fmt --all`"))
        })?;
        step("kernels", &mut || kernels::kernels(true))?;
        step("lints", &mut || {
            component("clippy", "clippy")?;
            let clippy = ["clippy", "--workspace", "--all-targets"];
            run(cargo(&[&clippy[..], &["--", "-D", "warnings"]].concat()))
        })?;
        step("wasm", &mut || {
            run(cargo(&["check", "--package", "rhytid-backend-wgpu", "--target", setup::WASM]))
        })?;
        step("tests", &mut || {
            let mut tests = cargo(&["test", "--workspace", "--no-fail-fast"]);
            // A second Vulkan driver, beside those that the loader finds by itself.
            tests.env("VK_ADD_DRIVER_FILES", debian::SWIFTSHADER_ICD);
            let found = run_tests(tests)?;
            let failed = found.failed;
            counts = Some(found);
            if failed > 0 { Err(format!("{failed} tests failed")) } else { Ok(()) }
        })?;
        // The layer keeps memory of its own, so that sessions do not leak is for the tests above to say.
        step("validation", &mut || {
            let test = ["test", "--workspace", "--test", "devices"];
            let mut tests = cargo(&[&test[..], &["--", "--quiet", "[vulkan/"]].concat());
            tests.env("VK_ADD_DRIVER_FILES", debian::SWIFTSHADER_ICD).env("RHYTID_VULKAN_VALIDATION", "1");
            run_tests(tests).and_then(|found| match found.failed {
                0 => Ok(()),
                failed => Err(format!("{failed} tests failed under Vulkan's validation layer")),
            })
        })?;
        step("documentation", &mut || {
            let mut doc = cargo(&["doc", "--workspace", "--no-deps"]);
            doc.env("RUSTDOCFLAGS", "-D warnings");
            run(doc)
        })
    })();

    println!();
    for (name, time) in &times {
        println!("{name:>15} {:7.1} s", time.as_secs_f64());
    }
    if !root().join("../shared").is_dir() {
        println!("\n!! There is no ../shared: the golden and real-data tests were SKIPPED.");
    }
    if let Some(Counts { passed, failed, ignored }) = counts {
        println!("\ntests: {passed} passed, {failed} failed, {ignored} skipped");
    }
    outcome
}

/// A component of the Rust toolchain may be left out of an installation.
fn component(subcommand: &str, component: &str) -> Result {
    if succeeds(cargo(&[subcommand, "--version"])) {
        return Ok(());
    }
    Err(format!("`cargo {subcommand}` is missing: run `rustup component add {component}`"))
}

/// Tests over all test programs.
#[derive(Default)]
struct Counts {
    passed: u64,
    failed: u64,
    ignored: u64,
}

/// Runs `cargo test`, passing its output on, and adds up its closing lines.
fn run_tests(mut command: Command) -> Result<Counts> {
    let shown = shown(&command);
    eprintln!("$ {shown}");
    let mut child = command.stdout(Stdio::piped()).spawn().map_err(|e| cannot_run(&shown, &e))?;
    let stdout = child.stdout.take().ok_or("cargo's output is not a pipe")?;
    let mut counts = Counts::default();
    for line in BufReader::new(stdout).lines() {
        let line = line.map_err(|e| format!("`{shown}`: {e}"))?;
        println!("{line}");
        if let Some(summary) = line.strip_prefix("test result: ") {
            counts.passed += count(summary, "passed");
            counts.failed += count(summary, "failed");
            counts.ignored += count(summary, "ignored");
        }
    }
    let status = child.wait().map_err(|e| format!("`{shown}`: {e}"))?;
    // Failed tests are the caller's to report; a program that did not build or crashed is not among them.
    if !status.success() && counts.failed == 0 {
        return Err(format!("`{shown}` failed ({status})"));
    }
    if counts.passed == 0 {
        return Err(format!("`{shown}` passed no test"));
    }
    Ok(counts)
}

/// The number before `word` in `ok. 12 passed; 0 failed; 1 ignored; …`.
fn count(summary: &str, word: &str) -> u64 {
    let words: Vec<&str> = summary.split([' ', ';']).filter(|w| !w.is_empty()).collect();
    words.windows(2).find(|pair| pair[1] == word).and_then(|pair| pair[0].parse().ok()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::count;

    #[test]
    fn counts_are_read_from_a_closing_line() {
        let line = "FAILED. 12 passed; 3 failed; 1 ignored; 0 measured; 7 filtered out; finished in 0.52s";
        assert_eq!(["passed", "failed", "ignored"].map(|word| count(line, word)), [12, 3, 1]);
        assert_eq!(count("ok.", "passed"), 0);
    }
}
