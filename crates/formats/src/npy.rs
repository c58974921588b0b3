//! Arrays of NumPy (`.npy`, the format's versions 1 to 3): a header, which is a Python dictionary of three
//! known keys, and the numbers. This module parses them itself, because the crates for the format bring a
//! parser of Python that takes long to compile.

use rhytid_core::{Error, Result, input_file};
use std::path::Path;

/// An array of numbers in C order.
pub(crate) struct Array {
    pub(crate) shape: Vec<usize>,
    /// As many numbers as the product of the shape.
    pub(crate) numbers: Vec<f32>,
}

/// Reads an array of float32 or float64 in C order, with either byte order.
///
/// # Errors
/// [`Error::Input`] if the file is no such array or is cut off; [`Error::Io`].
pub(crate) fn read(path: &Path) -> Result<Array> {
    let bytes = input_file::read(path, input_file::LARGEST_RIG)?;
    parse(&bytes).map_err(|error| error.in_file(path.display()))
}

fn parse(bytes: &[u8]) -> Result<Array> {
    let (header, data) = split(bytes)
        .ok_or_else(|| Error::malformed("is no NumPy array that can be read: its header is damaged"))?;
    let missing =
        |key: &str| Error::malformed(format!("is no NumPy array that can be read: its header has no {key}"));
    let descr = value(header, "descr").ok_or_else(|| missing("descr"))?;
    let order = value(header, "fortran_order").ok_or_else(|| missing("fortran_order"))?;
    let shape = value(header, "shape").and_then(tuple).ok_or_else(|| missing("shape"))?;
    if !order.starts_with("False") {
        return Err(Error::unsupported_format(format!(
            "is an array of the shape {shape:?} in Fortran's order, expected C order"
        )));
    }
    let kind = descr.trim_start_matches(['\'', '"']);
    let (size, number): (usize, fn(&[u8]) -> f32) = match kind.get(..3) {
        Some("<f4") => (4, |b| f32::from_le_bytes(b.try_into().unwrap())),
        Some(">f4") => (4, |b| f32::from_be_bytes(b.try_into().unwrap())),
        Some("<f8") => (8, |b| f64::from_le_bytes(b.try_into().unwrap()) as f32),
        Some(">f8") => (8, |b| f64::from_be_bytes(b.try_into().unwrap()) as f32),
        _ => {
            let kind = descr.split([',', '}']).next().unwrap_or_default().trim();
            return Err(Error::unsupported_format(format!(
                "its numbers are {kind}, expected float32 or float64 (as in '<f4')"
            )));
        }
    };
    let count = shape.iter().try_fold(1, |product: usize, &n| product.checked_mul(n));
    match count.and_then(|count| count.checked_mul(size)) {
        Some(expected) if expected <= data.len() => {
            Ok(Array { shape, numbers: data[..expected].chunks_exact(size).map(number).collect() })
        }
        _ => Err(Error::cut_short(format!(
            "is cut off: {} bytes follow its header, too few for the shape {shape:?}",
            data.len()
        ))),
    }
}

/// The dictionary and the bytes of the numbers.
fn split(bytes: &[u8]) -> Option<(&str, &[u8])> {
    let rest = bytes.strip_prefix(b"\x93NUMPY")?;
    let (&[major, _minor], rest) = rest.split_first_chunk()?;
    let (length, rest) = if major == 1 {
        let (&length, rest) = rest.split_first_chunk()?;
        (usize::from(u16::from_le_bytes(length)), rest)
    } else {
        let (&length, rest) = rest.split_first_chunk()?;
        (usize::try_from(u32::from_le_bytes(length)).ok()?, rest)
    };
    let (header, data) = rest.split_at_checked(length)?;
    Some((std::str::from_utf8(header).ok()?, data))
}

/// The text behind a key of the dictionary, up to the end of the dictionary.
fn value<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let at = header.find(&format!("'{key}'")).or_else(|| header.find(&format!("\"{key}\"")))?;
    Some(header[at + key.len() + 2..].trim_start().strip_prefix(':')?.trim_start())
}

/// A tuple of whole numbers. Python writes a comma behind a single number, and Python 2 wrote an L behind
/// long ones.
fn tuple(text: &str) -> Option<Vec<usize>> {
    let inside = text.strip_prefix('(')?.split_once(')')?.0;
    let numbers = inside.split(',').map(|n| n.trim().trim_end_matches('L')).filter(|n| !n.is_empty());
    numbers.map(|n| n.parse().ok()).collect()
}
