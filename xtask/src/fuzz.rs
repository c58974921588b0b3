//! `cargo xtask fuzz`: every fuzz target for a while, from the seeds in the repository.
use crate::run::{Result, command, output, root, run, succeeds};
use std::time::{Duration, Instant};

/// Runs each target of `fuzz/` for `seconds`, once or in turns for `hours`. Stops at the first finding.
pub(crate) fn fuzz(seconds: u32, hours: Option<u32>) -> Result {
    install()?;
    let list = output(command("cargo", &["+nightly", "fuzz", "list"])).unwrap_or_default();
    let targets: Vec<&str> = list.lines().filter(|line| !line.is_empty()).collect();
    if targets.is_empty() {
        return Err("`cargo fuzz list` names no target; is fuzz/Cargo.toml there?".into());
    }
    let start = Instant::now();
    let wanted = hours.map_or(Duration::ZERO, |hours| Duration::from_secs(3600 * u64::from(hours)));
    let mut turns = 0;
    while turns == 0 || start.elapsed() < wanted {
        turn(&targets, seconds)?;
        turns += 1;
    }
    println!("{} fuzz targets, {turns} times {seconds} s each: nothing found", targets.len());
    Ok(())
}

/// The nightly compiler and cargo-fuzz, if they are not there yet.
fn install() -> Result {
    if !succeeds(command("cargo", &["+nightly", "--version"])) {
        run(command("rustup", &["toolchain", "install", "nightly", "--profile", "minimal"]))
            .map_err(|e| format!("{e}: fuzzing needs the nightly compiler, which comes by rustup"))?;
    }
    if !succeeds(command("cargo", &["+nightly", "fuzz", "--version"])) {
        run(command("cargo", &["install", "cargo-fuzz", "--locked"]))?;
    }
    Ok(())
}

/// Each target once. The next turn begins with the inputs that this one finds.
fn turn(targets: &[&str], seconds: u32) -> Result {
    for target in targets {
        let corpus = root().join("fuzz/corpus").join(target);
        std::fs::create_dir_all(&corpus).map_err(|e| format!("{}: {e}", corpus.display()))?;
        let mut fuzz = command("cargo", &["+nightly", "fuzz", "run", target]);
        fuzz.arg(&corpus);
        let seeds = root().join("fuzz/seeds").join(target);
        if seeds.is_dir() {
            fuzz.arg(&seeds);
        }
        fuzz.args(["--", &format!("-max_total_time={seconds}")]);
        run(fuzz).map_err(|e| format!("{e}: the input that did it lies under fuzz/artifacts/{target}"))?;
    }
    Ok(())
}
