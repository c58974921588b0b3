//! A TOML document: its tables, values by their keys, and errors that name the line.
use rhytid_core::text::did_you_mean;
use rhytid_core::text::line_of;
use rhytid_core::text::quoted;
use rhytid_core::{Error, InputErrorKind, Result};
use std::path::PathBuf;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The tables of `text`; `name` names the file in errors.
pub(crate) fn tables<'a>(text: &'a str, name: &'a str) -> Result<Spanned<DeTable<'a>>> {
    let file = File { text, name };
    DeTable::parse(text).map_err(|e| {
        let reason = e.message().replace('\n', ", ");
        let at = e.span().map_or(0, |span| span.start);
        let line = text.lines().nth(file.line(at).saturating_sub(1)).unwrap_or_default();
        let title = |line: &str| Some(line.strip_prefix('[')?.strip_suffix(']')?.to_owned());
        let remedy = match (line.trim(), title(line.trim())) {
            (line, _) if line.contains('\\') => {
                "; in double quotes a backslash begins an escape: write paths with / or in 'single quotes'"
                    .to_owned()
            }
            (_, Some(title)) if MANY.contains(&&*title) => {
                format!("; each {title} begins with [[{title}]] in double brackets")
            }
            _ => String::new(),
        };
        file.error(at, &format!("not TOML: {reason}{remedy}"))
    })
}

/// Sections that there can be many of.
const MANY: [&str; 7] = ["example", "gain", "offset", "add", "hold", "detail", "correction"];

#[derive(Clone, Copy)]
pub(crate) struct File<'a> {
    pub(crate) text: &'a str,
    pub(crate) name: &'a str,
}

impl File<'_> {
    pub(crate) fn line(&self, offset: usize) -> usize {
        line_of(self.text.as_bytes(), offset)
    }

    pub(crate) fn error(&self, offset: usize, message: &str) -> Error {
        let line = self.line(offset);
        Error::malformed(format!("{}, line {line}: {message}", self.name))
            .of_kind(InputErrorKind::Malformed { line: Some(line) })
    }
}

/// One table of the document.
pub(crate) struct Section<'a> {
    pub(crate) file: File<'a>,
    /// As users write it, `[mesh]`; empty for the document itself.
    pub(crate) title: String,
    pub(crate) offset: usize,
    pub(crate) table: &'a DeTable<'a>,
}

impl<'a> Section<'a> {
    /// Fails at the first key that is not among `known`.
    pub(crate) fn allow(&self, known: &[&str]) -> Result<()> {
        self.allow_with_former(known, &[])
    }

    /// Fails at the first key that is neither among `known` nor among their `former` names.
    pub(crate) fn allow_with_former(&self, known: &[&str], former: &[&str]) -> Result<()> {
        let is_unknown = |key: &str| !known.contains(&key) && !former.contains(&key);
        let unknown = self.table.keys().filter(|key| is_unknown(key.get_ref()));
        let Some(key) = unknown.min_by_key(|key| key.span().start) else { return Ok(()) };
        let place = if self.title.is_empty() { "" } else { " in " };
        Err(self
            .file
            .error(
                key.span().start,
                &format!(
                    "unknown key {}{place}{}{}, expected {}",
                    quoted(key.get_ref()),
                    self.title,
                    did_you_mean(key.get_ref(), known.iter().copied()),
                    known.join(", ")
                ),
            )
            .of_kind(InputErrorKind::UnknownKey { key: key.get_ref().to_string() }))
    }

