//! The program `rhytid` as a library, for programs that carry its commands. The Python package is one.
//!
//! [`run`] is the whole program. [`call`] runs a single command for a caller that is a program: the result is
//! a value, and progress and warnings go to the caller.
//!
//! ```
//! use rhytid::NoProgress;
//! use std::sync::Arc;
//!
//! let device = rhytid_cli::call(vec!["info".into(), "not-there.safetensors".into()], Arc::new(NoProgress));
//! assert!(matches!(device, Err(rhytid::Error::Io { .. })));
//! ```
#![forbid(unsafe_code)]

mod animation;
mod args;
mod call;
mod cmd;
mod drawing;
mod exit;
mod exit_code;
mod guard;
mod inputs;
mod interrupt;
mod limits;
mod memory;
mod option_list;
mod output;
mod progress;
mod quiet_drivers;
mod remedy;
mod scheduler;
mod start;

pub use animation::Animation;
pub use call::{Caller, call, open_face};
pub use exit::sentence;
pub use option_list::option_list;
pub use quiet_drivers::restart_if_needed;
pub use remedy::of_warning;
pub use start::started_by;

use std::ffi::OsString;
use std::sync::Arc;

/// Runs the program with these words of a command line, the program's name first. Returns the exit code: 0
/// when it is done, 1 for a fault of Rhytid or of a device, 2 for a mistake of the user.
///
/// It installs handlers for panics, for Ctrl-C and for the log, and ends the process where the command line
/// is wrong or asks for help. So it is for a process that does nothing else.
pub fn run(words: Vec<OsString>) -> u8 {
    start::set_words(words);
    limits::run(program)
}

fn program() -> u8 {
    exit::install_panic_hook();
    let args = args::Args::read(start::words());
    let ui = Arc::new(progress::Ui::new(args.quiet, args.verbose > 0));
    progress::install_logger(&ui, args.quiet, args.verbose);
    interrupt::install(&ui);
    rhytid::core::protect_inputs();
    exit::status(&ui, || cmd::run(&args, &ui))
}
