//! The values of a PLY file, in its three encodings.

use super::super::text::{is_not_finite, not_a_number, number};
use super::header::{Element, Encoding, Header, Scalar};
use rhytid_core::{Error, InputErrorKind, Result};

/// The numbers after the header, in whichever encoding; all fit an `f64` exactly.
pub(super) struct Values<'a> {
    pub name: &'a str,
    encoding: Encoding,
    /// What is not read yet; in ASCII, of the current line.
    rest: &'a [u8],
    /// ASCII: what follows the current line.
    following: &'a [u8],
    /// ASCII: number of the current line, from 1.
    line: usize,
    /// The element being read, its place among its like, and how many of them the header promised.
    element: String,
    index: u64,
    count: u64,
    surplus: Surplus,
}

/// Lines of an ASCII file with more numbers than the header announces.
#[derive(Default)]
struct Surplus {
    count: u64,
    /// The number of the first one.
    line: usize,
    /// The first one's element.
    place: String,
}

impl<'a> Values<'a> {
    pub(super) fn new(file: &'a [u8], header: &Header, name: &'a str) -> Self {
        let data = file.get(header.bytes..).unwrap_or_default();
        let (rest, following): (&[u8], &[u8]) =
            if header.encoding == Encoding::Ascii { (&[], data) } else { (data, &[]) };
        Self {
            name,
            encoding: header.encoding,
            rest,
            following,
            line: header.lines,
            element: String::new(),
            index: 0,
            count: 0,
            surplus: Surplus::default(),
        }
    }

    /// Goes to the `index`-th of `element`. ASCII: to the next line that is not blank.
    pub(super) fn begin(&mut self, element: &Element, index: u64) -> Result<()> {
        if index == 0 {
            self.element.clone_from(&element.name);
            self.count = element.count;
        }
        self.index = index;
        while self.encoding == Encoding::Ascii && self.rest.is_empty() {
            if self.following.is_empty() {
                return Err(self.cut_short());
            }
            let is_end = |b: &u8| matches!(b, b'\n' | b'\r');
            let end = self.following.iter().position(is_end).unwrap_or(self.following.len());
            let (line, after) = self.following.split_at(end);
            self.rest = line.trim_ascii();
            let length = if after.starts_with(b"\r\n") { 2 } else { 1 };
            self.following = after.get(length..).unwrap_or_default();
            self.line += 1;
        }
        Ok(())
    }

    /// Ends the element. ASCII: what the line holds beyond it is skipped and counted, because programs write
    /// colours of corners there which the header does not announce.
    pub(super) fn end(&mut self) {
        if self.encoding == Encoding::Ascii && !self.rest.is_empty() {
            if self.surplus.count == 0 {
                (self.surplus.line, self.surplus.place) = (self.line, self.place());
            }
            self.surplus.count += 1;
            self.rest = &[];
        }
    }

    /// Logs a warning where lines had more numbers than the header announces.
    pub(super) fn say_surplus(&self) {
        let Surplus { count, line, place } = &self.surplus;
        if *count > 0 {
            log::warn!(
                "{}: {count} lines have more numbers than the header announces, as MeshLab writes the colours of \
                 corners; the further numbers were skipped, the first in line {line} ({place}): check that the \
                 others are right",
                self.name
            );
        }
    }

