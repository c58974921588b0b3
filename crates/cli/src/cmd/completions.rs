//! `rhytid completions`

use crate::{args, output};
use rhytid::{Error, Result};

/// Prints the completions.
///
/// # Errors
/// As [`output::line`].
pub(super) fn run(args: &args::Completions) -> Result<()> {
    // Into memory first: clap_complete panics where its writer fails.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut args::command(), "rhytid", &mut script);
    let script = String::from_utf8(script).map_err(|e| Error::Internal(e.to_string()))?;
    output::line(script.trim_end())
}
