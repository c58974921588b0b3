//! `rhytid`: from face scans and marker tracks to detailed facial animation.
#![forbid(unsafe_code)]

mod args;
mod cmd;
mod drawing;
mod exit;
mod exit_code;
mod guard;
mod inputs;
mod interrupt;
mod limits;
mod memory;
mod output;
mod progress;
mod quiet_drivers;
mod remedy;

use std::process::ExitCode;
use std::sync::Arc;

fn main() -> ExitCode {
    quiet_drivers::restart_if_needed();
    limits::run(program)
}

fn program() -> ExitCode {
    exit::install_panic_hook();
    let args = args::Args::read();
    let ui = Arc::new(progress::Ui::new(args.quiet, args.verbose > 0));
    progress::install_logger(&ui, args.quiet, args.verbose);
    interrupt::install(&ui);
    exit::status(&ui, || cmd::run(&args, &ui))
}
