//! How the materials of a file look: colours, opacities and images.
//!
//! A look is never needed to solve a face. So whatever is wrong with one is a warning, and the rest is read.

mod gathered;
mod image;
mod mtl;

pub(super) use gathered::{Gathered, ImageAt};
pub(super) use image::AlphaOf;

use super::{Format, gltf, usd};
use rhytid_core::{Material, Materials, Reach, Result, Texture, folder_of, input_file};
use std::collections::HashMap;
use std::path::Path;

/// What a file states about the looks of its materials.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Looks {
    /// The materials about which the file states something. Their names are distinct.
    pub materials: Vec<Material>,
    /// The images that they name. Their names are distinct.
    pub textures: Vec<Texture>,
}

impl Looks {
    /// Gives the materials of a mesh what is stated about materials of their names. Images that none of them
    /// names are left out.
    pub fn give_to(&self, materials: &mut Materials) {
        let by_name: HashMap<&str, &Material> =
            self.materials.iter().map(|material| (material.name.as_str(), material)).collect();
        let mut kept: Vec<usize> = Vec::new();
        for material in &mut materials.list {
            let Some(found) = by_name.get(material.name.as_str()) else { continue };
            material.stated = found.stated;
            if let Some(texture) = found.stated.texture {
                let place = kept.iter().position(|other| *other == texture as usize);
                let place = place.unwrap_or_else(|| {
                    kept.push(texture as usize);
                    kept.len() - 1
                });
                material.stated.texture = Some(place as u32);
            }
        }
        materials.textures = kept.into_iter().map(|texture| self.textures[texture].clone()).collect();
    }

    /// The same without images: see
    /// [`StatedLook::without_texture`](rhytid_core::StatedLook::without_texture).
    #[must_use]
    pub fn without_textures(mut self) -> Self {
        self.textures.clear();
        for material in &mut self.materials {
            material.stated = material.stated.without_texture();
        }
        self
    }
}

/// Reads what the file `path` states about the looks of its materials: an OBJ with its MTL, an MTL, a glTF or
/// a USD file. A PLY states nothing.
///
/// Images are read, and are PNG or JPEG in the result. Files that are named have to be within `reach`. What
/// cannot be read is left out with a warning, as are images of formats that cannot be converted.
///
/// # Errors
/// [`Error::Input`](rhytid_core::Error::Input) if the file itself cannot be read;
/// [`Error::Io`](rhytid_core::Error::Io).
pub fn read_looks(path: &Path, reach: Reach) -> Result<Looks> {
    let name = path.display().to_string();
    let bytes = || input_file::read(path, input_file::LARGEST_MESH_OR_TAKE);
    let mut gathered = Gathered::new(&name);
    match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("mtl") => {
            mtl::of_mtl(path, &bytes()?, reach, &mut gathered)?;
        }
        _ => match Format::from_extension(path)? {
            Format::Obj => mtl::of_obj(path, &bytes()?, reach, &mut gathered),
            Format::Gltf => {
                let folder = folder_of(path);
                gltf::looks(&bytes()?, &|uri| gltf::read_beside(folder, uri, &name), &mut gathered)?;
            }
            Format::Usd => usd::looks(bytes()?, path, reach, &mut gathered)?,
            Format::Ply => {}
        },
    }
    Ok(gathered.finish())
}
