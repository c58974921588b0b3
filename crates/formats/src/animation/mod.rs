//! Animation files of any format, chosen by their extension: written frame by frame ([`create`]) and read
//! back ([`open`]). Meshes with shapes are written by [`write_shapes`].
//!
//! ```no_run
//! # use rhytid_core::{NoProgress, Result, channel};
//! # use rhytid_formats::animation;
//! # use rhytid_formats::export::{Frame, Scene};
//! # fn demo(scene: &Scene<'_>, frames: &[[Vec<f32>; 2]]) -> Result<()> {
//! let mut exporter = animation::create("face.usd".as_ref(), scene, &Default::default())?;
//! for [positions, normals] in frames {
//!     exporter.frame(&Frame::new(positions).with(&channel::NORMALS, normals))?;
//! }
//! let written = exporter.finish(&NoProgress)?;
//! println!("{} bytes", written.bytes);
//! # Ok(())
//! # }
//! ```
//! `docs/export.md` says what each format holds and how to open it.

mod checked;
mod weight_table;

use crate::pc2::PointCache;
use checked::Checked;
use rhytid_core::Reach;
use rhytid_core::channel::{self, Channel};
use rhytid_core::{ChannelKind, Error, Progress, Remedy, Result};
use rhytid_export::{AnimationReader, Exporter, Options, Scene, Shapes, Written, is_prim_name};
use rhytid_gltf::Attribute;
use rhytid_gltf::write::{self as gltf, Kind};
use rhytid_usd::{read, write as usd};
use std::path::Path;
use weight_table::WeightTable;

/// The formats that animations are in.
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
    /// glTF text, `.gltf`, with its buffer beside it as `NAME.HASH.bin`.
    Gltf,
    /// A point cache, `.pc2`: positions alone, for a mesh that the other program already has.
    Pc2,
    /// A table of curves, `.csv`: the weights of given shapes.
    Csv,
}

impl Format {
    /// The format that the extension of `path` asks for, in either case.
    ///
    /// # Errors
    /// [`Error::Input`] if it is no known extension; the message lists the known ones.
    pub fn from_extension(path: &Path) -> Result<Self> {
        match usd::Encoding::from_extension(path) {
            Some(usd::Encoding::Crate) => return Ok(Self::Usdc),
            Some(usd::Encoding::Text) => return Ok(Self::Usda),
            Some(usd::Encoding::Package) => return Ok(Self::Usdz),
            None => {}
        }
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        match extension.to_ascii_lowercase().as_str() {
            "glb" => Ok(Self::Glb),
            "gltf" => Ok(Self::Gltf),
            "pc2" => Ok(Self::Pc2),
            "csv" => Ok(Self::Csv),
            _ => Err(Error::unsupported_format(format!(
                "{}: animation is written as .usd, .usdc, .usda, .usdz, .glb, .gltf or .pc2, and weights of given \
                 shapes as .csv, found the extension “{extension}”",
                path.display()
            ))),
        }
    }
}

impl Format {
    /// Whether animations of this format have a place for these channels.
    pub fn carries(self, kind: ChannelKind) -> bool {
        match self {
            Self::Usdc | Self::Usda | Self::Usdz => true,
            Self::Glb | Self::Gltf => rhytid_gltf::carries(kind),
            Self::Pc2 | Self::Csv => false,
        }
    }

    /// The channels that a file stores of frames with `channels`; `fitted` if the frames are sums of few
    /// shapes.
    pub fn stored(self, channels: &[Channel], fitted: bool) -> Vec<Channel> {
        let is_normals = |channel: &&Channel| channel.name == channel::NORMALS.name;
        match self {
            Self::Usdc | Self::Usda | Self::Usdz if !fitted => channels.to_vec(),
            Self::Glb | Self::Gltf => {
                let attributes = Attribute::of_channels(channels)
                    .into_iter()
                    .filter(|attribute| !fitted || attribute.can_be_fitted());
                let others = attributes.flat_map(|attribute| attribute.channels);
                channels.iter().filter(is_normals).cloned().chain(others).collect()
            }
            Self::Usdc | Self::Usda | Self::Usdz => channels.iter().filter(is_normals).cloned().collect(),
            Self::Pc2 | Self::Csv => Vec::new(),
        }
    }
}

