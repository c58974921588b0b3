//! The base colours of a document's materials.

use super::buffers::{Buffers, External, data_uri};
use ::gltf::json::Root;
use rhytid_core::{Error, Result};
use std::collections::HashMap;
use std::sync::Arc;

/// Where an image is.
#[derive(PartialEq, Eq, Hash)]
struct Source<'a> {
    view: Option<usize>,
    uri: Option<&'a str>,
}

/// The name of each material that has a base colour texture, and its image as it is encoded.
pub(super) fn read(
    root: &Root,
    buffers: &Buffers,
    name: &str,
    external: External<'_>,
) -> Result<Vec<(String, Arc<[u8]>)>> {
    let mut found = Vec::new();
    // An image of many materials is read and kept once.
    let mut images: HashMap<Source<'_>, Arc<[u8]>> = HashMap::new();
    for material in &root.materials {
        let Some(material_name) = &material.name else { continue };
        let Some(texture) = &material.pbr_metallic_roughness.base_color_texture else { continue };
        let missing = |what: &str| {
            Error::malformed(format!(
                "{name}: the texture of the material {material_name} {what}; export the mesh again"
            ))
        };
        let texture = root.textures.get(texture.index.value()).ok_or_else(|| missing("does not exist"))?;
        let image = root.images.get(texture.source.value()).ok_or_else(|| missing("has no image"))?;
        let source = Source { view: image.buffer_view.map(|view| view.value()), uri: image.uri.as_deref() };
        if let Some(image) = images.get(&source) {
            found.push((material_name.clone(), image.clone()));
            continue;
        }
        let bytes = match (&image.buffer_view, &image.uri) {
            (Some(view), _) => buffers.view(root, view.value(), name)?.0.to_vec(),
            (None, Some(uri)) if uri.starts_with("data:") => {
                data_uri(uri).ok_or_else(|| missing("is not valid base64 data"))?
            }
            (None, Some(uri)) => external(uri)?,
            (None, None) => return Err(missing("has an image without data")),
        };
        let image: Arc<[u8]> = bytes.into();
        images.insert(source, image.clone());
        found.push((material_name.clone(), image));
    }
    Ok(found)
}
