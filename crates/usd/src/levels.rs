//! Levels of detail as variants: a layer that refers to a file for each level.

use super::build::prim;
use super::layer::{Fields, Prim, Reference, Value};
use super::read::{default_prim, open, open_animation};
use super::stitch::{asset, folder_of};
use super::write::{Encoding, write_variants};
use rhytid_core::{Error, Reach, Result, human, refuse_inputs};
use rhytid_export::Summary;
use std::path::{Path, PathBuf};

/// The variant set. Its variants are `LOD0`, `LOD1` and so on.
pub(crate) const SET: &str = "LOD";

/// What [`levels`] wrote.
#[derive(Debug, Clone, PartialEq)]
pub struct Levels {
    /// Bytes of the file, without those that it refers to.
    pub bytes: u64,
    /// The names of the variants, as many as files.
    pub variants: Vec<String>,
    /// The frames of each level.
    pub frames: usize,
    /// The time codes of the first and the last frame.
    pub time_codes: [f64; 2],
}

/// Writes a USD file with a variant for each of `files`, which are one take on several levels of detail. The
/// whole face comes first. It is what plays where nobody selects a level. The files stay where they are.
///
/// # Errors
/// [`Error::Input`] for fewer than two files, a file that cannot be read or that differs from the first in
/// frames, rate, unit or up axis, or one with more vertices than the one before it. Also if `output` is not
/// `.usda`, cannot be written or is one of the files. [`Error::Io`].
pub fn levels(files: &[PathBuf], output: &Path) -> Result<Levels> {
    if Encoding::from_extension(output) != Some(Encoding::Text) {
        return Err(Error::unsupported_format(format!(
            "{}: levels are put together as text; choose a name that ends with .usda",
            output.display()
        )));
    }
    let [whole, _, ..] = files else {
        return Err(Error::empty("levels need two files at least: the whole face, then each of its levels"));
    };
    refuse_inputs(&[output], files.iter().map(PathBuf::as_path))?;
    let folder = folder_of(output)?;
    let first = open_animation(whole, Reach::Anywhere, None)?.summary().clone();
    let mut references = Vec::new();
    let mut vertices = first.vertices;
    for path in files {
        let own = open_animation(path, Reach::Anywhere, None)?.summary().clone();
        if let Some(difference) = difference(&first, &own) {
            let (path, whole) = (path.display(), whole.display());
            return Err(Error::mismatch(format!(
                "{path} and {whole} are not levels of one animation: {difference}; export both with the same \
                 take and settings"
            )));
        }
        if own.vertices > vertices {
            return Err(Error::conflict(format!(
                "{}: has {} vertices, and the level before it has {}; name the whole face first, then its levels",
                path.display(),
                human::count(own.vertices),
                human::count(vertices)
            )));
        }
        vertices = own.vertices;
        let layer = open(path)?.layer;
        let Some(face) = default_prim(&layer) else {
            return Err(Error::Internal(format!("{}: has lost its default prim", path.display())));
        };
        let asset = asset(path, &folder_of(path)?, &folder)?;
        references.push((face.type_name.clone(), Reference { asset, prim: format!("/{}", face.name) }));
    }
    let layer = open(whole)?.layer;
    let name = references[0].1.prim[1..].to_owned();
    let variants: Vec<String> = (0..files.len()).map(|level| format!("LOD{level}")).collect();
    let metadata = vec![
        ("variants".into(), Value::Dictionary(vec![(SET.into(), Value::String(variants[0].clone()))])),
        ("variantSets".into(), Value::PrependedTokens(vec![SET.into()])),
    ];
    let of_level = |(name, (_, reference)): (&String, &(String, Reference))| {
        let references = Value::PrependedReferences(vec![reference.clone()]);
        (name.clone(), vec![("references".to_owned(), references)])
    };
    let of_levels: Vec<(String, Fields)> = variants.iter().zip(&references).map(of_level).collect();
    let root = Prim { metadata, ..prim(&references[0].0, &name) };
    let bytes = write_variants(output, &layer.metadata, &root, SET, &of_levels)?;
    let time_codes = [first.first_time_code, first.time_code(first.frames - 1)];
    Ok(Levels { bytes, variants, frames: first.frames, time_codes })
}

/// What is different about an animation that should be a level of another one; `None` if nothing is.
fn difference(whole: &Summary, level: &Summary) -> Option<String> {
    let pairs = [
        ("frames", whole.frames as f64, level.frames as f64),
        ("first time code", whole.first_time_code, level.first_time_code),
        ("frames per second", whole.rate, level.rate),
        ("metres per unit", whole.metres_per_unit, level.metres_per_unit),
    ];
    let number = pairs.into_iter().find(|(_, whole, level)| whole != level);
    let number = number.map(|(what, whole, level)| format!("{what}: {level} and {whole}"));
    let axes = || format!("up axis: {:?} and {:?}", level.up_axis, whole.up_axis);
    number.or_else(|| (whole.up_axis != level.up_axis).then(axes))
}
