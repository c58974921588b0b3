//! The images that a renderer is given: a matcap, textures.

use crate::args::{self, Show};
use rhytid::core::{Material, Materials, Uvs, input_file};
use rhytid::formats::mesh::read_looks;
use rhytid::render::{Picture, Renderer, Surface, pictures};
use rhytid::{Error, Result, Rig};
use std::borrow::Cow;
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
    let of_rig = rig.surface().materials.as_ref();
    let mut materials = None;
    let images = match &args.texture {
        Some(path) if is_image(path) => {
            let bytes = input_file::read(path, input_file::LARGEST_MESH_OR_TAKE)?;
            let mut image = decode(path, &bytes)?;
            image.make_opaque();
            vec![Some(Arc::new(image))]
        }
        Some(path) => {
            let found = materials.insert(Cow::Owned(of_file(path, of_rig, args)?));
            pictures(found)?
        }
        None => {
            let found = materials.insert(Cow::Borrowed(of_rig.ok_or_else(|| {
                Error::rig_lacks(format!(
                    "{}: has no materials, which --show textured shows; say with --texture FILE which image, or solve it again \
                     of a neutral that has materials",
                    args.rig.display()
                ))
            })?));
            pictures(found).map_err(|error| error.in_file(args.rig.display()))?
        }
    };
    let needs_uvs = match &materials {
        Some(materials) => materials.list.iter().any(|material| material.stated.texture.is_some()),
        None => true,
    };
    let uvs = match &rig.surface().uvs {
        Some(uvs) => Cow::Borrowed(uvs),
        None if needs_uvs => {
            return Err(Error::rig_lacks(format!(
                "{}: has no texture coordinates, which --show textured needs; solve it again of a neutral that has them (vt in .obj, \
                 TEXCOORD_0 in glTF)",
                args.rig.display()
            )));
        }
        // Colours alone are the same everywhere.
        None => Cow::Owned(Uvs { values: vec![[0.0; 2]; rig.vertices()], corners: None }),
    };
    renderer.set_textures(Surface {
        faces: &rig.surface().faces,
        triangles: &rig.surface().triangles,
        uvs: &uvs,
        materials: materials.as_deref(),
        images: &images,
    })
}

fn is_image(path: &Path) -> bool {
    let is = |ending: &std::ffi::OsStr| {
        ["png", "jpg", "jpeg"].iter().any(|known| ending.eq_ignore_ascii_case(known))
    };
    path.extension().is_some_and(is)
}

/// The rig's materials with the looks of a file in the place of their own.
fn of_file(path: &Path, of_rig: Option<&Materials>, args: &args::Render) -> Result<Materials> {
    let looks = read_looks(path, args.reading.elsewhere.reach())?;
    if looks.textures.is_empty() {
        return Err(Error::empty(format!(
            "{}: names no image for a material that can be read, expected map_Kd in the MTL of an OBJ, or a base colour texture \
             in glTF or USD; name the image itself",
            path.display()
        )));
    }
    let mut materials = of_rig.cloned().unwrap_or_default();
    for material in &mut materials.list {
        *material = Material::new(&material.name);
    }
    looks.give_to(&mut materials);
    if materials.textures.is_empty() {
        let with_image = looks.materials.iter().filter(|material| material.stated.texture.is_some());
        let of_file: Vec<&str> = with_image.map(|material| material.name.as_str()).collect();
        let names: Vec<&str> = materials.names().collect();
        return Err(Error::mismatch(format!(
            "{}: has images for the materials {}, but the rig's are {}; give the image itself",
            path.display(),
            of_file.join(", "),
            if names.is_empty() { "none".to_owned() } else { names.join(", ") }
        )));
    }
    Ok(materials)
}

fn decode(path: &Path, bytes: &[u8]) -> Result<Picture> {
    Picture::decode(bytes).map_err(|error| error.in_file(path.display()))
}
