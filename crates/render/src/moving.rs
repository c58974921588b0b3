//! Pictures that move, in any of the formats.

use crate::{AnimatedWebP, Picture};
use rhytid_core::{Error, Result};
use std::io::{self, Seek, Write};
use std::path::Path;

#[cfg(feature = "film")]
use crate::Film;

/// What a moving picture is kept in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MovingFormat {
    /// [`AnimatedWebP`].
    WebP,
    /// [`Film`].
    #[cfg(feature = "film")]
    Film,
}

impl MovingFormat {
    /// By a file's extension, in small letters.
    pub fn by_extension(extension: &str) -> Option<Self> {
        match extension {
            "webp" => Some(Self::WebP),
            #[cfg(feature = "film")]
            "mp4" => Some(Self::Film),
            _ => None,
        }
    }

    /// Whether what is behind a face can be left out.
    pub fn has_opacity(self) -> bool {
        match self {
            Self::WebP => true,
            #[cfg(feature = "film")]
            Self::Film => false,
        }
    }

    /// That there can be pictures of `size` pixels in the file `path`.
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
pub enum Moving<W: Write + Seek> {
    /// As WebP.
    WebP(AnimatedWebP<W>),
    /// As a film.
    #[cfg(feature = "film")]
    Film(Box<Film<W>>),
}

impl<W: Write + Seek> Moving<W> {
    /// Of `pictures`, at least one, of `size` pixels, `rate` of them a second (0.1 to 600). `out` is at its beginning.
    ///
    /// # Errors
    /// As `out`; [`io::ErrorKind::InvalidInput`] where [`MovingFormat::check`] is an error.
    #[cfg_attr(
        not(feature = "film"),
        expect(unused_variables, reason = "only a film has room kept for `pictures`")
    )]
    pub fn new(format: MovingFormat, out: W, size: [u32; 2], pictures: u32, rate: f64) -> io::Result<Self> {
        Ok(match format {
            MovingFormat::WebP => Self::WebP(AnimatedWebP::new(out, size, rate)?),
            #[cfg(feature = "film")]
            MovingFormat::Film => Self::Film(Box::new(Film::new(out, size, pictures, rate)?)),
        })
    }

    /// The next picture.
    ///
    /// # Errors
    /// As what is written to; [`io::ErrorKind::InvalidInput`] if its size is another.
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
    /// As what is written to, or if pictures are missing.
    pub fn finish(self) -> io::Result<()> {
        match self {
            Self::WebP(webp) => webp.finish(),
            #[cfg(feature = "film")]
            Self::Film(film) => film.finish(),
        }
    }
}
