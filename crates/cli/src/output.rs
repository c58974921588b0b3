//! Standard output.

use crate::args::Json;
use crate::progress::Ui;
use rhytid::core::AtomicFile;
use rhytid::{Error, InputErrorKind, Result};
use serde::Serialize;
use std::borrow::Cow;
use std::cell::RefCell;
use std::io::{self, ErrorKind, Write};
use std::path::Path;
use std::path::PathBuf;

/// Characters that make a line look like another one.
const DIRECTIONS: [char; 9] = [
    '\u{202a}', '\u{202b}', '\u{202c}', '\u{202d}', '\u{202e}', '\u{2066}', '\u{2067}', '\u{2068}',
    '\u{2069}',
];

/// The name of the project that `new` writes, and so of its rig.
const USUAL: &str = "face";

/// Writes `text`, made [`harmless`], and a line end to standard output. A reader that went away (`| head`) is
/// no error.
///
/// # Errors
/// [`Error::Io`] if standard output cannot be written: a full disk behind `>`.
pub(crate) fn say(text: &str) -> Result<()> {
    line(&harmless(text))
}

/// Writes a value as indented JSON to standard output.
///
/// # Errors
/// As [`say`].
pub(crate) fn json(value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value).map_err(|e| Error::Internal(e.to_string()))?;
    // Characters below a space are escaped already. Outside of strings JSON is ASCII.
    line(&escaped(&text, |c| format!("\\u{:04x}", u32::from(c))))
}

/// Ends a command with what it did: as JSON if the user asks for it, else as text, and not with `--quiet`.
///
/// # Errors
/// As [`say`].
pub(crate) fn done(json: Json, ui: &Ui, value: &impl Serialize, text: impl FnOnce() -> String) -> Result<()> {
    match (json.wanted, ui.is_quiet()) {
        (true, _) => self::json(value),
        (false, true) => Ok(()),
        (false, false) => say(&text()),
    }
}

/// The lines that say which commands come next. A build without a window does not name `view`.
pub(crate) fn next(commands: &[String]) -> String {
    let is_there = |command: &&String| cfg!(feature = "view") || !command.contains("rhytid view ");
    let lines = commands.iter().filter(is_there).map(|command| format!("\n  {command}"));
    format!("\nNext:{}", lines.collect::<String>())
}

/// Names in one line: all with `--verbose`, else the first few and the number of the others.
pub(crate) fn names(names: &[String], ui: &Ui) -> String {
    const SHOWN: usize = 6;
    if ui.is_verbose() || names.len() <= SHOWN {
        return names.join(", ");
    }
    format!("{} and {} more", names[..SHOWN].join(", "), names.len() - SHOWN)
}

/// The heading of a report: `name`, that of the face in `file`. If this is only the name that every project
/// has, it is the name of the folder.
pub(crate) fn title(file: &Path, name: &str) -> String {
    if name != USUAL {
        return name.to_owned();
    }
    let whole = file.canonicalize().unwrap_or_default();
    let folder = whole.parent().and_then(Path::file_name);
    folder.map_or_else(|| name.to_owned(), |folder| folder.to_string_lossy().into_owned())
}

/// A path as a word of a shell's command line.
pub(crate) fn word(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+:\\~".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) { text } else { format!("\"{text}\"") }
}

/// `text` without characters that a terminal would obey. Of control characters only line ends stay. A name in
/// a file can hold any of them.
pub(crate) fn harmless(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c.escape_default().to_string())
}

fn escaped(text: &str, escape: impl Fn(char) -> String) -> Cow<'_, str> {
    let is_harmful = |c: char| c.is_control() && c != '\n' || DIRECTIONS.contains(&c);
    if !text.contains(is_harmful) {
        return Cow::Borrowed(text);
    }
    Cow::Owned(text.chars().map(|c| if is_harmful(c) { escape(c) } else { c.to_string() }).collect())
}

