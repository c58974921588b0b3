//! `cargo xtask prose`: measures sentences, lines and table cells in pages and doc comments, and finds house
//! words.

mod markdown;

use crate::run::{Result, command, output, root};
use markdown::{Part, parts, sentences, words};
use std::collections::BTreeMap;
use std::fs;

/// Largest number of words in a sentence.
const SENTENCE: usize = 35;
/// Largest mean number of words in a sentence, over a page or over a crate's doc comments.
const MEAN: f64 = 20.0;
/// Largest number of words in a table's cell.
const CELL: usize = 15;
/// Largest number of characters in a page's line. Tables, code and addresses may be longer.
const PAGE_LINE: usize = 120;
/// Largest number of characters in a comment's line: `max_width` in `rustfmt.toml`.
const COMMENT_LINE: usize = 110;
/// Largest number of entries in the glossary.
const ENTRIES: usize = 40;
const GLOSSARY: &str = "docs/glossary.md";

/// Words that only this house uses, and the field's words for them.
const HOUSE_WORDS: &[HouseWord] = &[
    HouseWord { word: "canary", say: "mutant" },
    HouseWord { word: "canaries", say: "mutants" },
    HouseWord { word: "twin", say: "reference" },
    HouseWord { word: "twins", say: "references" },
];

struct HouseWord {
    word: &'static str,
    say: &'static str,
}

/// A text with its findings so far.
#[derive(Default)]
struct Report {
    /// The figures of each page, and of each crate's doc comments.
    figures: BTreeMap<String, Figures>,
    /// The findings, each with its place.
    findings: Vec<String>,
}

/// Lengths of sentences.
#[derive(Default)]
struct Figures {
    sentences: usize,
    words: usize,
    longest: usize,
}

impl Figures {
    fn mean(&self) -> f64 {
        self.words as f64 / self.sentences.max(1) as f64
    }
}

/// Prints the figures of every page and of every crate's doc comments.
///
/// # Errors
/// Something is longer than allowed, or uses a house word. All places are printed.
pub(crate) fn prose() -> Result {
    let files = output(command("git", &["ls-files", "*.md", "*.rs"])).ok_or("`git ls-files` failed")?;
    let mut report = Report::default();
    for file in files.lines() {
        let text = fs::read_to_string(root().join(file)).map_err(|e| format!("{file}: {e}"))?;
        match file.ends_with(".md") {
            true => report.page(file, &text),
            false => report.comments(file, &text),
        }
    }
    report.finish()
}

impl Report {
    /// A page of Markdown.
    fn page(&mut self, file: &str, text: &str) {
        self.text(file, file, text, 1);
        for line in markdown::long_lines(text, PAGE_LINE) {
            self.findings.push(format!("{file}:{line}: more than {PAGE_LINE} characters"));
        }
        let entries = text.lines().filter(|line| line.starts_with("- **")).count();
        if file == GLOSSARY && entries > ENTRIES {
            self.findings.push(format!("{file}: {entries} entries, expected at most {ENTRIES}"));
        }
    }

    /// The doc comments of a file, and the lines of all its comments.
    fn comments(&mut self, file: &str, text: &str) {
        let name = crate_folder(file);
        let mut block = String::new();
        let mut first = 0;
        let mut is_code = false;
        // One more line, to end the last block.
        for (number, line) in (1..).zip(text.lines().chain([""])) {
            let line = line.trim_end();
            let comment = line.trim_start();
            let doc =
                comment.strip_prefix("///").or_else(|| comment.strip_prefix("//!")).map(str::trim_start);
            let is_table = doc.is_some_and(|doc| doc.starts_with('|'));
            is_code = match doc {
                Some(doc) if doc.starts_with("```") => !is_code,
                Some(_) => is_code,
                None => false,
            };
            let may_be_long = is_code || is_table || line.contains("http");
            if comment.starts_with("//") && !may_be_long && line.chars().count() > COMMENT_LINE {
                self.findings.push(format!("{file}:{number}: more than {COMMENT_LINE} characters"));
            }
            let doc = comment.strip_prefix("///").or_else(|| comment.strip_prefix("//!"));
            match doc {
                Some(doc) => {
                    if block.is_empty() {
                        first = number;
                    }
                    block += doc.strip_prefix(' ').unwrap_or(doc);
                    block.push('\n');
                }
                None if block.is_empty() => {}
                None => self.text(file, &name, &std::mem::take(&mut block), first),
            }
        }
    }

