//! What a picture from a file may have: how many pixels, and which palette.

use crate::{Error, Remedy, Result, human};
use std::sync::atomic::{AtomicU64, Ordering};

/// As many as 8,192 × 8,192.
pub const MOST_PIXELS: u64 = 1 << 26;

static LIMIT: AtomicU64 = AtomicU64::new(MOST_PIXELS);

/// Sets the limit for this process; [`MOST_PIXELS`] if it is never called.
///
/// A small file can hold a picture of any size, so this bounds the memory that pictures take: up to 8 bytes a
/// pixel.
pub fn set_most_pixels(limit: u64) {
    LIMIT.store(limit, Ordering::Relaxed);
}

/// Checks the size of a picture, before memory is taken for it.
///
/// # Errors
/// [`Error::Input`], without the file's name, if it has no pixels or more than the limit.
pub fn check_pixels(width: u64, height: u64) -> Result<()> {
    let limit = LIMIT.load(Ordering::Relaxed);
    match width.checked_mul(height) {
        Some(1..) if width * height <= limit => Ok(()),
        Some(0) => Err(Error::malformed(format!("has {width} × {height} pixels"))),
        _ => Err(Error::too_large(format!(
            "has {} × {} pixels, expected at most {} in all; save it smaller, or allow more",
            human::count(usize::try_from(width).unwrap_or(usize::MAX)),
            human::count(usize::try_from(height).unwrap_or(usize::MAX)),
            human::count(usize::try_from(limit).unwrap_or(usize::MAX))
        ))
        .with_remedies(&[Remedy::MostPixels])),
    }
}

/// Checks the palette of a picture, three bytes for each colour.
///
/// # Errors
/// [`Error::Input`], without the file's name, if its length is another.
pub fn check_palette(palette: Option<&[u8]>) -> Result<()> {
    match palette {
        Some(bytes) if bytes.len() % 3 != 0 => Err(Error::malformed(format!(
            "has a palette of {} bytes, expected three for each colour; save it again",
            bytes.len()
        ))),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_that_multiply_to_too_much_are_refused() {
        for (width, height) in [(1, 1), (8192, 8192), (1, MOST_PIXELS)] {
            check_pixels(width, height).unwrap();
        }
        for (width, height) in [(8192, 8193), (30_000, 30_000), (u64::MAX, 2), (0, 5)] {
            let said = check_pixels(width, height).unwrap_err().to_string();
            assert!(said.contains("pixels"), "{said}");
        }
    }

    #[test]
    fn a_palette_has_whole_colours() {
        assert!(check_palette(None).is_ok() && check_palette(Some(&[0; 6])).is_ok());
        let said = check_palette(Some(&[0; 2])).unwrap_err().to_string();
        assert!(said.contains("a palette of 2 bytes"), "{said}");
    }
}
