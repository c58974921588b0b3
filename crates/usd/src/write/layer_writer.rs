//! A layer on its way to a file, in any of the encodings.

use super::crate_file::CrateWriter;
use super::package::PackageWriter;
use super::sample::Sample;
use super::text::TextWriter;
use crate::layer::Layer;
use rhytid_core::{AtomicFile, Error, Result};
use rhytid_export::companion::{Companion, finish_all};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The files that a layer can be written to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Text, `.usda`.
    Text,
    /// Binary, `.usd` or `.usdc`.
    Crate,
    /// Binary in a package, `.usdz`.
    Package,
}

impl Encoding {
    /// The one that the extension of `path` asks for, in either case; `None` for any other extension.
    pub fn from_extension(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "usd" | "usdc" => Some(Self::Crate),
            "usda" => Some(Self::Text),
            "usdz" => Some(Self::Package),
            _ => None,
        }
    }
}

/// A layer being written: everything at once, then its time samples one by one. The file gets its name when
/// the layer is finished; a layer that is dropped before leaves nothing behind. Memory does not grow with the
/// size of the samples.
pub struct LayerWriter {
    path: PathBuf,
    to: To,
    beside: Vec<Companion>,
    bytes_beside: u64,
}

/// Other files that a layer refers to, and that are written with it.
#[derive(Default)]
pub(super) struct Attached {
    /// Inside a package, behind the layer.
    pub(super) members: Vec<Member>,
    /// Beside the layer.
    pub(super) beside: Vec<Companion>,
    /// The bytes of all that are beside it.
    pub(super) bytes_beside: u64,
}

/// A file in a package.
pub(super) struct Member {
    /// Its path in the package.
    pub(super) name: String,
    pub(super) bytes: Arc<[u8]>,
}

enum To {
    Text(Box<TextWriter>),
    Crate(Box<CrateWriter<AtomicFile>>),
    Package(Box<PackageWriter>),
}

impl LayerWriter {
    /// Writes everything of `layer` but samples.
    ///
    /// # Errors
    /// [`Error::Input`] if the folder does not exist; [`Error::Io`].
    pub fn create(path: &Path, encoding: Encoding, layer: &Layer) -> Result<Self> {
        Self::with(path, encoding, layer, Attached::default())
    }

    /// As [`LayerWriter::create`], with other files.
    pub(super) fn with(path: &Path, encoding: Encoding, layer: &Layer, attached: Attached) -> Result<Self> {
        let Attached { members, beside, bytes_beside } = attached;
        let file = AtomicFile::create(path)?;
        let to = match encoding {
            Encoding::Text => To::Text(Box::new(TextWriter::create(file, layer)?)),
            Encoding::Crate => {
                To::Crate(Box::new(CrateWriter::create(file, layer).map_err(Error::io(path))?))
            }
            Encoding::Package => To::Package(Box::new(PackageWriter::create(file, layer, members)?)),
        };
        Ok(Self { path: path.to_owned(), to, beside, bytes_beside })
    }

    /// Adds a sample to the attribute that has the number [`crate::layer::Attribute::samples`]. Its times
    /// ascend.
    ///
    /// # Errors
    /// [`Error::Input`] if a package becomes too large; [`Error::Io`].
    pub fn sample(&mut self, number: usize, time: f64, sample: Sample<'_>) -> Result<()> {
        match &mut self.to {
            To::Text(writer) => writer.sample(number, time, sample),
            To::Crate(writer) => writer.sample(number, time, sample).map_err(Error::io(&self.path)),
            To::Package(writer) => writer.sample(number, time, sample),
        }
    }

    /// Writes what remains, gives the file its name, and returns the bytes of all files together.
    ///
    /// # Errors
    /// As [`LayerWriter::sample`].
    pub fn finish(self) -> Result<u64> {
        let Self { path, to, beside, bytes_beside } = self;
        let size = finish_all(beside, || match to {
            To::Text(writer) => writer.finish(),
            To::Crate(writer) => {
                let (file, size) = writer.finish().map_err(Error::io(&path))?;
                file.finish()?;
                Ok(size)
            }
            To::Package(writer) => writer.finish(),
        })?;
        Ok(size + bytes_beside)
    }
}