    /// The next number.
    pub(super) fn number(&mut self, scalar: Scalar) -> Result<f64> {
        match self.encoding {
            Encoding::Ascii => self.word(),
            Encoding::LittleEndian => Ok(match scalar {
                Scalar::I8 => i8::from_le_bytes(self.take()?).into(),
                Scalar::U8 => u8::from_le_bytes(self.take()?).into(),
                Scalar::I16 => i16::from_le_bytes(self.take()?).into(),
                Scalar::U16 => u16::from_le_bytes(self.take()?).into(),
                Scalar::I32 => i32::from_le_bytes(self.take()?).into(),
                Scalar::U32 => u32::from_le_bytes(self.take()?).into(),
                Scalar::F32 => f32::from_le_bytes(self.take()?).into(),
                Scalar::F64 => f64::from_le_bytes(self.take()?),
            }),
            Encoding::BigEndian => Ok(match scalar {
                Scalar::I8 => i8::from_be_bytes(self.take()?).into(),
                Scalar::U8 => u8::from_be_bytes(self.take()?).into(),
                Scalar::I16 => i16::from_be_bytes(self.take()?).into(),
                Scalar::U16 => u16::from_be_bytes(self.take()?).into(),
                Scalar::I32 => i32::from_be_bytes(self.take()?).into(),
                Scalar::U32 => u32::from_be_bytes(self.take()?).into(),
                Scalar::F32 => f32::from_be_bytes(self.take()?).into(),
                Scalar::F64 => f64::from_be_bytes(self.take()?),
            }),
        }
    }

    /// The next list, into `out`.
    pub(super) fn list(&mut self, count: Scalar, scalar: Scalar, out: &mut Vec<f64>) -> Result<()> {
        out.clear();
        for _ in 0..self.list_length(count)? {
            out.push(self.number(scalar)?);
        }
        Ok(())
    }

    pub(super) fn skip_list(&mut self, count: Scalar, scalar: Scalar) -> Result<()> {
        let length = self.list_length(count)?;
        if self.encoding == Encoding::Ascii {
            for _ in 0..length {
                self.word()?;
            }
        } else {
            let bytes = usize::try_from(length).ok().and_then(|n| n.checked_mul(scalar.size()));
            self.rest = bytes.and_then(|n| self.rest.get(n..)).ok_or_else(|| self.cut_short())?;
        }
        Ok(())
    }

    fn list_length(&mut self, count: Scalar) -> Result<u64> {
        let length = self.number(count)?;
        if !(0.0..=f64::from(u32::MAX)).contains(&length) || length.fract() != 0.0 {
            return self.fail(format!(
                "{} has a list of {length} numbers, expected a whole number of them; the file may be damaged",
                self.place()
            ));
        }
        Ok(length as u64)
    }

    fn word(&mut self) -> Result<f64> {
        let end = self.rest.iter().position(u8::is_ascii_whitespace).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        if word.is_empty() {
            return self.fail(format!(
                "{} has fewer numbers than the header announces; the file may be cut short",
                self.place()
            ));
        }
        self.rest = rest.trim_ascii_start();
        let number = number(word).or_else(|| is_not_finite(word).then_some(f64::NAN));
        number.ok_or_else(|| self.error(format!("{} has {}", self.place(), not_a_number(word))))
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N]> {
        let (bytes, rest) = self.rest.split_first_chunk().ok_or_else(|| self.cut_short())?;
        self.rest = rest;
        Ok(*bytes)
    }

    fn cut_short(&self) -> Error {
        let plural = match self.element.as_str() {
            "vertex" => "vertices".into(),
            "face" => "faces".into(),
            other => format!("elements {other:?}"),
        };
        let Surplus { count, line, .. } = self.surplus;
        Error::cut_short(match count {
            0 => format!(
                "{}: ends after {} of {} {plural}; the file is cut short",
                self.name, self.index, self.count
            ),
            _ => format!(
                "{}: ends after {} of {} {plural}, but line {line} has more numbers than the header announces; \
                 expected a line for each of them: export the mesh again",
                self.name, self.index, self.count
            ),
        })
    }

    /// The current element for a message, counted from 1 as lines are.
    pub(super) fn place(&self) -> String {
        format!("{} {} of {}", self.element, self.index + 1, self.count)
    }

    pub(super) fn fail<T>(&self, what: String) -> Result<T> {
        Err(self.error(what))
    }

    fn error(&self, what: String) -> Error {
        let line = (self.encoding == Encoding::Ascii).then_some(self.line);
        let place = line.map_or_else(String::new, |line| format!(", line {line}"));
        Error::malformed(format!("{}{place}: {what}", self.name)).of_kind(InputErrorKind::Malformed { line })
    }
}
