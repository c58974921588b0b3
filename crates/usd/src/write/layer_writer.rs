//! A layer on its way to a file, in any of the encodings.

use super::crate_file::CrateWriter;
use super::package::PackageWriter;
use super::sample::Sample;
use super::text::TextWriter;
use crate::layer::Layer;
use rhytid_core::{AtomicFile, Error, Result};
use std::path::{Path, PathBuf};

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
        let file = AtomicFile::create(path)?;
        let to = match encoding {
            Encoding::Text => To::Text(Box::new(TextWriter::create(file, layer)?)),
            Encoding::Crate => {
                To::Crate(Box::new(CrateWriter::create(file, layer).map_err(Error::io(path))?))
            }
            Encoding::Package => To::Package(Box::new(PackageWriter::create(file, layer)?)),
        };
        Ok(Self { path: path.to_owned(), to })
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

    /// Writes what remains, gives the file its name, and returns its size in bytes.
    ///
    /// # Errors
    /// As [`LayerWriter::sample`].
    pub fn finish(self) -> Result<u64> {
        match self.to {
            To::Text(writer) => writer.finish(),
            To::Crate(writer) => {
                let (file, size) = writer.finish().map_err(Error::io(&self.path))?;
                file.finish()?;
                Ok(size)
            }
            To::Package(writer) => writer.finish(),
        }
    }
}