    /// Markdown that begins at line `first` of a file. Its sentences count for `name`.
    fn text(&mut self, file: &str, name: &str, text: &str, first: usize) {
        let figures = self.figures.entry(name.to_owned()).or_default();
        for Part { text, line, is_cell } in parts(text) {
            let place = format!("{file}:{}", first + line);
            let mut find = |what: String| self.findings.push(format!("{place}: {what}"));
            for HouseWord { word, say } in HOUSE_WORDS {
                if words(&text).any(|said| said.eq_ignore_ascii_case(word)) {
                    find(format!("“{word}”, say “{say}”"));
                }
            }
            if is_cell {
                let count = words(&text).count();
                if count > CELL {
                    find(format!("a cell of {count} words, expected at most {CELL}"));
                }
                continue;
            }
            for sentence in sentences(&text) {
                let count = words(sentence).count();
                figures.sentences += 1;
                figures.words += count;
                figures.longest = figures.longest.max(count);
                if count > SENTENCE {
                    find(format!("a sentence of {count} words, expected at most {SENTENCE}"));
                }
            }
        }
    }

    fn finish(mut self) -> Result {
        println!("sentences    mean  longest");
        for (name, figures) in self.figures.iter().filter(|(_, figures)| figures.sentences > 0) {
            let mean = figures.mean();
            println!("{:9}  {mean:6.1}  {:7}  {name}", figures.sentences, figures.longest);
            if mean > MEAN {
                self.findings
                    .push(format!("{name}: {mean:.1} words a sentence on average, expected at most {MEAN}"));
            }
        }
        if self.findings.is_empty() {
            return Ok(());
        }
        for finding in &self.findings {
            println!("{finding}");
        }
        Err(format!("{} places are hard to read: CONTRIBUTING.md says how we write", self.findings.len()))
    }
}

/// The folder of a file's crate.
fn crate_folder(file: &str) -> String {
    let mut folders = file.split('/');
    match (folders.next(), folders.next()) {
        (Some("crates"), Some(name)) => format!("crates/{name}"),
        (Some(name), _) => name.to_owned(),
        _ => file.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn findings(file: &str, text: &str) -> Vec<String> {
        let mut report = Report::default();
        match file.ends_with(".md") {
            true => report.page(file, text),
            false => report.comments(file, text),
        }
        report.findings
    }

    #[test]
    fn what_is_too_long_is_found_at_its_line() {
        let sentence = vec!["word"; SENTENCE + 1].join(" ");
        let page = format!("# A page\n\nShort. {sentence}.\n");
        assert!(findings("a.md", &page)[0].starts_with("a.md:3: a sentence of 36 words"));
        let cell = vec!["word"; CELL + 1].join(" ");
        let table = format!("| a | b |\n| --- | --- |\n| c | {cell} |\n");
        assert_eq!(findings("a.md", &table), ["a.md:3: a cell of 16 words, expected at most 15"]);
        let line = "a".repeat(PAGE_LINE + 1);
        assert_eq!(findings("a.md", &line).len(), 1);
        assert!(findings("a.md", &format!("```sh\n{line}\n```\n")).is_empty());
        let comment = format!("fn f() {{}}\n\n/// {sentence}.\nfn g() {{}}\n");
        assert!(
            findings("crates/core/src/a.rs", &comment).iter().any(|f| f.contains("a.rs:3: a sentence of 36"))
        );
    }

    #[test]
    fn comments_are_as_wide_as_rustfmt_makes_code() {
        let rustfmt = include_str!("../../../rustfmt.toml");
        assert!(rustfmt.lines().any(|line| line == format!("max_width = {COMMENT_LINE}")), "{rustfmt}");
    }

    #[test]
    fn a_house_word_is_named_with_the_fields() {
        assert_eq!(findings("a.md", "The f64 twin.\n"), ["a.md:1: “twin”, say “reference”"]);
        assert!(findings("a.md", "The function `twin`, and twine.\n").is_empty());
    }

    #[test]
    fn what_is_short_is_not_found() {
        let page = "# A page\n\nIt has [a link](b.md) and `code`. It ends, e.g. here.\n\n- one\n- two\n";
        assert_eq!(findings("a.md", page), Vec::<String>::new());
    }
}
