//! The statements of an OBJ or MTL file: lines, joined where one ends with a backslash.

use std::borrow::Cow;

/// The statements of a file. A line ends with LF, CR LF or CR.
pub(in super::super) fn statements(bytes: &[u8]) -> Lines<'_> {
    let is_ended = matches!(bytes.last(), Some(b'\n' | b'\r'));
    Lines { rest: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), next_number: 1, is_ended }
}

/// A statement of the file.
pub(in super::super) struct Statement<'a> {
    pub text: Cow<'a, [u8]>,
    /// The number of its first line, from 1.
    pub line: usize,
    /// Lines that a backslash joined to the first.
    pub joined: Vec<&'a [u8]>,
    /// Whether the file ends without a line end behind it.
    pub is_cut: bool,
}

pub(in super::super) struct Lines<'a> {
    rest: &'a [u8],
    next_number: usize,
    /// Whether there is a line end at the end of the file.
    is_ended: bool,
}

impl<'a> Iterator for Lines<'a> {
    type Item = Statement<'a>;

    fn next(&mut self) -> Option<Statement<'a>> {
        let line = self.next_number;
        let mut last = self.physical()?;
        let mut text = Cow::Borrowed(last);
        let mut joined = Vec::new();
        while let Some(without) = before_backslash(last) {
            let before = text.len() - (last.len() - without.len());
            let text = text.to_mut();
            text.truncate(before);
            text.push(b' ');
            let Some(next) = self.physical() else { break };
            text.extend_from_slice(next);
            joined.push(next);
            last = next;
        }
        let is_cut = self.rest.is_empty() && !self.is_ended;
        Some(Statement { text, line, joined, is_cut })
    }
}

impl<'a> Lines<'a> {
    fn physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        let after = if rest.starts_with(b"\r\n") { 2 } else { 1 };
        self.rest = rest.get(after..).unwrap_or_default();
        self.next_number += 1;
        Some(line)
    }
}

/// What is before the backslash that joins a line with the next one. Blanks may be behind the backslash. A
/// comment is never continued: it may end with the name of a Windows folder.
fn before_backslash(line: &[u8]) -> Option<&[u8]> {
    let before = line.trim_ascii_end().strip_suffix(b"\\")?;
    let mut words = before.split(|&byte| is_blank(byte));
    (!words.any(|word| word.first() == Some(&b'#'))).then_some(before)
}

/// Whether a byte separates words.
pub(in super::super) fn is_blank(byte: u8) -> bool {
    // Vertical tabs too.
    byte.is_ascii_whitespace() || byte == 0x0b
}

/// The words of a statement without its comment.
pub(in super::super) fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text.split(|&byte| is_blank(byte)).filter(|word| !word.is_empty()).take_while(|word| word[0] != b'#')
}
