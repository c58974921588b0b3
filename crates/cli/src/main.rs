//! `rhytid`: from face scans and marker tracks to detailed facial animation.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    rhytid_cli::restart_if_needed();
    ExitCode::from(rhytid_cli::run(std::env::args_os().collect()))
}
