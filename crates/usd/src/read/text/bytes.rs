//! The bytes of a text file, buffered.

use super::super::source::Source;
use rhytid_core::{Error, InputErrorKind, Result};

/// Bytes kept in memory at a time.
const BUFFER: usize = 1 << 18;

/// A text file read forward through a buffer. Reading can go back to a place that was passed.
pub(super) struct Bytes {
    source: Source,
    buffer: Vec<u8>,
    /// Where the buffer begins in the file.
    start: u64,
    /// How far the buffer is read, and filled.
    at: usize,
    end: usize,
    line: u64,
}

/// A place in a text file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    at: u64,
    line: u64,
}

impl Bytes {
    pub(super) fn new(source: Source) -> Self {
        let len = usize::try_from(source.len()).unwrap_or(BUFFER).min(BUFFER);
        Self { source, buffer: vec![0; len], start: 0, at: 0, end: 0, line: 1 }
    }

    /// The file is not as it should be, at the line reached.
    pub(super) fn wrong(&self, what: impl std::fmt::Display) -> Error {
        let line = usize::try_from(self.line).ok();
        self.source
            .wrong(format_args!("line {}: {what}", self.line))
            .of_kind(InputErrorKind::Malformed { line })
    }

    pub(super) fn place(&self) -> Place {
        Place { at: self.start + self.at as u64, line: self.line }
    }

    /// Goes on at a place that was passed before.
    pub(super) fn go_to(&mut self, place: Place) {
        self.line = place.line;
        match place.at.checked_sub(self.start) {
            Some(at) if at <= self.end as u64 => self.at = at as usize,
            _ => (self.start, self.at, self.end) = (place.at, 0, 0),
        }
    }

    /// The next byte, which stays; `None` at the end of the file.
    pub(super) fn peek(&mut self) -> Result<Option<u8>> {
        Ok(self.rest()?.first().copied())
    }

    /// Passes `n` bytes of [`Bytes::rest`].
    pub(super) fn pass(&mut self, n: usize) {
        let passed = &self.buffer[self.at..self.at + n];
        self.line += passed.iter().filter(|&&c| c == b'\n').count() as u64;
        self.at += n;
    }

    /// The bytes in memory behind the place reached; none only at the end of the file.
    pub(super) fn rest(&mut self) -> Result<&[u8]> {
        if self.at == self.end {
            self.start += self.end as u64;
            (self.at, self.end) = (0, 0);
            self.end = self.source.read_some(self.start, &mut self.buffer)?;
        }
        Ok(&self.buffer[self.at..self.end])
    }
}
