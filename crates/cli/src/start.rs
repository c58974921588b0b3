//! How this program was started, and how it starts itself again.

use std::ffi::OsString;
use std::process::Command;
use std::sync::OnceLock;

/// The words of the command line, the program's name first.
static WORDS: OnceLock<Vec<OsString>> = OnceLock::new();

/// The words that start the program, for a process that is another program.
static STARTED_BY: OnceLock<Vec<OsString>> = OnceLock::new();

/// Says which words start this program, such as `python -m rhytid`. By default it is the executable of this
/// process. Only the first call counts.
pub fn started_by(words: Vec<OsString>) {
    let _ = STARTED_BY.set(words);
}

/// Keeps the words of the command line. Only the first call counts.
pub(crate) fn set_words(words: Vec<OsString>) {
    let _ = WORDS.set(words);
}

/// The words of the command line, the program's name first. Empty if there was no command line.
pub(crate) fn words() -> &'static [OsString] {
    WORDS.get().map_or(&[], Vec::as_slice)
}

/// The words after the program's name, as text.
pub(crate) fn arguments() -> Vec<String> {
    words().iter().skip(1).map(|word| word.to_string_lossy().into_owned()).collect()
}

/// The program's name as it was called.
pub(crate) fn name() -> String {
    words().first().map_or_else(|| "rhytid".to_owned(), |name| name.to_string_lossy().into_owned())
}

/// The command that starts this program again. `None` if nobody knows.
pub(crate) fn again() -> Option<Command> {
    if let Some((program, arguments)) = STARTED_BY.get().and_then(|words| words.split_first()) {
        let mut command = Command::new(program);
        command.args(arguments);
        return Some(command);
    }
    Some(Command::new(std::env::current_exe().ok()?))
}