    /// The name that the file states a key by: `key`, or its `former` name.
    ///
    /// # Errors
    /// The file states both.
    pub(crate) fn name_of(&self, key: &'static str, former: &'static str) -> Result<&'static str> {
        match (self.entry(key), self.entry(former)) {
            (Some(_), Some(twice)) => {
                let message = format!("{former} is the former name of {key}, which {} has, too", self.title);
                Err(self.file.error(twice.span().start, &message))
            }
            (None, Some(_)) => Ok(former),
            _ => Ok(key),
        }
    }

    pub(crate) fn entry(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.table.get(key)
    }

    pub(crate) fn get(&self, key: &str) -> Option<&'a DeValue<'a>> {
        self.entry(key).map(Spanned::get_ref)
    }

    pub(crate) fn required(&self, key: &str, expected: &str) -> Result<&'a DeValue<'a>> {
        self.get(key).ok_or_else(|| self.lacks(key, expected))
    }

    pub(crate) fn text(&self, key: &str, expected: &str) -> Result<Option<&'a str>> {
        match self.get(key) {
            None => Ok(None),
            Some(DeValue::String(text)) => Ok(Some(text)),
            Some(other) => Err(self.wrong(key, &found(other), expected)),
        }
    }

    pub(crate) fn path(&self, key: &str, expected: &str) -> Result<PathBuf> {
        match self.text(key, expected)? {
            None => Err(self.lacks(key, expected)),
            Some("") => Err(self.wrong(key, "empty", expected)),
            Some(path) => Ok(PathBuf::from(path)),
        }
    }

    pub(crate) fn positive(&self, key: &str, expected: &str) -> Result<f64> {
        let value = self.required(key, expected)?;
        self.number(key)
            .filter(|number| *number > 0.0)
            .ok_or_else(|| self.wrong(key, &found(value), expected))
    }

    /// A finite number, if that is what the key has.
    pub(crate) fn number(&self, key: &str) -> Option<f64> {
        number_of(self.get(key)?)
    }

    /// A whole number from 0, if the key is there.
    pub(crate) fn whole(&self, key: &str, expected: &str) -> Result<Option<usize>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let number = self.number(key).filter(|x| *x >= 0.0 && x.fract() == 0.0 && *x < 1e9);
        number.map(|x| Some(x as usize)).ok_or_else(|| self.wrong(key, &found(value), expected))
    }

    /// Three numbers, if that is what the key has.
    pub(crate) fn vector(&self, key: &str, expected: &str) -> Result<Option<[f64; 3]>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        vector_of(value).map(Some).ok_or_else(|| self.wrong(key, &found(value), expected))
    }

    /// A list of texts that are not empty; none where the key is not there.
    pub(crate) fn texts(&self, key: &str, expected: &str) -> Result<Vec<String>> {
        let text = |item: &Spanned<DeValue<'_>>| match item.get_ref() {
            DeValue::String(text) if !text.trim().is_empty() => Ok(text.to_string()),
            other => Err(self.wrong(key, &format!("a list with {}", found(other)), expected)),
        };
        match self.get(key) {
            None => Ok(Vec::new()),
            Some(DeValue::Array(items)) => items.iter().map(text).collect(),
            Some(other) => Err(self.wrong(key, &found(other), expected)),
        }
    }

    /// True or false, if the key is there.
    pub(crate) fn truth(&self, key: &str) -> Result<Option<bool>> {
        match self.get(key) {
            None => Ok(None),
            Some(DeValue::Boolean(truth)) => Ok(Some(*truth)),
            Some(other) => Err(self.wrong(key, &found(other), "true or false")),
        }
    }

    pub(crate) fn section(&self, key: &str) -> Result<Option<Section<'a>>> {
        let Some(entry) = self.entry(key) else { return Ok(None) };
        match entry.get_ref() {
            DeValue::Table(table) => Ok(Some(self.inner(format!("[{key}]"), entry, table))),
            other => Err(self.wrong(key, &found(other), &format!("a section [{key}]"))),
        }
    }

    pub(crate) fn required_section(&self, key: &str, keys: &str) -> Result<Section<'a>> {
        self.section(key)?.ok_or_else(|| {
            Error::input(format!("{}: has no section [{key}], expected one with {keys}", self.file.name))
                .of_kind(InputErrorKind::MissingKey { key: key.to_owned() })
        })
    }

    pub(crate) fn sections(&self, key: &str) -> Result<Vec<Section<'a>>> {
        let wrong = |entry: &Spanned<DeValue<'a>>| {
            let expected = format!("[[{key}]] in double brackets, once for each");
            self.file
                .error(
                    entry.span().start,
                    &format!("{key} is {}, expected {expected}", found(entry.get_ref())),
                )
                .of_kind(InputErrorKind::WrongValue { key: key.to_owned() })
        };
        let Some(entry) = self.entry(key) else { return Ok(Vec::new()) };
        let DeValue::Array(items) = entry.get_ref() else { return Err(wrong(entry)) };
        let section = |item: &'a Spanned<DeValue<'a>>| match item.get_ref() {
            DeValue::Table(table) => Ok(self.inner(format!("[[{key}]]"), item, table)),
            _ => Err(wrong(item)),
        };
        items.iter().map(section).collect()
    }

    pub(crate) fn inner(
        &self,
        title: String,
        entry: &Spanned<DeValue<'_>>,
        table: &'a DeTable<'a>,
    ) -> Section<'a> {
        Section { file: self.file, title, offset: entry.span().start, table }
    }

    /// The line of a key's value, or of the section where it lacks the key.
    pub(crate) fn line(&self, key: &str) -> usize {
        self.file.line(self.entry(key).map_or(self.offset, |entry| entry.span().start))
    }

    /// What is wrong with the whole section.
    pub(crate) fn error(&self, what: &str) -> Error {
        self.file.error(self.offset, &format!("{} {what}", self.title))
    }

    pub(crate) fn lacks(&self, key: &str, expected: &str) -> Error {
        self.error(&format!("lacks the key {key}, expected {expected}"))
            .of_kind(InputErrorKind::MissingKey { key: key.to_owned() })
    }

    pub(crate) fn wrong(&self, key: &str, found: &str, expected: &str) -> Error {
        let place = if self.title.is_empty() { String::new() } else { format!("{} ", self.title) };
        let offset = self.entry(key).map_or(self.offset, |entry| entry.span().start);
        self.file
            .error(offset, &format!("{place}{key} is {found}, expected {expected}"))
            .of_kind(InputErrorKind::WrongValue { key: key.to_owned() })
    }
}

/// A finite number, if the value is one.
pub(crate) fn number_of(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(number) => number.as_str().parse().ok(),
        DeValue::Integer(n) => i64::from_str_radix(n.as_str(), n.radix()).ok().map(|n| n as f64),
        _ => None,
    }
    .filter(|number: &f64| number.is_finite())
}

/// Three finite numbers, if the value is that.
pub(crate) fn vector_of(value: &DeValue<'_>) -> Option<[f64; 3]> {
    let DeValue::Array(items) = value else { return None };
    let numbers: Option<Vec<f64>> = items.iter().map(|item| number_of(item.get_ref())).collect();
    numbers?.try_into().ok()
}

pub(crate) fn found(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => quoted(text),
        DeValue::Integer(number) => number.to_string(),
        DeValue::Float(number) => number.to_string(),
        DeValue::Boolean(value) => value.to_string(),
        DeValue::Datetime(date) => format!("the date {date}"),
        DeValue::Array(_) => "an array".to_owned(),
        DeValue::Table(_) => "a section".to_owned(),
    }
}
