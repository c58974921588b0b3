//! What is read: a face, a rig, a take.
use rhytid_core::{Result, Rig, rig_file};
use std::path::Path;

/// Reads the project file of a face (`face.toml`) and all that it names. The files have to be in the project's folder or below it:
/// [`project::read`](crate::formats::project::read) takes others too.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) says which file and line is at fault; [`Error::Io`](crate::Error::Io).
#[cfg(feature = "formats")]
pub fn open_face(path: impl AsRef<Path>) -> Result<rhytid_core::Face> {
    rhytid_formats::project::read(path.as_ref(), rhytid_core::Reach::Below)
}

/// Reads a rig that [`write_rig`] or the program wrote.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if it is no rig, or a damaged one; [`Error::Io`](crate::Error::Io).
pub fn open_rig(path: impl AsRef<Path>) -> Result<Rig> {
    rig_file::read(path.as_ref())
}

/// Writes a rig (`.safetensors`). Nothing is left half-written.
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
    /// What becomes of a marker that is missing from a frame of a clean take. By default it is an error.
    pub missing: rhytid_core::Missing,
    /// How a raw take is cleaned.
    pub clean_up: rhytid_playback::CleanUp,
    /// Who is told how far it is, and can stop it.
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

/// Reads a take for a rig: a clean one (CSV) as it is, a capture system's (C3D, TRC, CSV) cleaned.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) says what is wrong in the file, which markers are missing, or what the clean-up leaves open;
/// [`Error::Io`](crate::Error::Io).
#[cfg(feature = "playback")]
pub fn open_take(path: impl AsRef<Path>, rig: &Rig, options: &TakeOptions<'_>) -> Result<rhytid_core::Take> {
    rhytid_playback::read_take(path.as_ref(), rig, options.missing, &options.clean_up, options.progress)
}
