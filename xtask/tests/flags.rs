//! The library's texts name no flag and no command of the program, since another program may call the
//! library. `crates/cli/src/remedy.rs` says which flag remedies what.

use std::path::{Path, PathBuf};

/// Flags that belong to other programs, and these programs.
const OTHERS: [(&str, &str); 3] = [
    ("--features", "cargo's: a backend that was not built in takes another build"),
    ("--check", "`cargo xtask kernels --check`, which tells contributors how a table is checked"),
    ("--flatten", "usdcat's: what a USD file refers to is put into one file"),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The folders of the libraries' sources.
fn libraries() -> Vec<PathBuf> {
    let crates = std::fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let libraries = crates.filter(|path| path.file_name().is_some_and(|name| name != "cli"));
    libraries.chain([root().join("conformance")]).map(|path| path.join("src")).collect()
}

/// The program's commands: each has a file or a folder of its name.
fn commands() -> Vec<String> {
    let entries = std::fs::read_dir(root().join("crates/cli/src/cmd")).unwrap();
    let names =
        entries.map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned());
    names.filter(|name| name != "mod").map(|name| name.replace('_', "-")).collect()
}

/// The Rust files in a folder and below, except test files.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let is_test = path.file_stem().is_some_and(|stem| stem.to_string_lossy().starts_with("tests"));
        match path.is_dir() {
            _ if is_test => {}
            true => sources(&path, found),
            false if path.extension().is_some_and(|ending| ending == "rs") => found.push(path),
            false => {}
        }
    }
}

/// A text that people may read, and its line.
#[derive(Debug, PartialEq)]
struct Text<'a> {
    line: usize,
    text: &'a str,
}

/// The doc comments and the string literals of a source, up to its unit tests.
fn texts(source: &str) -> Vec<Text<'_>> {
    let end = source.find("#[cfg(test)]\nmod ").or_else(|| source.find("#[cfg(test)]\npub(crate) mod "));
    // A file with its tests in another file names their module earlier.
    let end = end.filter(|at| source[*at..].lines().nth(1).is_some_and(|line| line.ends_with('{')));
    let source = &source[..end.unwrap_or(source.len())];
    let mut texts = Vec::new();
    let mut at = 0;
    while at < source.len() {
        let rest = &source[at..];
        let (length, text) = token(rest);
        if let Some((from, to)) = text {
            let line = 1 + source[..at + from].matches('\n').count();
            texts.push(Text { line, text: &rest[from..to] });
        }
        at += length;
    }
    texts
}

/// The length of the first token of `rest`, as far as it matters here, and the range of a text in it.
fn token(rest: &str) -> (usize, Option<(usize, usize)>) {
    if rest.starts_with("//") {
        let length = rest.find('\n').unwrap_or(rest.len());
        let is_doc = rest.starts_with("//!") || rest.starts_with("///");
        return (length, is_doc.then_some((3, length)));
    }
    if let Some(comment) = rest.strip_prefix("/*") {
        let length = comment.find("*/").map_or(rest.len(), |end| end + 4);
        let is_doc = rest.starts_with("/*!") || rest.starts_with("/**");
        return (length, is_doc.then_some((2, length)));
    }
    if let Some(raw) = rest.strip_prefix('b').unwrap_or(rest).strip_prefix('r') {
        let hashes = raw.len() - raw.trim_start_matches('#').len();
        if raw[hashes..].starts_with('"') {
            let from = rest.len() - raw.len() + hashes + 1;
            let close = format!("\"{}", &raw[..hashes]);
            let to = rest[from..].find(&close).map_or(rest.len(), |end| from + end);
            return ((to + close.len()).min(rest.len()), Some((from, to)));
        }
    }
    if let Some(inside) = rest.strip_prefix('"') {
        let mut escaped = false;
        let end = inside.find(|c: char| {
            let ends = c == '"' && !escaped;
            escaped = c == '\\' && !escaped;
            ends
        });
        let to = end.map_or(rest.len(), |end| end + 1);
        return ((to + 1).min(rest.len()), Some((1, to)));
    }
    // A quote as a character literal.
    for quote in ["'\"'", "'\\\"'"] {
        if rest.starts_with(quote) {
            return (quote.len(), None);
        }
    }
    // An identifier in one piece, since its last letter begins no raw string.
    let word = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
    (word.max(rest.chars().next().map_or(1, char::len_utf8)), None)
}

/// The flags and commands that a text names.
fn named(text: &str, commands: &[String]) -> Vec<String> {
    let is_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    let mut found = Vec::new();
    for (at, _) in text.match_indices("--") {
        let name = &text[at + 2..];
        let name = &name[..name.find(|c| !is_name(c)).unwrap_or(name.len())];
        let begins = !text[..at].ends_with(|c: char| c == '-' || c.is_alphanumeric());
        if begins && name.len() > 1 && name.starts_with(|c: char| c.is_ascii_lowercase()) {
            found.push(format!("--{name}"));
        }
    }
    for (at, prefix) in text.match_indices("rhytid ") {
        let name = &text[at + prefix.len()..];
        let name = &name[..name.find(|c| !is_name(c)).unwrap_or(name.len())];
        if commands.iter().any(|command| command == name) {
            found.push(format!("rhytid {name}"));
        }
    }
    found.retain(|name| OTHERS.iter().all(|(other, _)| other != name));
    found
}

#[test]
fn no_text_of_a_library_names_a_flag_or_a_command_of_the_program() {
    let commands = commands();
    assert!(commands.len() > 20 && commands.iter().any(|name| name == "animate"), "{commands:?}");
    let mut files = Vec::new();
    libraries().iter().for_each(|folder| sources(folder, &mut files));
    assert!(files.len() > 300, "{}", files.len());
    let (mut count, mut faults) = (0, Vec::new());
    for file in files {
        let source = std::fs::read_to_string(&file).unwrap();
        for Text { line, text } in texts(&source) {
            count += 1;
            let names = named(text, &commands);
            faults.extend(names.into_iter().map(|name| format!("{}:{line}: {name}", file.display())));
        }
    }
    assert!(count > 10_000, "{count} texts");
    assert!(faults.is_empty(), "say it in the library's terms, with a Remedy:\n{}", faults.join("\n"));
}

#[test]
fn texts_are_doc_comments_and_literals() {
    let source =
        "//! one\nlet a = \"two\\\" \n2\"; // none\nlet r = br#\"three \" 3\"#; '\"'; /// four\nfor \"five\"";
    let found: Vec<(usize, &str)> = texts(source).iter().map(|t| (t.line, t.text)).collect();
    assert_eq!(found, [(1, " one"), (2, "two\\\" \n2"), (4, "three \" 3"), (4, " four"), (5, "five")]);
    assert_eq!(texts("\"a\"\n#[cfg(test)]\nmod tests {\n\"b\"").len(), 1);
    assert_eq!(texts("\"a\"\n#[cfg(test)]\nmod tests;\n\"b\"").len(), 2);
}

#[test]
fn flags_and_commands_are_found() {
    let named = |text| named(text, &["prepare".to_owned()]);
    assert_eq!(named("fewer frames (--frames), or `rhytid prepare`"), ["--frames", "rhytid prepare"]);
    assert_eq!(named("--max-error: with --features cpu"), ["--max-error"]);
    assert_eq!(named("a -- b, x--y, ---, rhytid --, rhytid prepared, that is rhytid's"), [""; 0]);
}
