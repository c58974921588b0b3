//! Writes value clips: a layer whose samples are in other files, each active for a range of time codes.
//!
//! USD calls the layers with the samples clips. A further layer, the manifest, declares which attributes have
//! samples. The manifest is a file of its own. A layer that was its own manifest would lose it when it is
//! renamed, and USD would then silently play the first clip only.

use super::build::prim;
use super::layer::{Fields, Layer, Prim, Reference, Value};
use super::read::{Parts, clips, declarations, default_prim, open};
use super::write::{CrateWriter, Encoding, LayerWriter, custom_data};
use rhytid_core::{Error, Result, refuse_inputs};
use rhytid_export::companion::{self, Companion};
use rhytid_export::{AnimationReader, Summary};
use std::ffi::OsStr;
use std::io::Cursor;
use std::path::{Component, Path, PathBuf};

/// What [`stitch`] wrote.
#[derive(Debug, Clone, PartialEq)]
pub struct Stitched {
    /// Bytes of the file, without the parts and the manifest.
    pub bytes: u64,
    /// The manifest, which is beside the file.
    pub manifest: PathBuf,
    /// The number of parts.
    pub parts: usize,
    /// The frames of all parts together.
    pub frames: usize,
    /// The time codes of the first and the last frame.
    pub time_codes: [f64; 2],
}

/// The manifests of stitched files.
static MANIFEST: companion::Kind = companion::Kind {
    extension: "manifest.usdc",
    namers: &["usd", "usda", "usdc"],
    names: |path| {
        let layer = open(path).ok()?.layer;
        Some(clips(&layer).map_or_else(Vec::new, |clips| clips.manifest.as_bytes().to_vec()))
    },
};

/// Writes a USD file that plays `parts` one after the other, and its manifest `NAME.HASH.manifest.usdc`
/// beside it. The parts stay where they are and may come in any order. The file may be renamed.
///
/// # Errors
/// [`Error::Input`] if a part is no USD file that Rhytid has written, or two parts are not of the same rig
/// and settings. Also if there is a gap or an overlap between parts, or `output` cannot be written or is a
/// part. [`Error::Io`].
pub fn stitch(parts: &[PathBuf], output: &Path) -> Result<Stitched> {
    let encoding = match Encoding::from_extension(output) {
        Some(encoding @ (Encoding::Crate | Encoding::Text)) => encoding,
        Some(Encoding::Package) | None => {
            return Err(Error::unsupported_format(format!(
                "{}: parts are stitched into .usd, .usdc or .usda; choose one of these",
                output.display()
            )));
        }
    };
    let folder = folder_of(output)?;
    let opened = Parts::open(parts)?;
    refuse_inputs(&[output], opened.parts().iter().map(|part| &*part.path))?;
    let mut assets = Vec::new();
    for part in opened.parts() {
        let part_folder = folder_of(&part.path)?;
        assets.push(asset(&part.path, &part_folder, &folder)?);
    }
    let summary = opened.summary();
    let first = open(&opened.parts()[0].path)?.layer;
    let declared = declarations_of(&first);
    let declared = CrateWriter::create(Cursor::new(Vec::new()), &declared).and_then(CrateWriter::finish);
    let mut manifest_file = Companion::create(output, &MANIFEST)?;
    manifest_file.write(declared.map_err(Error::io(output))?.0.get_ref())?;
    let manifest = manifest_file.path();
    let manifest_asset = asset(&manifest, &folder, &folder)?;
    let whole = whole(&first, summary, &opened, manifest_asset, assets)?;
    let whole = LayerWriter::create(output, encoding, &whole)?;
    let bytes = manifest_file.finish(|| whole.finish())?;
    let time_codes = [summary.first_time_code, summary.time_code(summary.frames - 1)];
    Ok(Stitched { bytes, manifest, parts: opened.parts().len(), frames: summary.frames, time_codes })
}

/// The manifest's layer, which declares what has samples in the parts.
pub(crate) fn declarations_of(first: &Layer) -> Layer {
    Layer { metadata: Fields::new(), prims: default_prim(first).and_then(declarations).into_iter().collect() }
}

