//! The words of USD text.

use super::bytes::{Bytes, Place};
use rhytid_core::{Error, InputErrorKind, Result};

/// The longest word, string or path.
const LONGEST: usize = 1 << 20;

/// Reads words and marks one after the other. Space, comments and line ends separate and are otherwise
/// ignored.
pub(super) struct Lexer {
    bytes: Bytes,
    /// The word being read.
    word: Vec<u8>,
}

/// What comes next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Next {
    /// Letters, digits and `_:.+-!|`: a keyword, a name, a type or a number.
    Word,
    /// A string in quotes.
    Quoted,
    /// A path to a file between `@`.
    Asset,
    /// A path between `<` and `>`.
    Path,
    /// Any other byte.
    Mark(u8),
    /// The end of the file.
    End,
}

impl Lexer {
    pub(super) fn new(bytes: Bytes) -> Self {
        Self { bytes, word: Vec::new() }
    }

    /// An error at the line reached.
    pub(super) fn wrong(&self, what: impl std::fmt::Display) -> Error {
        self.bytes.wrong(what)
    }

    /// Something else than what had to be there.
    pub(super) fn expected(&mut self, what: &str) -> Error {
        let found = match self.bytes.rest() {
            Err(error) => return error,
            Ok([]) => {
                return self
                    .wrong(format_args!("the file ends, expected {what}; it is cut short, export it again"))
                    .of_kind(InputErrorKind::CutShort);
            }
            Ok(rest) => String::from_utf8_lossy(&rest[..rest.len().min(40)]).into_owned(),
        };
        let found = found.lines().next().unwrap_or_default().to_owned();
        self.wrong(format_args!("found “{found}”, expected {what}; the file is damaged, export it again"))
    }

    /// The place of what comes next.
    pub(super) fn place(&mut self) -> Result<Place> {
        self.skip_space()?;
        Ok(self.bytes.place())
    }

    pub(super) fn go_to(&mut self, place: Place) {
        self.bytes.go_to(place);
    }

    fn skip_space(&mut self) -> Result<()> {
        let mut comment = false;
        loop {
            let rest = self.bytes.rest()?;
            let passed = rest.iter().take_while(|&&c| {
                comment = if comment { c != b'\n' } else { c == b'#' };
                comment || c.is_ascii_whitespace()
            });
            let (passed, all) = (passed.count(), rest.len());
            self.bytes.pass(passed);
            if passed < all || all == 0 {
                return Ok(());
            }
        }
    }

    pub(super) fn next(&mut self) -> Result<Next> {
        self.skip_space()?;
        Ok(match self.bytes.peek()? {
            None => Next::End,
            Some(b'"' | b'\'') => Next::Quoted,
            Some(b'@') => Next::Asset,
            Some(b'<') => Next::Path,
            // Namespaces come behind a name.
            Some(c) if is_of_word(c) && c != b':' => Next::Word,
            Some(c) => Next::Mark(c),
        })
    }

    /// Passes `mark` if it comes next.
    pub(super) fn accept(&mut self, mark: u8) -> Result<bool> {
        let found = self.next()? == Next::Mark(mark);
        if found {
            self.bytes.pass(1);
        }
        Ok(found)
    }

    pub(super) fn expect(&mut self, mark: u8) -> Result<()> {
        match self.accept(mark)? {
            true => Ok(()),
            false => Err(self.expected(&format!("“{}”", char::from(mark)))),
        }
    }

    /// A word of the bytes that `is_of` takes; `what` in messages.
    fn raw_word(&mut self, what: &str, is_of: fn(u8) -> bool) -> Result<&str> {
        self.word.clear();
        if self.next()? != Next::Word {
            return Err(self.expected(what));
        }
        loop {
            let rest = self.bytes.rest()?;
            let n = rest.iter().take_while(|&&c| is_of(c)).count();
            self.word.extend_from_slice(&rest[..n]);
            let ended = n < rest.len() || rest.is_empty();
            self.bytes.pass(n);
            self.check_length()?;
            if ended {
                break;
            }
        }
        str::from_utf8(&self.word).map_err(|_| self.bytes.wrong("a word is not UTF-8; the file is damaged"))
    }

