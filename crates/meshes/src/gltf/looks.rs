//! The looks of a document's materials.

use super::buffers::{Buffers, External, data_uri};
use crate::looks::{Gathered, ImageAt};
use ::gltf::json::material::{AlphaMode, Material};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Root, Value, image};
use percent_encoding::percent_decode_str;
use rhytid_core::text::quoted;
use rhytid_core::{Error, Result, StatedLook, Transparency};
use std::path::Path;

/// The cutoff of a mask where a document states none.
const CUTOFF: f32 = 0.5;

/// Reads all materials.
pub(super) fn read(root: &Root, buffers: &Buffers, external: External<'_>, gathered: &mut Gathered<'_>) {
    for (index, material) in root.materials.iter().enumerate() {
        let Some(name) = material_name(root, index) else { continue };
        if !says_something(material) {
            continue;
        }
        let surface = &material.pbr_metallic_roughness;
        let [red, green, blue, alpha] = surface.base_color_factor.0.map(share);
        let texture = surface.base_color_texture.as_ref();
        let texture =
            texture.and_then(|info| image(info.index.value(), &name, (root, buffers), external, gathered));
        let transparency = match material.alpha_mode {
            Checked::Valid(AlphaMode::Mask) => {
                Transparency::Mask(share(material.alpha_cutoff.map_or(CUTOFF, |cutoff| cutoff.0)))
            }
            Checked::Valid(AlphaMode::Blend) => Transparency::Blend,
            Checked::Valid(AlphaMode::Opaque) | Checked::Invalid => Transparency::Opaque,
        };
        // An image of the roughness and the metal is not read, and its factors mean nothing without it.
        let has_image = surface.metallic_roughness_texture.is_some();
        let factor = |factor: f32| (!has_image).then(|| share(factor));
        let stated = StatedLook {
            base_color: Some([red, green, blue]),
            texture,
            opacity: Some(alpha),
            transparency: Some(transparency),
            roughness: factor(surface.roughness_factor.0),
            metallic: factor(surface.metallic_factor.0),
        };
        gathered.add(name, stated);
    }
}

/// The name of a material. One without a name that has a look is called after its number.
pub(super) fn material_name(root: &Root, index: usize) -> Option<String> {
    let material = root.materials.get(index)?;
    match &material.name {
        Some(name) if !name.is_empty() => Some(name.clone()),
        _ if says_something(material) => Some(format!("material-{index}")),
        _ => None,
    }
}

/// Whether a material states a look. One that has no more than a name has the look of the standard's
/// defaults, a white metal, which nobody means for a face.
fn says_something(material: &Material) -> bool {
    let surface = &material.pbr_metallic_roughness;
    surface.base_color_factor.0 != [1.0; 4]
        || surface.metallic_factor.0 != 1.0
        || surface.roughness_factor.0 != 1.0
        || surface.base_color_texture.is_some()
        || surface.metallic_roughness_texture.is_some()
        || !matches!(material.alpha_mode, Checked::Valid(AlphaMode::Opaque))
}

/// A number from 0 to 1.
fn share(x: f32) -> f32 {
    if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) }
}

/// The texture that the material `material` names by its number in the document.
fn image(
    texture: usize,
    material: &str,
    (root, buffers): (&Root, &Buffers),
    external: External<'_>,
    gathered: &mut Gathered<'_>,
) -> Option<u32> {
    let Some(found) = root.textures.get(texture) else {
        gathered.warn(&format!(
            "the texture of the material {} does not exist, so it is left out; export the mesh again",
            quoted(material)
        ));
        return None;
    };
    // An extension names an image of another format in addition, or instead.
    let others = found.extensions.iter().flat_map(|extensions| extensions.others.values());
    let of_extension = others.filter_map(|extension| extension.get("source").and_then(Value::as_u64));
    let source = Some(found.source.value()).filter(|source| *source < root.images.len());
    let source = source.or_else(|| of_extension.filter_map(|source| usize::try_from(source).ok()).next());
    let Some((number, image)) = source.and_then(|source| Some((source, root.images.get(source)?))) else {
        gathered.warn(&format!(
            "the texture of the material {} has no image, so it is left out; export the mesh again",
            quoted(material)
        ));
        return None;
    };
    let uri = image.uri.as_deref().filter(|uri| !uri.starts_with("data:"));
    let decoded = uri.map(|uri| percent_decode_str(uri).decode_utf8_lossy().into_owned());
    let file = decoded.as_deref().map(|path| path.rsplit('/').next().unwrap_or(path));
    // The name of an image in the document is often that of its file.
    let name = file.or(image.name.as_deref().filter(|name| !name.is_empty())).unwrap_or("texture");
    let name = match Path::new(name).extension() {
        Some(_) => name.to_owned(),
        None => format!("{name}.image"),
    };
    let key = decoded.clone().unwrap_or_else(|| format!("image {number}"));
    let at = ImageAt { key: &key, name: &name, path: decoded.as_deref() };
    let document = gathered.name();
    gathered.image(&at, material, || bytes(image, root, buffers, external, document))
}

fn bytes(
    image: &image::Image,
    root: &Root,
    buffers: &Buffers,
    external: External<'_>,
    name: &str,
) -> Result<Vec<u8>> {
    match (&image.buffer_view, &image.uri) {
        (Some(view), _) => Ok(buffers.view(root, view.value(), name)?.0.to_vec()),
        (None, Some(uri)) if uri.starts_with("data:") => data_uri(uri).ok_or_else(|| {
            Error::malformed(format!("{name}: an image is not valid base64 data; export the mesh again"))
        }),
        (None, Some(uri)) => external(uri),
        (None, None) => Err(Error::malformed(format!("{name}: an image has no data; export the mesh again"))),
    }
}
