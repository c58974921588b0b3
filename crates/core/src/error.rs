//! Errors, by who can do something about them.
use std::path::{Path, PathBuf};

/// What every fallible function of Rhytid returns.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Everything that can go wrong, told apart by who can do something about it.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The input is at fault. One sentence: which file, which line or element, what was found, what was
    /// expected and what to do.
    #[error("{0}")]
    Input(String),
    /// A file could not be opened, read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// A device failed in a way its caller could not foresee.
    #[error("{device}: {message}")]
    Device {
        /// What failed.
        kind: DeviceErrorKind,
        /// `backend:index`, or the backend's name where no device was reached.
        device: String,
        /// The driver's words, or a build log.
        message: String,
    },
    /// The caller asked to stop (see [`crate::Progress::cancelled`]). Nothing was written.
    #[error("stopped before the end; nothing was written")]
    Cancelled,
    /// A fault of Rhytid's own.
    #[error("internal error: {0}; please report it")]
    Internal(String),
}

/// The ways in which a device can fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeviceErrorKind {
    /// No such device here.
    NotFound,
    /// The device lacks a feature or a limit that the rig needs.
    Unsupported,
    /// The device's memory does not suffice.
    OutOfMemory,
    /// The device was reset, unplugged or taken away.
    Lost,
    /// A kernel did not build.
    Build,
    /// Any other error of the driver.
    Driver,
}

impl Error {
    /// An [`Error::Input`] from anything that can be printed.
    pub fn input(message: impl Into<String>) -> Self {
        Self::Input(message.into())
    }

    /// The same error where it was found in a file, which an [`Error::Input`] does not name yet; others are as they were.
    #[must_use]
    pub fn in_file(self, name: impl std::fmt::Display) -> Self {
        match self {
            Self::Input(message) => Self::Input(format!("{name}: {message}")),
            other => other,
        }
    }

    /// For `map_err`: an [`Error::Io`] that names `path`.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::Io { path, source }
    }
}