/// The layer that plays `parts`, the first of which is `first`, as the files `assets`.
///
/// # Errors
/// [`Error::Internal`] if the first part has no default prim.
pub(crate) fn whole(
    first: &Layer,
    summary: &Summary,
    parts: &Parts,
    manifest: String,
    assets: Vec<String>,
) -> Result<Layer> {
    let first_time_codes: Vec<f64> = parts.parts().iter().map(|part| part.first_time_code).collect();
    Ok(layer(first, animated(first)?, summary, manifest, assets, &first_time_codes))
}

/// The prim that a part animates.
fn animated(part: &Layer) -> Result<&Prim> {
    default_prim(part).ok_or_else(|| Error::Internal("a part has lost its default prim".into()))
}

/// The layer that plays the clips `assets` from their `first_time_codes` on. `first` is the first one, and
/// `animated` its default prim.
fn layer(
    first: &Layer,
    animated: &Prim,
    summary: &Summary,
    manifest: String,
    assets: Vec<String>,
    first_time_codes: &[f64],
) -> Layer {
    let path = format!("/{}", animated.name);
    let [start, end] = [summary.first_time_code, summary.time_code(summary.frames - 1)];
    // Everything that does not move comes from the first part. References are weaker than clips, but a value
    // in this layer would be stronger. So this layer has no values.
    let still = Reference { asset: assets[0].clone(), prim: path.clone() };
    let active = first_time_codes.iter().enumerate().map(|(i, &time)| [time, i as f64]).collect();
    let set = vec![
        ("active".into(), Value::Double2s(active)),
        ("assetPaths".into(), Value::Assets(assets)),
        ("manifestAssetPath".into(), Value::Asset(manifest)),
        ("primPath".into(), Value::String(path)),
        // The time codes of the whole are those of the parts.
        ("times".into(), Value::Double2s(vec![[start, start], [end, end]])),
    ];
    let clips = Value::Dictionary(vec![("default".into(), Value::Dictionary(set))]);

    let mut root = prim(&animated.type_name, &animated.name);
    root.metadata.extend(summary.recipe.as_ref().map(|recipe| ("customData".into(), custom_data(recipe))));
    root.metadata.push(("references".into(), Value::PrependedReferences(vec![still])));
    root.metadata.push(("clips".into(), clips));

    let of_whole = |(name, value): &(String, Value)| {
        let value = match name.as_str() {
            "startTimeCode" => Value::Double(start),
            "endTimeCode" => Value::Double(end),
            _ => value.clone(),
        };
        (name.clone(), value)
    };
    let metadata: Fields = first.metadata.iter().map(of_whole).collect();
    Layer { metadata, prims: vec![root] }
}

/// The folder that `path` is in, without links.
pub(crate) fn folder_of(path: &Path) -> Result<PathBuf> {
    let folder = rhytid_core::folder_of(path);
    folder.canonicalize().map_err(Error::io(folder))
}

/// `path`, which is in `folder`, as a layer in the folder `from` refers to it: relative where that is
/// possible.
pub(crate) fn asset(path: &Path, folder: &Path, from: &Path) -> Result<String> {
    let [to, from] = [folder, from].map(|path| path.components().collect::<Vec<_>>());
    let common = to.iter().zip(&from).take_while(|(a, b)| a == b).count();
    let down = &to[common..];
    let name = path.file_name().unwrap_or(OsStr::new(""));
    let mut elements: Vec<&OsStr> = down.iter().map(|element| element.as_os_str()).collect();
    elements.push(name);
    let texts: Option<Vec<&str>> = elements.into_iter().map(OsStr::to_str).collect();
    let text = texts.filter(|texts| texts.iter().all(|text| !text.contains(['@', '<', '>'])));
    let text = text.ok_or_else(|| {
        Error::bad_path(format!(
            "{}: its name cannot stand in a USD file; rename it without “@”",
            path.display()
        ))
    })?;
    // Another drive, as some systems have them, cannot be reached from here.
    if down.iter().any(|element| matches!(element, Component::Prefix(_))) {
        return Ok(folder.join(name).display().to_string().replace('\\', "/"));
    }
    let up = from.len() - common;
    let begin = if up == 0 { "./".to_owned() } else { "../".repeat(up) };
    Ok(begin + &text.join("/"))
}
