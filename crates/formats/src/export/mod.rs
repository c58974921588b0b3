//! Animation out: one [`Exporter`] per file format, fed frame by frame.
//!
//! ```no_run
//! # fn demo(scene: &rhytid_formats::export::Scene<'_>, frame: (Vec<f32>, Vec<f32>)) -> rhytid_core::Result<()> {
//! let mut exporter = rhytid_formats::export::create("face.usda".as_ref(), scene)?;
//! for _ in 0..scene.frames {
//!     exporter.frame(&frame.0, &frame.1)?;
//! }
//! exporter.finish()
//! # }
//! ```
//! `docs/export.md` says what each format holds and how to open it.

mod checked;
mod glb;
mod scene;
mod text;
mod usda;

use rhytid_core::{Error, Result};
use std::path::Path;

pub use scene::Scene;

/// One animation file being written. Memory does not grow with the frames' data.
pub trait Exporter: Send {
    /// Adds the next frame: `positions` in mesh units and `normals` of length 1 (or 0), both V×3.
    ///
    /// # Errors
    /// [`Error::Input`] if a length is wrong, a number is not finite or the frame is one too many;
    /// [`Error::Io`].
    fn frame(&mut self, positions: &[f32], normals: &[f32]) -> Result<()>;

    /// Writes what remains and gives the file its name. Dropped without it, nothing is left behind, and what
    /// stood under the name before is untouched.
    ///
    /// # Errors
    /// [`Error::Input`] if frames are missing; [`Error::Io`].
    fn finish(self: Box<Self>) -> Result<()>;
}

/// The formats that can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// USD text, `.usda`.
    Usda,
    /// Binary glTF, `.glb`.
    Glb,
}

impl Format {
    /// The format that the extension of `path` asks for, in either case.
    ///
    /// # Errors
    /// [`Error::Input`] lists the extensions if it is none of them.
    pub fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        match extension.to_ascii_lowercase().as_str() {
            "usda" => Ok(Self::Usda),
            "glb" => Ok(Self::Glb),
            _ => Err(Error::input(format!(
                "{}: animation is written as .usda or .glb, found the extension “{extension}”",
                path.display()
            ))),
        }
    }
}

/// Opens an exporter for `path` by its extension: `.usda` or `.glb`.
///
/// # Errors
/// [`Error::Input`] if the extension is another, the scene is not consistent, the folder does not exist or the
/// format has no room for that many frames; [`Error::Io`].
pub fn create(path: &Path, scene: &Scene<'_>) -> Result<Box<dyn Exporter>> {
    let format = Format::of(path)?;
    scene.check()?;
    let exporter: Box<dyn Exporter> = match format {
        Format::Usda => Box::new(usda::Usda::create(path, scene)?),
        Format::Glb => Box::new(glb::Glb::create(path, scene)?),
    };
    Ok(Box::new(checked::Checked::new(exporter, path, scene)))
}
