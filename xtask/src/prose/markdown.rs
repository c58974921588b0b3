//! The parts of Markdown that are measured: paragraphs, items of lists and cells of tables, without code and
//! markup.

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

/// The word that stands for a piece of code in a sentence.
const CODE: &str = "Code";

/// Words whose full stop ends no sentence.
const ABBREVIATIONS: [&str; 6] = ["e.g.", "i.e.", "cf.", "vs.", "ch.", "Fig."];

/// A paragraph, an item of a list or a cell of a table.
pub(super) struct Part {
    pub text: String,
    /// The number of lines before it.
    pub line: usize,
    pub is_cell: bool,
}

/// The parts of a text, in their order. Headings are left out, since they are no sentences.
pub(super) fn parts(markdown: &str) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut part = Part { text: String::new(), line: 0, is_cell: false };
    let mut is_code = false;
    let mut take = |part: &mut Part| {
        let text = std::mem::take(&mut part.text);
        if words(&text).next().is_some() {
            parts.push(Part { text, ..*part });
        }
    };
    for (event, range) in Parser::new_ext(markdown, Options::ENABLE_TABLES).into_offset_iter() {
        if part.text.is_empty() {
            part.line = markdown[..range.start].matches('\n').count();
        }
        match event {
            Event::Start(Tag::CodeBlock(_)) => is_code = true,
            Event::End(TagEnd::CodeBlock) => is_code = false,
            Event::Text(text) if !is_code => part.text += &text,
            Event::Code(_) | Event::InlineMath(_) => part.text += CODE,
            Event::SoftBreak | Event::HardBreak => part.text.push(' '),
            Event::Start(Tag::TableCell) => part.is_cell = true,
            Event::End(TagEnd::TableCell) => {
                take(&mut part);
                part.is_cell = false;
            }
            Event::End(TagEnd::Heading(_)) => part.text.clear(),
            Event::End(TagEnd::Paragraph | TagEnd::Item) | Event::Start(Tag::List(_)) => take(&mut part),
            _ => {}
        }
    }
    take(&mut part);
    parts
}

/// The sentences of a part.
pub(super) fn sentences(text: &str) -> Vec<&str> {
    let mut sentences = Vec::new();
    let mut start = 0;
    for (at, end) in text.match_indices(['.', '!', '?']) {
        let after = at + end.len();
        let closed =
            after + text[after..].len() - text[after..].trim_start_matches(['"', '”', ')', '’']).len();
        let is_last_of_a_word = text[closed..].starts_with(char::is_whitespace);
        let word = text[..after].rsplit(char::is_whitespace).next().unwrap_or_default();
        if is_last_of_a_word && !ABBREVIATIONS.contains(&word.trim_start_matches(['(', '“'])) {
            sentences.push(&text[start..closed]);
            start = closed;
        }
    }
    sentences.push(&text[start..]);
    sentences.retain(|sentence| words(sentence).next().is_some());
    sentences
}

/// The words of a text, without punctuation around them.
pub(super) fn words(text: &str) -> impl Iterator<Item = &str> {
    let bare = |word: &'_ str| -> Option<(usize, usize)> {
        let start = word.find(char::is_alphanumeric)?;
        let end = word.rfind(char::is_alphanumeric)?;
        Some((start, end + word[end..].chars().next().map_or(0, char::len_utf8)))
    };
    text.split_whitespace().filter_map(move |word| bare(word).map(|(start, end)| &word[start..end]))
}

/// The lines, from 1, of more than `most` characters. Code, tables and addresses are left out.
pub(super) fn long_lines(markdown: &str, most: usize) -> Vec<usize> {
    let mut is_code = false;
    let mut long = Vec::new();
    for (number, line) in (1..).zip(markdown.lines()) {
        if line.trim_start().starts_with("```") {
            is_code = !is_code;
        }
        let may_be_long = is_code || line.trim_start().starts_with(['|', '!']) || line.contains("http");
        if !may_be_long && line.chars().count() > most {
            long.push(number);
        }
    }
    long
}
