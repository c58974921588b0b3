//! Reading of a face, a rig or a take.
use rhytid_core::{Result, Rig, rig_file};
use std::path::Path;

/// Reads the project file of a face (`face.toml`) and all that it names. The files have to be in the
/// project's folder or below it. [`project::read`](crate::formats::project::read) can also read others. A
/// prior that is the rig of another face is read by `rhytid::transfer::read_face`.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input), which names the file and the line. [`Error::Io`](crate::Error::Io).
#[cfg(feature = "formats")]
pub fn open_face(path: impl AsRef<Path>) -> Result<rhytid_core::Face> {
    rhytid_formats::project::read(path.as_ref(), rhytid_core::Reach::Below)
}

/// Reads a rig that [`write_rig`] or the command-line program wrote.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if the file is no rig, or a damaged one.
/// [`Error::Io`](crate::Error::Io).
pub fn open_rig(path: impl AsRef<Path>) -> Result<Rig> {
    rig_file::read(path.as_ref())
}

/// Writes a rig (`.safetensors`). A failed write leaves no partial file.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if the folder is not there; [`Error::Io`](crate::Error::Io).
pub fn write_rig(path: impl AsRef<Path>, rig: &Rig) -> Result<()> {
    rig_file::write(path.as_ref(), rig)
}

/// How a take is read.
#[cfg(feature = "playback")]
#[derive(Clone)]
pub struct TakeOptions<'a> {
    /// How a marker that is missing from a frame of a clean take is handled. By default it is an error.
    pub missing: rhytid_core::Missing,
    /// How a raw take is cleaned, in which space a clean one is, and whether noise is taken out.
    pub clean_up: rhytid_playback::CleanUp,
    /// The receiver of progress, which can cancel the work.
    pub progress: &'a dyn rhytid_core::Progress,
}

#[cfg(feature = "playback")]
impl Default for TakeOptions<'_> {
    fn default() -> Self {
        Self {
            missing: rhytid_core::Missing::default(),
            clean_up: rhytid_playback::CleanUp::default(),
            progress: &rhytid_core::NoProgress,
        }
    }
}

/// Reads a take for a rig. A clean take (CSV) is read as it is. A take of a capture system (C3D, TRC, CSV) is
/// cleaned. What is likely wrong is a warning of `options.progress`.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) for a fault in the file, for missing markers, for a clean take that
/// is plainly in another unit or with other axes, or for gaps that the clean-up leaves.
/// [`Error::Io`](crate::Error::Io).
#[cfg(feature = "playback")]
pub fn open_take(path: impl AsRef<Path>, rig: &Rig, options: &TakeOptions<'_>) -> Result<rhytid_core::Take> {
    let TakeOptions { missing, clean_up, progress } = options;
    Ok(rhytid_playback::read_take(path.as_ref(), rig, *missing, clean_up, *progress)?.take)
}
