//! `rhytid`: from face scans and marker tracks to detailed facial animation.
#![forbid(unsafe_code)]

mod args;
mod bake;
mod cmd;
mod device_choice;
mod evaluator;
mod exit;
mod fade;
mod frames;
mod interrupt;
mod memory;
mod output;
mod pipeline;
mod player;
mod progress;
mod takes;
mod velocities;

use clap::Parser;
use std::process::ExitCode;
use std::sync::Arc;

fn main() -> ExitCode {
    exit::install_panic_hook();
    let args = args::Args::parse();
    let ui = Arc::new(progress::Ui::new(args.quiet));
    progress::install_logger(&ui, args.quiet, args.verbose);
    interrupt::install(&ui);
    exit::status(&ui, || cmd::run(&args, &ui))
}
