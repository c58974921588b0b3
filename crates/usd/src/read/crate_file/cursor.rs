//! A place in a binary file that moves forward.

use super::super::source::Source;
use super::compression;
use rhytid_core::{Error, InputErrorKind, Result};

/// Reads forward in a source, up to an end.
pub(super) struct Cursor<'a> {
    source: &'a mut Source,
    at: u64,
    end: u64,
    /// What is being read, for messages.
    what: &'a str,
}

impl<'a> Cursor<'a> {
    /// From `at` to the source's end.
    pub(super) fn new(source: &'a mut Source, at: u64, what: &'a str) -> Self {
        let end = source.len();
        Self { source, at, end, what }
    }

    /// From `at` to `end`, which is within the source.
    pub(super) fn section(source: &'a mut Source, at: u64, end: u64, what: &'a str) -> Self {
        Self { source, at, end, what }
    }

    /// The file is not as it should be.
    pub(super) fn damaged(&self, fault: impl std::fmt::Display) -> Error {
        let Self { at, what, .. } = self;
        self.source.wrong(format_args!(
            "{what}, before byte {at}: {fault}; the file is cut short or damaged, export it again"
        ))
    }

    /// How many bytes follow.
    pub(super) fn left(&self) -> u64 {
        self.end.saturating_sub(self.at)
    }

    pub(super) fn at(&self) -> u64 {
        self.at
    }

    pub(super) fn bytes(&mut self, len: u64) -> Result<Vec<u8>> {
        self.need(len)?;
        let bytes = self.source.read(self.at, len)?;
        self.at += len;
        Ok(bytes)
    }

    pub(super) fn u32(&mut self) -> Result<u32> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    pub(super) fn u64(&mut self) -> Result<u64> {
        Ok(u64::from_le_bytes(self.array()?))
    }

    pub(super) fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        self.need(N as u64)?;
        let bytes = self.source.array(self.at)?;
        self.at += N as u64;
        Ok(bytes)
    }

    /// `count` elements of `N` bytes each.
    pub(super) fn elements<const N: usize>(&mut self, count: u64) -> Result<Vec<[u8; N]>> {
        let bytes = self.bytes(count.saturating_mul(N as u64))?;
        Ok(bytes.as_chunks().0.to_vec())
    }

    /// Goes on at the place that a signed distance from here, which is read first, names.
    pub(super) fn jump(&mut self) -> Result<()> {
        let from = self.at;
        let distance = i64::from_le_bytes(self.array()?);
        match from.checked_add_signed(distance) {
            Some(to) if to <= self.end => self.at = to,
            _ => return Err(self.damaged(format_args!("a jump by {distance} bytes leads out of the file"))),
        }
        Ok(())
    }

    /// A compressed block after its length: `count` integers.
    pub(super) fn integers(&mut self, count: usize) -> Result<Vec<i32>> {
        let len = self.u64()?;
        let block = self.bytes(len)?;
        compression::integers(&block, count).ok_or_else(|| {
            self.damaged(format_args!("{len} bytes do not stand for {count} compressed integers"))
        })
    }

    /// A compressed block after its length: `len` bytes.
    pub(super) fn compressed(&mut self, len: u64) -> Result<Vec<u8>> {
        let compressed = self.u64()?;
        let block = self.bytes(compressed)?;
        let wanted = usize::try_from(len).unwrap_or(usize::MAX);
        let out = compression::decompress(&block, wanted).filter(|out| out.len() == wanted);
        out.ok_or_else(|| {
            self.damaged(format_args!("{compressed} compressed bytes do not stand for {len} bytes"))
        })
    }

    fn need(&self, len: u64) -> Result<()> {
        let left = self.left();
        if len > left {
            return Err(self
                .damaged(format_args!("has {left} bytes, expected {len} more"))
                .of_kind(InputErrorKind::CutShort));
        }
        Ok(())
    }
}