    pub(super) fn word(&mut self, what: &str) -> Result<String> {
        self.raw_word(what, is_of_word).map(str::to_owned)
    }

    /// Whether `word` comes next; it stays.
    pub(super) fn at_word(&mut self, word: &str) -> Result<bool> {
        if self.next()? != Next::Word {
            return Ok(false);
        }
        let place = self.bytes.place();
        let found = self.raw_word("a word", is_of_word)? == word;
        self.bytes.go_to(place);
        Ok(found)
    }

    /// A number, as USD reads it: by way of 64 bits.
    pub(super) fn number(&mut self) -> Result<f64> {
        let word = self.raw_word("a number", is_of_number)?;
        // Rust's parser also takes `infinity` and `+1`, which do no harm.
        let number = word.parse();
        number.map_err(|_| {
            let word = String::from_utf8_lossy(&self.word);
            self.bytes.wrong(format_args!(
                "found “{word}”, expected a number; the file is damaged, export it again"
            ))
        })
    }

    /// A whole number of 32 bits.
    pub(super) fn integer(&mut self) -> Result<i32> {
        let number = self.raw_word("a whole number", is_of_number)?.parse();
        number.map_err(|_| {
            let word = String::from_utf8_lossy(&self.word);
            self.bytes.wrong(format_args!(
                "found “{word}”, expected a whole number of 32 bits; the file is damaged, export it again"
            ))
        })
    }

    fn check_length(&self) -> Result<()> {
        if self.word.len() > LONGEST {
            return Err(
                self.wrong(format_args!("a word is longer than {LONGEST} bytes; the file is damaged"))
            );
        }
        Ok(())
    }

    /// A string in single or double quotes, one or three of them.
    pub(super) fn quoted(&mut self) -> Result<String> {
        let quote = match self.next()? {
            Next::Quoted => self.bytes.peek()?.unwrap_or_default(),
            _ => return Err(self.expected("a string in quotes")),
        };
        let mut opening = 0;
        while opening < 3 && self.bytes.peek()? == Some(quote) {
            self.bytes.pass(1);
            opening += 1;
        }
        if opening == 2 {
            return Ok(String::new());
        }
        self.word.clear();
        let mut closing = 0;
        while closing < opening {
            let c = self.inside("the end of a string")?;
            if c == quote {
                closing += 1;
                continue;
            }
            self.word.resize(self.word.len() + closing, quote);
            closing = 0;
            match c {
                b'\\' => self.escape()?,
                b'\n' if opening == 1 => {
                    return Err(self.wrong("a string goes beyond its line; the file is damaged"));
                }
                _ => self.word.push(c),
            }
        }
        self.text()
    }

    /// What follows a backslash.
    fn escape(&mut self) -> Result<()> {
        let c = self.inside("a character")?;
        let plain = match c {
            b'n' => b'\n',
            b't' => b'\t',
            b'r' => b'\r',
            b'a' => 7,
            b'b' => 8,
            b'f' => 12,
            b'v' => 11,
            b'x' => {
                let digits = [self.inside("a digit")?, self.inside("a digit")?];
                let byte =
                    str::from_utf8(&digits).ok().and_then(|digits| u8::from_str_radix(digits, 16).ok());
                byte.ok_or_else(|| self.wrong("“\\x” is not followed by two hexadecimal digits"))?
            }
            other => other,
        };
        self.word.push(plain);
        Ok(())
    }

    /// A path to a file, between one or three `@`. USD's library also takes one in quotes.
    pub(super) fn asset(&mut self) -> Result<String> {
        if self.next()? == Next::Quoted {
            return self.quoted();
        }
        if self.next()? != Next::Asset {
            return Err(self.expected("a path to a file between “@”"));
        }
        let mut opening = 0;
        while opening < 3 && self.bytes.peek()? == Some(b'@') {
            self.bytes.pass(1);
            opening += 1;
        }
        if opening == 2 {
            return Ok(String::new());
        }
        self.word.clear();
        let end: &[u8] = if opening == 1 { b"@" } else { b"@@@" };
        // Up to here nothing ends the path.
        let mut kept = 0;
        while !self.word[kept..].ends_with(end) {
            let c = self.inside("“@”")?;
            self.word.push(c);
            if opening == 3 && self.word[kept..].ends_with(b"\\@@@") {
                self.word.truncate(self.word.len() - 4);
                self.word.extend_from_slice(end);
                kept = self.word.len();
            }
        }
        self.word.truncate(self.word.len() - end.len());
        self.text()
    }

