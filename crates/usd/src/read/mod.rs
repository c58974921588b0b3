//! USD layers in: crate files, text, and the first layer of a package. A layer is read whole except for its
//! time samples, which are read one at a time.
//!
//! The readers understand what Rhytid writes, also after USD's own tools have written it again. From other
//! layers, they leave out metadata and values of types that [`Value`](super::layer::Value) does not have,
//! variants and classes. Nothing in a file is trusted: every count is checked against the bytes that are
//! there.

mod animation;
mod budget;
mod clips;
mod crate_file;
mod images;
mod lookup;
mod open;
mod opened;
mod package;
mod parts;
mod primvar;
mod shapes;
mod source;
mod text;

use crate::compare::differences;
use crate::stitch::{declarations_of, whole};
use animation::Animation;
use clips::{Clips, undeclared};
use lookup::stated_recipe;
use rhytid_core::{Error, InputErrorKind, Reach, Result, named_file};
use rhytid_export::AnimationReader;
use std::path::{Path, PathBuf};

pub(super) use clips::{clips, declarations};
pub(super) use lookup::{SCALE, default_prim, face_of};
pub use lookup::{attribute, field};
pub use open::{decode, open};
pub use opened::{Opened, Samples};
pub use package::package_member;
pub(super) use parts::Parts;
pub use primvar::read_primvar;

/// The animation that one file's `bytes` hold; `name` is for messages.
///
/// # Errors
/// As [`open()`], and [`Error::Input`] if there is anything but one animated mesh.
pub fn decode_animation(bytes: Vec<u8>, name: &str) -> Result<Box<dyn AnimationReader>> {
    Ok(Box::new(Animation::new(decode(bytes, name)?, name.to_owned(), None, None)?))
}

/// Opens the animation in the file `path`, whether it is in there or in parts within `reach` that the file
/// plays. Of several clips, it is the one called `clip`, else the first.
///
/// # Errors
/// [`Error::Input`] if a file is damaged, holds anything but one animated mesh, or has no such clip;
/// [`Error::Io`].
pub fn open_animation(path: &Path, reach: Reach, clip: Option<&str>) -> Result<Box<dyn AnimationReader>> {
    let name = path.display().to_string();
    let opened = open(path)?;
    let Some(Clips { assets, manifest }) = clips(&opened.layer) else {
        return Ok(Box::new(Animation::new(opened, name, Some(path), clip)?));
    };
    let named = |asset: &str, what| named_file(path, Path::new(asset), what, reach);
    let paths: Vec<PathBuf> = assets.iter().map(|asset| named(asset, "assetPaths")).collect::<Result<_>>()?;
    let parts = Parts::open(&paths)?;
    // The parts may have been written anew since, and so may the manifest, for a file that was renamed.
    let root = default_prim(&opened.layer);
    if parts.summary().recipe != root.and_then(stated_recipe) {
        return Err(Error::mismatch(format!(
            "{name}: its parts have changed since they were stitched; stitch them again"
        )));
    }
    let clips_manifest = manifest.to_owned();
    let manifest = named(manifest, "manifestAssetPath")?;
    if !manifest.exists() {
        return Err(Error::mismatch(format!(
            "{name}: its manifest {} is not there, so USD would play only the first part; stitch the parts \
             again",
            manifest.display()
        ))
        .of_kind(InputErrorKind::NotThere { file: manifest.clone() }));
    }
    let first = open(&parts.parts()[0].path)?.layer;
    let declared = open(&manifest)?;
    if let Some(undeclared) = undeclared(&first, &declared.layer) {
        return Err(Error::mismatch(format!(
            "{}: does not declare {undeclared}, which has samples in the parts of {name}; stitch them again",
            manifest.display()
        )));
    }
    let place = |part: &PathBuf| paths.iter().position(|path| path == part);
    let in_order = parts.parts().iter().filter_map(|part| Some(assets[place(&part.path)?].clone()));
    let expected = whole(&first, parts.summary(), &parts, clips_manifest, in_order.collect())?;
    let mut found = differences(&opened.layer, &opened.unread, &expected);
    let of_manifest = differences(&declared.layer, &declared.unread, &declarations_of(&first));
    found.extend(of_manifest.into_iter().map(|what| format!("{}: {what}", manifest.display())));
    Ok(Box::new(parts.stitched(found)))
}
