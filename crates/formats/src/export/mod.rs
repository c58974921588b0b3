//! Animation out: one [`Exporter`] per file format, fed frame by frame.
//!
//! ```no_run
//! # use rhytid_core::{NoProgress, Result};
//! # use rhytid_formats::export::{self, Frame, Scene};
//! # fn demo(scene: &Scene<'_>, frames: &[[Vec<f32>; 2]]) -> Result<()> {
//! let mut exporter = export::create("face.usd".as_ref(), scene, &Default::default())?;
//! for [positions, normals] in frames {
//!     exporter.frame(Frame { positions, normals: Some(normals), velocities: None })?;
//! }
//! let written = exporter.finish(&NoProgress)?;
//! println!("{} bytes", written.bytes);
//! # Ok(())
//! # }
//! ```
//! `docs/export.md` says what each format holds and how to open it.

mod checked;
mod origin;
mod scene;
mod shapes;

use crate::gltf::write as gltf;
use crate::usd;
use rhytid_core::{Error, Progress, Result};
use std::path::Path;

pub use origin::Origin;
pub use scene::Scene;
pub use shapes::{Shape, Shapes};

/// One frame of an animation.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    /// 3V positions in mesh units.
    pub positions: &'a [f32],
    /// 3V normals of length 1 (or 0), if the scene has normals.
    pub normals: Option<&'a [f32]>,
    /// 3V velocities in mesh units per second, if the scene has velocities.
    pub velocities: Option<&'a [f32]>,
}

/// One animation file being written. Memory does not grow with the frames' data, or by a gigabyte where they are
/// compressed.
pub trait Exporter: Send {
    /// Adds the next frame.
    ///
    /// # Errors
    /// [`Error::Input`] if a length is wrong, a number is not finite or the frame is one too many;
    /// [`Error::Io`].
    fn frame(&mut self, frame: Frame<'_>) -> Result<()>;

    /// Writes what remains and gives the file its name. Dropped without it, nothing is left behind, and what
    /// stood under the name before is untouched.
    ///
    /// # Errors
    /// [`Error::Input`] if frames are missing or the options' bound cannot be met; [`Error::Io`];
    /// [`Error::Cancelled`].
    fn finish(self: Box<Self>, progress: &dyn Progress) -> Result<Written>;
}

/// What was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// Bytes of all files together.
    pub bytes: u64,
    /// Morph targets, in a format that has them.
    pub targets: Option<usize>,
    /// How far the file is from the frames that came in; `None` where it has every bit of them.
    pub error: Option<Deviation>,
}

/// How far one animation of a mesh is from another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// The largest distance of a vertex from its place in any frame, in mesh units.
    pub worst: f64,
    /// The frame, counted from 0, and the vertex of the largest distance.
    pub at: (usize, usize),
    /// The root mean square of all distances, in mesh units.
    pub rms: f64,
}

/// The choices of those formats that have any. All others ignore them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// glTF: as few morph targets as the largest deviation that this allows, in mesh units. `None` writes a target
    /// for each frame.
    pub max_error: Option<f64>,
    /// glTF: integers of 8 and 16 bits (KHR_mesh_quantization).
    pub quantize: bool,
    /// glTF: compressed buffers (EXT_meshopt_compression).
    pub meshopt: bool,
    /// glTF: also more than 256 targets or 1 GiB.
    pub force: bool,
}

/// The formats that can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Binary USD, `.usd` or `.usdc`.
    Usdc,
    /// USD text, `.usda`.
    Usda,
    /// Binary USD in a package, `.usdz`.
    Usdz,
    /// Binary glTF, `.glb`.
    Glb,
    /// glTF text, `.gltf`, with its buffer beside it as `.bin`.
    Gltf,
}

impl Format {
    /// The format that the extension of `path` asks for, in either case.
    ///
    /// # Errors
    /// [`Error::Input`] lists the extensions if it is none of them.
    pub fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        match extension.to_ascii_lowercase().as_str() {
            "usd" | "usdc" => Ok(Self::Usdc),
            "usda" => Ok(Self::Usda),
            "usdz" => Ok(Self::Usdz),
            "glb" => Ok(Self::Glb),
            "gltf" => Ok(Self::Gltf),
            _ => Err(Error::input(format!(
                "{}: animation is written as .usd, .usdc, .usda, .usdz, .glb or .gltf, found the extension \
                 “{extension}”",
                path.display()
            ))),
        }
    }
}

/// Opens an exporter for `path` by its extension.
///
/// # Errors
/// [`Error::Input`] if the extension is not of a known [`Format`], the scene is not consistent, the folder does not
/// exist or the format has no room for that many frames; [`Error::Io`].
pub fn create(path: &Path, scene: &Scene<'_>, options: &Options) -> Result<Box<dyn Exporter>> {
    let format = Format::of(path)?;
    scene.check()?;
    let exporter: Box<dyn Exporter> = match format {
        Format::Usdc => Box::new(usd::Face::create(path, usd::Encoding::Crate, scene)?),
        Format::Usda => Box::new(usd::Face::create(path, usd::Encoding::Text, scene)?),
        Format::Usdz => Box::new(usd::Face::create(path, usd::Encoding::Package, scene)?),
        Format::Glb => gltf::create(path, gltf::Format::Glb, scene, options)?,
        Format::Gltf => gltf::create(path, gltf::Format::Gltf, scene, options)?,
    };
    Ok(Box::new(checked::Checked::new(exporter, path, scene)))
}

/// Writes a mesh with shapes to `path`, in the format of its extension. Nothing is written if it fails.
///
/// # Errors
/// [`Error::Input`] if the extension is not of a known [`Format`], the shapes are not consistent, the folder does not
/// exist or the format has no room for them; [`Error::Io`]; [`Error::Cancelled`].
pub fn write_shapes(
    path: &Path,
    shapes: &Shapes<'_>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Written> {
    let format = Format::of(path)?;
    shapes.check()?;
    let usd = |encoding| {
        let bytes = usd::write_shapes(path, encoding, shapes)?;
        Ok(Written { bytes, targets: Some(shapes.shapes.len()), error: None })
    };
    match format {
        Format::Usdc => usd(usd::Encoding::Crate),
        Format::Usda => usd(usd::Encoding::Text),
        Format::Usdz => usd(usd::Encoding::Package),
        Format::Glb => gltf::write_shapes(path, gltf::Format::Glb, shapes, options, progress),
        Format::Gltf => gltf::write_shapes(path, gltf::Format::Gltf, shapes, options, progress),
    }
}
