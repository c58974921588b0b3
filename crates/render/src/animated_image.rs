//! Animated images, in any of the formats.

use crate::{AnimatedWebP, Picture};
use rhytid_core::{Error, Result};
use std::io::{self, Seek, Write};
use std::path::Path;

#[cfg(feature = "film")]
use crate::Film;

/// The format of a moving picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AnimatedImageFormat {
    /// [`AnimatedWebP`].
    WebP,
    /// [`Film`].
    #[cfg(feature = "film")]
    Film,
}

impl AnimatedImageFormat {
    /// The format of a file's extension, in small letters.
    pub fn by_extension(extension: &str) -> Option<Self> {
        match extension {
            "webp" => Some(Self::WebP),
            #[cfg(feature = "film")]
            "mp4" => Some(Self::Film),
            _ => None,
        }
    }

    /// Whether the background can be transparent.
    pub fn has_opacity(self) -> bool {
        match self {
            Self::WebP => true,
            #[cfg(feature = "film")]
            Self::Film => false,
        }
    }

    /// Checks that the format can have pictures of `size` pixels in the file `path`.
    ///
    /// # Errors
    /// [`Error::Input`].
    pub fn check(self, size: [u32; 2], path: &Path) -> Result<()> {
        let (what, [least, most]) = match self {
            Self::WebP => ("an animated WebP", [1, AnimatedWebP::<io::Empty>::LARGEST]),
            #[cfg(feature = "film")]
            Self::Film => ("a film", Film::<io::Empty>::SIDES),
        };
        if size.into_iter().all(|side| (least..=most).contains(&side)) {
            return Ok(());
        }
        let [width, height] = size;
        let path = path.display();
        Err(Error::out_of_range(format!(
            "{path}: {width} × {height} pixels, but {what} has {least} to {most} along each side; ask for another size"
        )))
    }
}

/// A moving picture that is being written.
pub enum AnimatedImage<W: Write + Seek> {
    /// As WebP.
    WebP(AnimatedWebP<W>),
    /// As a film.
    #[cfg(feature = "film")]
    Film(Box<Film<W>>),
}

impl<W: Write + Seek> AnimatedImage<W> {
    /// Begins a moving picture of `pictures` pictures, at least one, of `size` pixels. It shows `rate`
    /// pictures a second (0.1 to 600). `out` is at its beginning.
    ///
    /// # Errors
    /// Errors of `out`; [`io::ErrorKind::InvalidInput`] where [`AnimatedImageFormat::check`] is an error.
    #[cfg_attr(
        not(feature = "film"),
        expect(unused_variables, reason = "only a film has room kept for `pictures`")
    )]
    pub fn new(
        format: AnimatedImageFormat,
        out: W,
        size: [u32; 2],
        pictures: u32,
        rate: f64,
    ) -> io::Result<Self> {
        Ok(match format {
            AnimatedImageFormat::WebP => Self::WebP(AnimatedWebP::new(out, size, rate)?),
            #[cfg(feature = "film")]
            AnimatedImageFormat::Film => Self::Film(Box::new(Film::new(out, size, pictures, rate)?)),
        })
    }

    /// The next picture.
    ///
    /// # Errors
    /// Errors of `out`; [`io::ErrorKind::InvalidInput`] if the picture has another size.
    pub fn add(&mut self, picture: &Picture) -> io::Result<()> {
        match self {
            Self::WebP(webp) => webp.add(picture),
            #[cfg(feature = "film")]
            Self::Film(film) => film.add(picture),
        }
    }

    /// Writes the end.
    ///
    /// # Errors
    /// Errors of `out`, or an error if pictures are missing.
    pub fn finish(self) -> io::Result<()> {
        match self {
            Self::WebP(webp) => webp.finish(),
            #[cfg(feature = "film")]
            Self::Film(film) => film.finish(),
        }
    }
}
