//! Single commands for a caller that is a program: a value in place of lines, and the caller's own progress.

use crate::args::{Args, Command, command};
use crate::progress::Ui;
use crate::{cmd, inputs, output};
use rhytid::formats::Reach;
use rhytid::{Error, Face, Progress, Result};
use serde_json::Value;
use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;

/// The receiver of progress and warnings, which also stops the work. It outlives a caller that no longer
/// waits.
pub type Caller = Arc<dyn Progress + Send + Sync>;

/// Runs a command with these words, which follow the program's name. Returns what the command prints with
/// `--json`. docs/cli.md lists the keys. A result that is not as it should be, such as that of `verify` for a
/// changed file, is a value too.
///
/// # Errors
/// [`Error::Input`] for words that are no command line, or if the command has no `--json`. Otherwise as the
/// command.
pub fn call(mut words: Vec<OsString>, caller: Caller) -> Result<Value> {
    words.push("--json".into());
    let args = parse(words)?;
    let ui = Ui::for_program(caller);
    let printed = output::captured(|| cmd::run(&args, &ui).map(|_| ()))?;
    serde_json::from_str(&printed).map_err(|error| Error::Internal(format!("{error} in {printed}")))
}

/// The face of a project file, as the commands read it.
///
/// # Errors
/// As [`rhytid::transfer::read_face`].
pub fn open_face(path: &Path, reach: Reach, caller: Caller) -> Result<Face> {
    inputs::face(path, reach, &Ui::for_program(caller))
}

/// The command line of these words, which follow the program's name.
///
/// # Errors
/// [`Error::Input`] with what is wrong.
pub(crate) fn parse(words: Vec<OsString>) -> Result<Args> {
    use clap::FromArgMatches;
    let words = std::iter::once("rhytid".into()).chain(words);
    let matches = command().try_get_matches_from(words);
    matches.and_then(|matches| Args::from_arg_matches(&matches)).map_err(|error| {
        let text = error.to_string();
        // What is wrong, and perhaps a tip. Then comes how a command line looks.
        let sentences = text.split("\n\n").take_while(|part| !part.starts_with("Usage:"));
        let words = |part: &str| part.split_whitespace().collect::<Vec<_>>().join(" ");
        let sentences: Vec<String> = sentences.take(2).map(words).collect();
        Error::input(sentences.join("; ").trim_start_matches("error: "))
    })
}

/// The options of `animate`.
///
/// # Errors
/// As [`parse`].
pub(crate) fn parse_animate(words: Vec<OsString>) -> Result<Box<crate::args::Animate>> {
    match parse(words)?.command {
        Command::Animate(args) => Ok(args),
        _ => Err(Error::Internal("the words are another command".into())),
    }
}

/// The options of `render`.
///
/// # Errors
/// As [`parse`].
#[cfg(feature = "wgpu")]
pub(crate) fn parse_render(words: Vec<OsString>) -> Result<Box<crate::args::Render>> {
    match parse(words)?.command {
        Command::Render(args) => Ok(args),
        _ => Err(Error::Internal("the words are another command".into())),
    }
}
