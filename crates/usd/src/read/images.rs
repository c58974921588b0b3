//! The images that the materials of an animation name.

use super::lookup::below;
use super::package::member_of;
use crate::layer::Layer;
use rhytid_core::{folder_of, input_file, is_below};
use std::io::{Read, Seek};
use std::path::Path;

/// Whether a material has a texture.
pub(super) fn has_textures(layer: &Layer) -> bool {
    let shaders = layer.prims.iter().flat_map(|root| below(root, "Shader"));
    shaders.flat_map(|shader| &shader.properties).any(|property| property.name() == "inputs:file")
}

/// The image at the path `asset` that the USD file `file` names, inside the file or below its folder; `None`
/// if it is not there. Of an image of more than `expected` bytes, only the beginning is read.
pub(super) fn image(file: &Path, asset: &str, expected: usize) -> Option<Vec<u8>> {
    let limit = expected as u64 + 1;
    let mut usd = input_file::open(file).ok()?;
    let mut first = [0; 2];
    usd.read_exact(&mut first).ok()?;
    if first == *b"PK" {
        usd.rewind().ok()?;
        return member_of(usd, &file.display().to_string(), asset, limit).ok()?;
    }
    let folder = folder_of(file);
    // Nothing outside the folder is opened.
    if asset.contains(':') || !is_below(folder, Path::new(asset)) {
        return None;
    }
    let mut bytes = Vec::new();
    input_file::open(&folder.join(asset)).ok()?.take(limit).read_to_end(&mut bytes).ok()?;
    Some(bytes)
}
