//! glTF 2.0, as GLB or JSON. The `gltf` crate splits and parses the file. Its own iterators panic on wrong
//! ranges, and its validation does not look at buffers. So the numbers are read here (`accessor`).

mod accessor;
mod buffers;
mod draco;
mod looks;
mod material_uvs;
mod nodes;
mod scene;
mod skin;
mod targets;

pub(super) use buffers::{External, read_beside};

use super::looks::Gathered;
use super::shapes::Shapes;
use ::gltf::binary::Glb;
use ::gltf::json::{Root, Value, deserialize};
use ::gltf::{Document, Gltf};
use buffers::Buffers;
use rhytid_core::{Error, Result};
use rhytid_gltf::meshopt;
use std::borrow::Cow;

/// The mesh, with its morph targets if `with_shapes`.
pub(super) fn decode(bytes: &[u8], name: &str, external: External<'_>, with_shapes: bool) -> Result<Shapes> {
    let (mut root, mut buffers) = open(bytes, name, external)?;
    draco::unfold(&mut root, &mut buffers, name)?;
    scene::read(&root, &buffers, name, with_shapes)
}

/// The looks of materials.
pub(super) fn looks(bytes: &[u8], external: External<'_>, gathered: &mut Gathered<'_>) -> Result<()> {
    let (root, buffers) = open(bytes, gathered.name(), external)?;
    looks::read(&root, &buffers, external, gathered);
    Ok(())
}

fn open(bytes: &[u8], name: &str, external: External<'_>) -> Result<(Root, Buffers)> {
    check_glb_length(bytes, name)?;
    let parsed = Gltf::from_slice_without_validation(bytes);
    let Gltf { document, blob } = parsed.or_else(|error| without_nodes(bytes, error)).map_err(|error| {
        Error::malformed(match error {
            _ if is_version_1(bytes) => {
                return Error::unsupported_format(format!(
                    "{name}: is glTF 1.0, expected glTF 2.0; convert it, for example with gltf-pipeline"
                ));
            }
            ::gltf::Error::Deserialize(error) if error.is_eof() => {
                return Error::cut_short(format!(
                    "{name}: its JSON ends too early: {error}; the file is cut short: copy or export it again"
                ));
            }
            ::gltf::Error::Deserialize(error) => {
                format!("{name}: its JSON is not that of a glTF 2.0 file: {error}; export the mesh again")
            }
            error => format!("{name}: is not a valid glTF file: {error}; export the mesh again"),
        })
    })?;
    let root = document.into_json();
    check_extensions(&root, name)?;
    let buffers = Buffers::load(&root, blob, name, external)?;
    Ok((root, buffers))
}

/// Reads a document again after an error about missing nodes, which the crate demands and the standard does
/// not: an empty scene has no list of them, and an animation may move something else (KHR_animation_pointer).
fn without_nodes(bytes: &[u8], error: ::gltf::Error) -> std::result::Result<Gltf, ::gltf::Error> {
    if !error.to_string().contains("missing field `node") {
        return Err(error);
    }
    let (text, blob) = match bytes.starts_with(b"glTF") {
        true => {
            let glb = Glb::from_slice(bytes)?;
            (glb.json, glb.bin.map(Cow::into_owned))
        }
        false => (Cow::Borrowed(bytes), None),
    };
    let mut document: Value = deserialize::from_slice(&text)?;
    for scene in document.get_mut("scenes").and_then(Value::as_array_mut).into_iter().flatten() {
        if let Some(scene) = scene.as_object_mut() {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    if let Some(document) = document.as_object_mut() {
        // No animation is read.
        document.remove("animations");
    }
    let root = deserialize::from_value(document)?;
    Ok(Gltf { document: Document::from_json_without_validation(root), blob })
}

/// Whether the file is of the first version of the format. It may say so. Else its meshes have names, not
/// numbers.
fn is_version_1(bytes: &[u8]) -> bool {
    #[derive(serde::Deserialize)]
    struct Document {
        asset: Option<Asset>,
        meshes: Option<Value>,
    }
    #[derive(serde::Deserialize)]
    struct Asset {
        version: Option<Value>,
    }
    if let Some(rest) = bytes.strip_prefix(b"glTF") {
        return rest.starts_with(&1_u32.to_le_bytes());
    }
    let Ok(Document { asset, meshes }) = deserialize::from_slice(bytes) else { return false };
    match asset.and_then(|asset| asset.version) {
        // Early files have a number there.
        Some(version) => version.to_string().trim_matches('"').starts_with('1'),
        None => meshes.is_some_and(|meshes| meshes.is_object()),
    }
}

/// The crate subtracts from a GLB's length before it checks that it can.
fn check_glb_length(bytes: &[u8], name: &str) -> Result<()> {
    if !bytes.starts_with(b"glTF") {
        return Ok(());
    }
    let length = bytes.get(8..).and_then(<[u8]>::first_chunk).map(|b| u32::from_le_bytes(*b) as usize);
    match length {
        Some(length) if (12..=bytes.len()).contains(&length) => Ok(()),
        Some(length) if length > bytes.len() => Err(Error::cut_short(format!(
            "{name}: has {} bytes, expected the {length} that its header announces; the file is cut short",
            bytes.len()
        ))),
        Some(length) => Err(Error::malformed(format!(
            "{name}: announces a length of {length} bytes, expected at least 12; the file is damaged"
        ))),
        None => Err(Error::cut_short(format!(
            "{name}: has {} bytes, expected at least the 12 of a GLB header; the file is cut short",
            bytes.len()
        ))),
    }
}

fn check_extensions(root: &Root, name: &str) -> Result<()> {
    // These change how a surface looks or how a character behaves, not where its vertices are; quantised
    // positions are read as any others.
    const HARMLESS: [&str; 10] = [
        "KHR_materials_",
        "KHR_technique",
        "KHR_texture_",
        "KHR_lights_",
        "KHR_animation_",
        "KHR_xmp",
        "EXT_texture_",
        "EXT_lights_",
        "MSFT_texture_",
        "VRM",
    ];
    let is_known = |extension: &str| {
        HARMLESS.iter().any(|family| extension.starts_with(family))
            || ["KHR_mesh_quantization", draco::EXTENSION].contains(&extension)
            || meshopt::EXTENSIONS.contains(&extension)
    };
    match root.extensions_required.iter().find(|extension| !is_known(extension)) {
        None => Ok(()),
        Some(extension) if extension.contains("compression") => Err(Error::unsupported_format(format!(
            "{name}: is compressed with {extension}, which is not supported; export it without compression"
        ))),
        Some(extension) => Err(Error::unsupported_format(format!(
            "{name}: requires the extension {extension}, which is not supported; export it without"
        ))),
    }
}