    /// A path between `<` and `>`.
    pub(super) fn path(&mut self) -> Result<String> {
        if self.next()? != Next::Path {
            return Err(self.expected("a path between “<” and “>”"));
        }
        self.bytes.pass(1);
        self.word.clear();
        loop {
            match self.inside("“>”")? {
                b'>' => return self.text(),
                c => self.word.push(c),
            }
        }
    }

    /// The next byte of something that ends before the file does.
    fn inside(&mut self, what: &str) -> Result<u8> {
        self.check_length()?;
        let Some(c) = self.bytes.peek()? else { return Err(self.expected(what)) };
        self.bytes.pass(1);
        Ok(c)
    }

    fn text(&self) -> Result<String> {
        let text = str::from_utf8(&self.word).map(str::to_owned);
        text.map_err(|_| self.wrong("a string is not UTF-8; the file is damaged, export it again"))
    }

    /// Passes one value of any type: a word, a string, a path, or all between a bracket and its partner.
    pub(super) fn skip_value(&mut self) -> Result<()> {
        let mut depth = 0_u64;
        loop {
            match self.next()? {
                Next::Word => self.skip_word()?,
                Next::Quoted => drop(self.quoted()?),
                Next::Asset => {
                    drop(self.asset()?);
                    // `@file@</prim>` is one value.
                    if self.next()? == Next::Path {
                        continue;
                    }
                }
                Next::Path => drop(self.path()?),
                Next::Mark(b'[' | b'(' | b'{') => {
                    self.bytes.pass(1);
                    depth += 1;
                    self.skip_numbers()?;
                }
                Next::Mark(b']' | b')' | b'}') if depth > 0 => {
                    self.bytes.pass(1);
                    depth -= 1;
                }
                Next::Mark(b',' | b';' | b'=' | b':') if depth > 0 => {
                    self.bytes.pass(1);
                    self.skip_numbers()?;
                }
                _ => return Err(self.expected("a value")),
            }
            if depth == 0 {
                return Ok(());
            }
        }
    }

    fn skip_word(&mut self) -> Result<()> {
        loop {
            let rest = self.bytes.rest()?;
            let n = rest.iter().take_while(|&&c| is_of_word(c)).count();
            let ended = n < rest.len() || rest.is_empty();
            self.bytes.pass(n);
            if ended {
                return Ok(());
            }
        }
    }

    /// Passes numbers and tuples of them quickly, up to behind the last whole one in memory. Brackets are
    /// balanced there.
    fn skip_numbers(&mut self) -> Result<()> {
        /// Lists of matrices are this deep.
        const DEEPEST: u32 = 3;
        loop {
            let rest = self.bytes.rest()?;
            let (mut depth, mut whole) = (0, 0);
            for (i, c) in rest.iter().enumerate() {
                match c {
                    b'0'..=b'9' | b' ' | b'.' | b'-' | b'e' | b'\n' | b',' => {}
                    b'(' if depth < DEEPEST => depth += 1,
                    b')' if depth > 0 => depth -= 1,
                    _ => break,
                }
                if depth == 0 && matches!(c, b')' | b',') {
                    whole = i + 1;
                }
            }
            self.bytes.pass(whole);
            if whole == 0 {
                return Ok(());
            }
        }
    }
}

/// Letters, digits and what else names, types and keywords are made of.
fn is_of_word(c: u8) -> bool {
    c.is_ascii_alphanumeric() || matches!(c, b'_' | b':' | b'.' | b'+' | b'-' | b'!' | b'|') || c >= 0x80
}

/// What numbers are made of, `inf` and `nan` included.
fn is_of_number(c: u8) -> bool {
    c.is_ascii_alphanumeric() || matches!(c, b'.' | b'+' | b'-')
}