thread_local! {
    /// The lines for a program that calls a command; `None` where standard output gets them.
    static CAPTURED: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Runs a command and returns its lines, in place of writing them to standard output.
///
/// # Errors
/// The command's.
pub(crate) fn captured(command: impl FnOnce() -> Result<()>) -> Result<String> {
    CAPTURED.set(Some(String::new()));
    let result = command();
    let lines = CAPTURED.take().unwrap_or_default();
    result.map(|()| lines)
}

/// Writes a line unchanged: a script for a shell.
pub(crate) fn line(text: &str) -> Result<()> {
    let is_captured = CAPTURED.with_borrow_mut(|captured| match captured {
        Some(lines) => {
            lines.push_str(text);
            lines.push('\n');
            true
        }
        None => false,
    });
    if is_captured {
        return Ok(());
    }
    let mut out = io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        result => result.map_err(Error::io(Path::new("standard output"))),
    }
}

/// Writes a file, whole.
///
/// # Errors
/// [`Error::Io`].
pub(crate) fn file(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut file = AtomicFile::create(path)?;
    file.write_all(bytes).map_err(file.error())?;
    file.finish()
}

/// Whether a file is missing and has to be written. A file that is there already stays.
///
/// # Errors
/// [`Error::Input`] if the file is there and `has_same` does not find the content in it.
pub(crate) fn is_missing(path: &Path, has_same: impl FnOnce() -> Result<bool>) -> Result<bool> {
    if path.symlink_metadata().is_err() {
        return Ok(true);
    }
    match has_same() {
        Ok(true) => Ok(false),
        _ => Err(Error::input(format!(
            "{}: is there already, with something else in it; choose another folder, or move it away",
            path.display()
        ))
        .of_kind(InputErrorKind::WouldOverwrite { file: path.to_owned() })),
    }
}

/// Rows of cells as a table whose columns are aligned; the last column is not padded.
pub(crate) fn table<const N: usize>(rows: &[[String; N]]) -> String {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; N] = std::array::from_fn(width);
    let line = |row: &[String; N]| {
        let mut line = String::new();
        for (cell, width) in row.iter().zip(widths) {
            line += cell;
            // Padded by hand: a format's width is limited, and a cell from a file can be longer.
            line.extend(std::iter::repeat_n(' ', width + 2 - cell.chars().count()));
        }
        line.trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// The place of a frame's number in the name of a file for each frame.
pub(crate) const FRAME: &str = "{frame}";

/// The name of a frame's file.
pub(crate) fn numbered(name: &str, frame: usize) -> PathBuf {
    PathBuf::from(name.replace(FRAME, &format!("{frame:05}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_has_the_name_of_the_rig_or_of_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let project = folder.path().join("anna").join("face.toml");
        std::fs::create_dir(project.parent().unwrap()).unwrap();
        std::fs::write(&project, "").unwrap();
        assert_eq!(title(&project, "face"), "anna");
        assert_eq!(title(&project, "Ben"), "Ben");
        // A file that is not there has the name alone.
        assert_eq!(title(Path::new("/nowhere/face.toml"), "face"), "face");
    }

    #[test]
    fn few_names_are_shown_unless_more_are_asked_for() {
        let labels: Vec<String> = (0..9).map(|i| i.to_string()).collect();
        assert_eq!(names(&labels, &Ui::new(false, false)), "0, 1, 2, 3, 4, 5 and 3 more");
        assert_eq!(names(&labels, &Ui::new(false, true)), "0, 1, 2, 3, 4, 5, 6, 7, 8");
        assert_eq!(names(&labels[..6], &Ui::new(false, false)), "0, 1, 2, 3, 4, 5");
    }

    #[test]
    fn names_with_blanks_are_quoted() {
        assert_eq!(word(Path::new("a b/face.usd")), "\"a b/face.usd\"");
        assert_eq!(word(Path::new("a/face-1.usd")), "a/face-1.usd");
    }

    #[test]
    fn what_a_terminal_would_obey_is_escaped() {
        let plain = "Gesicht „Ö“ 顔\n  1.5 mm";
        assert!(matches!(harmless(plain), Cow::Borrowed(text) if text == plain));
        let said = harmless("a\u{1b}[2Jb\rc\u{7}\u{9b}0m\td\u{202e}e");
        assert_eq!(said, r"a\u{1b}[2Jb\rc\u{7}\u{9b}0m\td\u{202e}e");
    }
}
