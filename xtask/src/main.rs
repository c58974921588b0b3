//! The project's chores: `cargo xtask setup | test | fuzz`, one file each.
#![forbid(unsafe_code)]

mod fuzz;
mod run;
mod setup;
mod test;

use clap::Parser;
use std::process::ExitCode;

/// The project's chores.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
enum Chore {
    /// Install what the tests need (Python packages, a glTF validator) into target/.
    Setup,
    /// Set up, then check formatting, lints, tests and documentation.
    Test,
    /// Run every fuzz target for a while.
    Fuzz {
        /// How long each target runs.
        #[arg(long, value_name = "S", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..))]
        seconds: u32,
    },
}

fn main() -> ExitCode {
    let outcome = match Chore::parse() {
        Chore::Setup => setup::setup(),
        Chore::Test => test::test(),
        Chore::Fuzz { seconds } => fuzz::fuzz(seconds),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