/// Opens an exporter for `path` by its extension.
///
/// # Errors
/// [`Error::Input`] if the extension is not of a known [`Format`] or the scene is not consistent. Also if the
/// format does not carry one of the channels or has no room for that many frames, or the folder does not
/// exist. [`Error::Io`].
pub fn create(path: &Path, scene: &Scene<'_>, options: &Options) -> Result<Box<dyn Exporter>> {
    let format = Format::from_extension(path)?;
    scene.check()?;
    let has_place = |channel: &&Channel| match channel.kind {
        Some(kind) => format.carries(kind),
        None => !matches!(format, Format::Pc2 | Format::Csv),
    };
    if let Some(channel) = scene.channels.iter().find(|channel| !has_place(channel)) {
        return Err(Error::unsupported_format(format!(
            "{}: has no place for {}; leave them out, or write .usd",
            path.display(),
            channel.words
        )));
    }
    check_clips(path, scene.clips().len(), options)?;
    let exporter: Box<dyn Exporter> = match format {
        Format::Usdc => create_usd(path, usd::Encoding::Crate, scene, options)?,
        Format::Usda => create_usd(path, usd::Encoding::Text, scene, options)?,
        Format::Usdz => create_usd(path, usd::Encoding::Package, scene, options)?,
        Format::Glb => gltf::create(path, Kind::Glb, scene, options)?,
        Format::Gltf => gltf::create(path, Kind::Gltf, scene, options)?,
        Format::Pc2 => Box::new(PointCache::create(path, scene)?),
        Format::Csv => Box::new(WeightTable::create(path, scene, options)?),
    };
    Ok(Box::new(Checked::new(exporter, path, scene)))
}

/// Whether a file at `path` may hold `clips` clips, before there are frames. Several clips share shapes: what
/// moves without shapes has one clip.
///
/// # Errors
/// [`Error::Input`] if the extension is not of a known [`Format`], or the format has no place for the clips.
pub fn check_clips(path: &Path, clips: usize, options: &Options) -> Result<()> {
    let fits = match Format::from_extension(path)? {
        Format::Pc2 | Format::Csv => false,
        Format::Glb | Format::Gltf => {
            options.max_error.is_some() || options.shapes.is_some() || options.onto.is_some()
        }
        Format::Usdc | Format::Usda | Format::Usdz => options.shapes.is_some() || options.onto.is_some(),
    };
    if clips <= 1 || fits {
        return Ok(());
    }
    let what = match Format::from_extension(path)? {
        Format::Pc2 => "a point cache holds one take; write .usd or .glb with few shapes for all takes",
        Format::Csv => "a table of weights holds one take; write .usd or .glb with few shapes for all takes",
        _ => "holds one take where each frame is exact; write few shapes for all takes",
    };
    let sentence = format!("{}: {what}, or write the takes one by one", path.display());
    Err(Error::conflict(sentence).with_remedies(&[Remedy::FewShapes]))
}

fn create_usd(
    path: &Path,
    encoding: usd::Encoding,
    scene: &Scene<'_>,
    options: &Options,
) -> Result<Box<dyn Exporter>> {
    check_mesh_name(path, options)?;
    let goal = usd::Goal::of(options);
    if options.over && goal.is_some() {
        return Err(Error::conflict(format!(
            "{}: a layer over another has samples alone, and shapes with curves are more; leave one out",
            path.display()
        ))
        .with_remedies(&[Remedy::NoShapes]));
    }
    Ok(match goal {
        Some(goal) => Box::new(usd::Baked::create(path, encoding, scene, options, goal)?),
        None => Box::new(usd::Face::create(path, encoding, scene, options)?),
    })
}

