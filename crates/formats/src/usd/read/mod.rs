//! USD layers in: crate files, text, and the first layer of a package. A layer is read whole except for its time
//! samples, which are read one at a time.
//!
//! What is understood is what Rhytid writes, and the same again after USD's own tools wrote it. Of other layers,
//! metadata and values of types that [`Value`] does not have are left out, and so are variants and
//! classes. Nothing in a file is trusted: every count is checked against the bytes that are there.

mod animation;
mod budget;
mod crate_file;
mod lookup;
mod package;
mod parts;
mod source;
mod text;

use super::clips::{self, Clips};
use super::layer::{Layer, Value};
use crate::recording::Recording;
use animation::Animation;
use rhytid_core::{Error, Result};
use source::Source;
use std::io::Cursor;
use std::path::Path;

pub(super) use lookup::{default_prim, dictionary, field};
pub(super) use parts::Parts;

/// How deep prims may be within prims.
const MOST_PRIMS_DEEP: usize = 64;

/// A layer, and its time samples to be read.
pub struct Opened {
    /// All but the samples. Attributes that have some are numbered from 0.
    pub layer: Layer,
    /// The samples by these numbers.
    pub samples: Box<dyn Samples>,
}

/// The time samples of a layer. Memory does not grow with what they hold.
pub trait Samples: Send {
    /// The time codes of the attribute numbered `n`, ascending.
    fn times(&self, n: usize) -> &[f64];

    /// The value at the `i`-th of [`Samples::times`].
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`] if the value is blocked, of a type that [`Value`] does not have or damaged;
    /// [`rhytid_core::Error::Io`].
    fn read(&mut self, n: usize, i: usize) -> Result<Value>;
}

/// Opens a crate file, text or a package, told apart by their first bytes.
///
/// # Errors
/// [`rhytid_core::Error::Input`] if it is none of these or damaged; [`rhytid_core::Error::Io`].
pub fn open(path: &Path) -> Result<Opened> {
    of_source(Source::open(path)?)
}

/// The same of a file's `bytes`; `name` is for messages.
///
/// # Errors
/// As [`open`].
pub fn decode(bytes: Vec<u8>, name: &str) -> Result<Opened> {
    of_source(Source::new(Box::new(Cursor::new(bytes)), name.to_owned())?)
}

fn of_source(mut source: Source) -> Result<Opened> {
    let mut first = [0; 8];
    let read = source.read_some(0, &mut first)?;
    match &first[..read] {
        b"PXR-USDC" => crate_file::open(source),
        [b'P', b'K', 3, 4, ..] => package::open(source),
        b"#usda 1." => text::open(source),
        [] => Err(source.wrong("is empty, expected a USD file; export it again")),
        _ => Err(source.wrong(
            "begins neither as binary USD (PXR-USDC) nor as text (#usda 1.0) nor as a package (zip); is it a USD file?",
        )),
    }
}

/// The animation that one file's `bytes` hold; `name` is for messages.
///
/// # Errors
/// As [`open`], and [`Error::Input`] if there is anything but one animated mesh.
pub fn decode_recording(bytes: Vec<u8>, name: &str) -> Result<Box<dyn Recording>> {
    Ok(Box::new(Animation::new(decode(bytes, name)?, name.to_owned())?))
}

/// Opens the animation in the file `path`, whether it is in there or in parts that the file plays.
///
/// # Errors
/// [`Error::Input`] if a file is damaged or holds anything but one animated mesh; [`Error::Io`].
pub(crate) fn recording(path: &Path) -> Result<Box<dyn Recording>> {
    let name = path.display().to_string();
    let opened = open(path)?;
    let Some(Clips { assets, manifest }) = clips::clips(&opened.layer) else {
        return Ok(Box::new(Animation::new(opened, name)?));
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let paths: Vec<_> = assets.iter().map(|asset| folder.join(asset)).collect();
    let parts = Parts::open(&paths)?;
    // The parts may have been written anew since, and so may the manifest, for a file that was renamed.
    let root = default_prim(&opened.layer);
    if parts.summary().origin != root.and_then(lookup::origin) {
        return Err(Error::input(format!(
            "{name}: its parts are others than when they were stitched; stitch them again"
        )));
    }
    let manifest = folder.join(manifest);
    if !manifest.exists() {
        return Err(Error::input(format!(
            "{name}: its manifest {} is not there, without which USD plays the first part only; stitch the parts again",
            manifest.display()
        )));
    }
    let first = open(&parts.parts()[0].path)?.layer;
    if let Some(undeclared) = clips::undeclared(&first, &open(&manifest)?.layer) {
        return Err(Error::input(format!(
            "{}: does not declare {undeclared}, which has samples in the parts of {name}; stitch them again",
            manifest.display()
        )));
    }
    Ok(Box::new(parts))
}
