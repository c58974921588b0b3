//! The options of `animate` that a job has, as words.

use super::job::relative;
use rhytid::{Error, Result};
use std::path::Path;

/// Options whose value is a file that every machine needs.
const FILES: [&str; 2] = ["--setup", "--shapes"];

/// The words of a text: separated by blanks, and in quotes with blanks.
///
/// # Errors
/// [`Error::Input`] for a quote that does not end.
pub(super) fn split(text: &str) -> Result<Vec<String>> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    for c in text.chars() {
        match quote {
            Some(end) if c == end => quote = None,
            Some(_) => word.get_or_insert_default().push(c),
            None if c == '"' || c == '\'' => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            None if c.is_whitespace() => words.extend(word.take()),
            None => word.get_or_insert_default().push(c),
        }
    }
    match quote {
        Some(quote) => Err(Error::input(format!("--animate {text}: {quote} has no end; add it"))),
        None => {
            words.extend(word);
            Ok(words)
        }
    }
}

/// The files that options name.
pub(super) fn files(words: &[String]) -> Vec<String> {
    let mut files = Vec::new();
    each_file(&mut words.to_vec(), |file| files.push(file.clone()));
    files
}

/// The words with files relative to `folder`, which is a whole path.
///
/// # Errors
/// [`Error::Io`] for a file that is not there.
pub(super) fn within(words: &[String], folder: &Path) -> Result<Vec<String>> {
    let mut words = words.to_vec();
    let mut first_error = Ok(());
    each_file(&mut words, |file| match relative(Path::new(file), folder) {
        Ok(path) => *file = path,
        Err(error) => first_error = Err(error),
    });
    first_error.map(|()| words)
}

/// The words with files that are relative to `folder`.
pub(super) fn from_folder(words: &[String], folder: &Path) -> Vec<String> {
    let mut words = words.to_vec();
    each_file(&mut words, |file| *file = folder.join(&*file).to_string_lossy().into_owned());
    words
}

/// Calls `change` with each file, in the two forms in which an option can have it. A number is no file:
/// `--shapes 40` is one.
fn each_file(words: &mut [String], mut change: impl FnMut(&mut String)) {
    let mut is_value = false;
    for word in words {
        if is_value {
            is_value = false;
            if word.parse::<f64>().is_err() {
                change(word);
            }
            continue;
        }
        is_value = FILES.contains(&word.as_str());
        if let Some((option, value)) = word.split_once('=')
            && FILES.contains(&option)
            && value.parse::<f64>().is_err()
        {
            let mut value = value.to_owned();
            change(&mut value);
            *word = format!("{option}={value}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blanks_separate_words_unless_they_are_in_quotes() {
        let words = split("  --fps 24 --setup 'a b.toml'  --wrinkle-group \"x=a b\"c ''").unwrap();
        assert_eq!(words, ["--fps", "24", "--setup", "a b.toml", "--wrinkle-group", "x=a bc", ""]);
        assert!(split("").unwrap().is_empty());
        let error = split("--setup 'a").unwrap_err().to_string();
        assert!(error.contains("' has no end"), "{error}");
    }

    #[test]
    fn files_are_found_in_both_forms() {
        let words = split("--shapes 40 --setup=x/a.toml --fps 24 --shapes arkit.glb --shapes=4").unwrap();
        assert_eq!(files(&words), ["x/a.toml", "arkit.glb"]);
        let there = from_folder(&words, Path::new("/t"));
        assert_eq!(
            there[2..],
            ["--setup=/t/x/a.toml", "--fps", "24", "--shapes", "/t/arkit.glb", "--shapes=4"]
        );
    }
}
