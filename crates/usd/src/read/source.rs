//! Bytes at any place of a file, checked against its length.

use rhytid_core::{Error, InputErrorKind, Result, input_file};
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// A file, or bytes in memory.
pub(super) trait ReadSeek: Read + Seek + Send {}

impl<T: Read + Seek + Send> ReadSeek for T {}

/// Bytes that are read where they are wanted: a whole file, or a layer within a package. No read goes beyond
/// their end, and nothing is allocated before it is known that the bytes are there.
pub(super) struct Source {
    bytes: Box<dyn ReadSeek>,
    name: String,
    start: u64,
    len: u64,
}

impl Source {
    /// A file, called by its path.
    pub(super) fn open(path: &Path) -> Result<Self> {
        Self::new(Box::new(input_file::open(path)?), path.display().to_string())
    }

    /// Anything else, called `name` in messages.
    pub(super) fn new(mut bytes: Box<dyn ReadSeek>, name: String) -> Result<Self> {
        let len = bytes.seek(SeekFrom::End(0)).map_err(Error::io(Path::new(&name)))?;
        Ok(Self { bytes, name, start: 0, len })
    }

    /// Only `len` bytes from `start` on, both of which were checked.
    pub(super) fn part(self, start: u64, len: u64, name: String) -> Self {
        Self { name, start: self.start + start, len, ..self }
    }

    pub(super) fn len(&self) -> u64 {
        self.len
    }

    pub(super) fn into_inner(self) -> (Box<dyn ReadSeek>, String) {
        (self.bytes, self.name)
    }

    /// An error of the input, with the file's name before it.
    pub(super) fn wrong(&self, what: impl std::fmt::Display) -> Error {
        Error::malformed(format!("{}: {what}", self.name))
    }

    /// `len` bytes from `at` on.
    pub(super) fn read(&mut self, at: u64, len: u64) -> Result<Vec<u8>> {
        self.check(at, len)?;
        let mut bytes = vec![
            0;
            usize::try_from(len).map_err(|_| self
                .wrong("is too large for this machine")
                .of_kind(InputErrorKind::TooLarge))?
        ];
        self.fill_unchecked(at, &mut bytes)?;
        Ok(bytes)
    }

    /// The `N` bytes from `at` on.
    pub(super) fn array<const N: usize>(&mut self, at: u64) -> Result<[u8; N]> {
        self.check(at, N as u64)?;
        let mut bytes = [0; N];
        self.fill_unchecked(at, &mut bytes)?;
        Ok(bytes)
    }

    /// As many bytes from `at` on as there are, at most those of `buffer`. Returns their number.
    pub(super) fn read_some(&mut self, at: u64, buffer: &mut [u8]) -> Result<usize> {
        let len = buffer.len().min(usize::try_from(self.len.saturating_sub(at)).unwrap_or(usize::MAX));
        self.fill_unchecked(at, &mut buffer[..len])?;
        Ok(len)
    }

    fn check(&self, at: u64, len: u64) -> Result<()> {
        if at.checked_add(len).is_none_or(|end| end > self.len) {
            return Err(self.wrong(format_args!(
                "has {} bytes, expected {len} more from byte {at} on; the file is cut short or damaged, export it \
                 again",
                self.len
            )).of_kind(InputErrorKind::CutShort));
        }
        Ok(())
    }

    fn fill_unchecked(&mut self, at: u64, buffer: &mut [u8]) -> Result<()> {
        let position = SeekFrom::Start(self.start + at);
        let read = self.bytes.seek(position).and_then(|_| self.bytes.read_exact(buffer));
        read.map_err(Error::io(Path::new(&self.name)))
    }
}
