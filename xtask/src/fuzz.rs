//! `cargo xtask fuzz`: every fuzz target for a while, from the seeds that are kept in the repository.
use crate::run::{Result, command, output, root, run, succeeds};

/// Runs each target of `fuzz/` for `seconds`; stops at the first that finds something.
pub(crate) fn fuzz(seconds: u32) -> Result {
    if !succeeds(command("cargo", &["+nightly", "--version"])) {
        return Err("fuzzing needs the nightly toolchain: run `rustup toolchain install nightly`".into());
    }
    if !succeeds(command("cargo", &["+nightly", "fuzz", "--version"])) {
        return Err("fuzzing needs cargo-fuzz: run `cargo install cargo-fuzz`".into());
    }
    let list = output(command("cargo", &["+nightly", "fuzz", "list"])).unwrap_or_default();
    let targets: Vec<&str> = list.lines().filter(|line| !line.is_empty()).collect();
    if targets.is_empty() {
        return Err("`cargo fuzz list` names no target; is fuzz/Cargo.toml there?".into());
    }
    for target in &targets {
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
    println!("{} fuzz targets, {seconds} s each: nothing found", targets.len());
    Ok(())
}
