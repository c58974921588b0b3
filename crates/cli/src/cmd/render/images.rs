//! The images that a renderer is given: a matcap, textures.

use crate::args::{self, Show};
use rhytid::core::input_file;
use rhytid::formats::mesh::read_textures;
use rhytid::render::{Picture, Renderer, Surface};
use rhytid::{Error, Result, Rig};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// Gives `renderer` the images to show on `rig`.
///
/// # Errors
/// [`Error::Input`] where an image or a rig's texture coordinates are missing, or an image is damaged;
/// [`Error::Io`]; [`Error::Device`].
pub(super) fn give(renderer: &mut Renderer, rig: &Rig, args: &args::Render) -> Result<()> {
    if let Some(path) = &args.matcap {
        renderer.set_matcap(&decode(path, &input_file::read(path, input_file::LARGEST_MESH_OR_TAKE)?)?)?;
    }
    if !args.show.contains(&Show::Textured) {
        return Ok(());
    }
    let uvs = rig.surface().uvs.as_ref().ok_or_else(|| {
        Error::rig_lacks(format!(
            "{}: has no texture coordinates, which --show textured needs; solve it again of a neutral that has them (vt in .obj, \
             TEXCOORD_0 in glTF)",
            args.rig.display()
        ))
    })?;
    let path = args.texture.as_ref().ok_or_else(|| {
        Error::input(
            "--show textured: say with --texture FILE which image; or give the .obj, .mtl, .glb or .gltf whose materials name theirs",
        )
    })?;
    let is_image = path
        .extension()
        .is_some_and(|ending| ["png", "jpg", "jpeg"].iter().any(|known| ending.eq_ignore_ascii_case(known)));
    let (materials, images) = match is_image {
        true => {
            let bytes = input_file::read(path, input_file::LARGEST_MESH_OR_TAKE)?;
            (None, vec![Some(Arc::new(decode(path, &bytes)?))])
        }
        false => {
            let found = read_textures(path, args.reading.elsewhere.reach())?;
            let materials = rig.surface().materials.as_ref();
            let names: Vec<&str> = materials.iter().flat_map(|materials| materials.names()).collect();
            let of_materials: HashMap<&str, &Arc<[u8]>> =
                found.iter().map(|(material, bytes)| (material.as_str(), bytes)).collect();
            // An image of many materials is decoded once.
            let mut decoded: HashMap<*const u8, Arc<Picture>> = HashMap::new();
            let mut images = Vec::new();
            for &name in &names {
                let Some(bytes) = of_materials.get(name) else {
                    images.push(None);
                    continue;
                };
                let image = match decoded.get(&bytes.as_ptr()) {
                    Some(image) => image.clone(),
                    None => Arc::new(decode(path, bytes)?),
                };
                decoded.insert(bytes.as_ptr(), image.clone());
                images.push(Some(image));
            }
            if images.iter().all(Option::is_none) {
                let of_file: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
                return Err(Error::mismatch(format!(
                    "{}: has images for the materials {}, but the rig's are {}; give the image itself",
                    path.display(),
                    of_file.join(", "),
                    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
                )));
            }
            (materials, images)
        }
    };
    renderer.set_textures(Surface {
        faces: &rig.surface().faces,
        triangles: &rig.surface().triangles,
        uvs,
        materials,
        images: &images,
    })
}

fn decode(path: &Path, bytes: &[u8]) -> Result<Picture> {
    Picture::decode(bytes).map_err(|error| error.in_file(path.display()))
}