fn check_mesh_name(path: &Path, options: &Options) -> Result<()> {
    match options.mesh_name.as_ref().filter(|name| !is_prim_name(name)) {
        Some(name) => Err(Error::bad_path(format!(
            "{}: the mesh is to be called “{name}”, expected ASCII letters, digits and underscores, not beginning \
             with a digit",
            path.display()
        ))),
        None => Ok(()),
    }
}

/// Whether a file at `path` may hold `count` shapes, before they are made.
///
/// # Errors
/// [`Error::Input`] if the extension is not of a known [`Format`], or the format has no room for them.
pub fn check_shapes(path: &Path, count: usize, options: &Options) -> Result<()> {
    match Format::from_extension(path)? {
        Format::Usdc | Format::Usda | Format::Usdz => check_mesh_name(path, options),
        Format::Glb | Format::Gltf => gltf::check_count(path, count, options),
        Format::Pc2 => Err(without_shapes(path, "a point cache")),
        Format::Csv => Err(without_shapes(path, "a table")),
    }
}

fn without_shapes(path: &Path, what: &str) -> Error {
    Error::unsupported_format(format!("{}: {what} has no sliders; write .usd or .glb", path.display()))
}

/// Writes a mesh with shapes to `path`, in the format of its extension. Nothing is written if it fails.
///
/// # Errors
/// [`Error::Input`] if the extension is not of a known [`Format`], or the shapes are not consistent. Also if
/// the folder does not exist or the format has no room for the shapes. [`Error::Io`]; [`Error::Cancelled`].
pub fn write_shapes(
    path: &Path,
    shapes: &Shapes<'_>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Written> {
    let format = Format::from_extension(path)?;
    shapes.check()?;
    let usd = |encoding| {
        check_mesh_name(path, options)?;
        let bytes = usd::write_shapes(path, encoding, shapes, options)?;
        Ok(Written { bytes, targets: Some(shapes.shapes.len()), errors: Vec::new() })
    };
    match format {
        Format::Usdc => usd(usd::Encoding::Crate),
        Format::Usda => usd(usd::Encoding::Text),
        Format::Usdz => usd(usd::Encoding::Package),
        Format::Glb => gltf::write_shapes(path, Kind::Glb, shapes, options, progress),
        Format::Gltf => gltf::write_shapes(path, Kind::Gltf, shapes, options, progress),
        Format::Pc2 => Err(without_shapes(path, "a point cache")),
        Format::Csv => Err(without_shapes(path, "a table")),
    }
}

/// Opens the animation in the format of the extension of `path`. If the file was stitched, its parts have to
/// be below its folder. Of several clips, it is the first.
///
/// # Errors
/// [`Error::Input`] if the extension is of no known format, the file is damaged, or it holds anything but one
/// animated mesh; [`Error::Io`].
pub fn open(path: &Path) -> Result<Box<dyn AnimationReader>> {
    open_within(path, Reach::Below)
}

/// As [`open`], with the parts within `reach`.
///
/// # Errors
/// As [`open`].
pub fn open_within(path: &Path, reach: Reach) -> Result<Box<dyn AnimationReader>> {
    open_clip(path, reach, None)
}

/// As [`open_within`]; of several clips the one called `clip`.
///
/// # Errors
/// As [`open`], and [`Error::Input`] if there is no such clip.
pub fn open_clip(path: &Path, reach: Reach, clip: Option<&str>) -> Result<Box<dyn AnimationReader>> {
    match Format::from_extension(path)? {
        Format::Usdc | Format::Usda | Format::Usdz => read::open_animation(path, reach, clip),
        Format::Glb | Format::Gltf => rhytid_gltf::read::open(path, clip),
        Format::Csv => Err(Error::unsupported_format(format!(
            "{}: animation is read from .usd, .usdc, .usda, .usdz, .glb or .gltf, found the extension “csv”",
            path.display()
        ))),
        Format::Pc2 => Err(Error::unsupported_format(format!(
            "{}: is a point cache, which holds points alone, without faces, unit, frame rate or recipe, and \
             cannot be read; give a .usd of the same take",
            path.display()
        ))),
    }
}
