//! The materials of the parts of a surface, and the images that they need.

use super::buffers::Buffers;
use super::container::Container;
use super::document::raw;
use super::surface::Surface;
use ::gltf::json::Index;
use ::gltf::json::image::{Image as ImageJson, MimeType};
use ::gltf::json::material::{
    AlphaCutoff, AlphaMode, Material as MaterialJson, PbrBaseColorFactor, PbrMetallicRoughness,
    StrengthFactor,
};
use ::gltf::json::texture::{Info, Texture as TextureJson};
use ::gltf::json::validation::Checked::Valid;
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use rhytid_core::{Look, Material, Materials, Result, Texture, TextureFormat, Transparency};
use rhytid_export::{Scene, TextureFiles};
use serde_json::json;
use std::sync::Arc;

/// The characters that a URI escapes in a path.
const IN_PATH: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'_').remove(b'.').remove(b'~').remove(b'/');

/// The materials of a file, and its images.
pub(crate) struct Looks {
    /// The material of each part of the surface.
    parts: Vec<Part>,
    /// Each once, in the order in which the parts need them.
    pub(crate) images: Vec<Image>,
}

/// The material of a part.
struct Part {
    name: String,
    /// Without the texture of the scene.
    look: Look,
    /// An entry of [`Looks::images`].
    image: Option<u32>,
}

/// An image of the base colour.
pub(crate) struct Image {
    /// The texture's name.
    pub name: String,
    pub bytes: Arc<[u8]>,
    pub format: TextureFormat,
    /// The path in the input, as a URI.
    pub path: Option<String>,
    /// Where the file names it, if it is not inside.
    uri: Option<String>,
}

impl Looks {
    /// Those of the parts of a surface. Without `with_textures`, or without texture coordinates, there are no
    /// images.
    pub(crate) fn new(scene: &Scene<'_>, surface: &Surface, with_textures: bool) -> Self {
        let mut looks = Self { parts: Vec::new(), images: Vec::new() };
        for part in &surface.parts {
            let material =
                scene.materials.zip(part.material).map(|(materials, index)| &materials.list[index]);
            let with_texture = with_textures && surface.uvs.is_some();
            let look = if with_texture { Material::look } else { Material::look_without_texture };
            let look = material.map_or(Materials::look_without(), look);
            let texture =
                scene.materials.zip(look.texture).map(|(materials, i)| &materials.textures[i as usize]);
            let image = texture.and_then(|texture| looks.image(texture));
            let name = material.map_or("skin", |material| &material.name).to_owned();
            looks.parts.push(Part { name, look, image });
        }
        looks
    }

    /// The entry of an image. Textures of the same bytes are one image.
    fn image(&mut self, texture: &Texture) -> Option<u32> {
        if let Some(known) = self.images.iter().position(|known| known.bytes == texture.bytes) {
            return Some(known as u32);
        }
        let uri = |path: &String| utf8_percent_encode(path, IN_PATH).to_string();
        self.images.push(Image {
            name: texture.name.clone(),
            bytes: texture.bytes.clone(),
            format: texture.format()?,
            path: texture.path.as_ref().map(uri),
            uri: None,
        });
        Some(self.images.len() as u32 - 1)
    }

    /// Decides where each image is, and begins the copies.
    ///
    /// # Errors
    /// As [`Container::add_texture`].
    pub(super) fn with_files(mut self, container: &mut Container, files: TextureFiles) -> Result<Self> {
        for image in &mut self.images {
            image.uri = match files {
                TextureFiles::Copy => Some(container.add_texture(&image.bytes, image.format)?),
                TextureFiles::Refer if image.path.is_some() => image.path.clone(),
                TextureFiles::Refer => {
                    log::warn!(
                        "{}: the texture {} has no file of its own that can be referred to; it is put into the file",
                        container.path().display(),
                        image.name
                    );
                    None
                }
                TextureFiles::Embed | TextureFiles::None => None,
            };
        }
        Ok(self)
    }

    /// Writes the images that are inside the file, and describes all of them.
    pub(super) fn write(&self, buffers: &mut Buffers) -> Result<Vec<ImageJson>> {
        let mut images = Vec::new();
        for image in &self.images {
            let view = match image.uri {
                None => Some(buffers.image(&image.bytes)?),
                Some(_) => None,
            };
            images.push(ImageJson { buffer_view: view, uri: image.uri.clone(), ..image.json() });
        }
        Ok(images)
    }

    /// The textures of the file: one for each image.
    pub(crate) fn textures(&self) -> Vec<TextureJson> {
        let of_image = |source: usize| TextureJson {
            name: None,
            sampler: None,
            source: Index::new(source as u32),
            extensions: None,
            extras: None,
        };
        (0..self.images.len()).map(of_image).collect()
    }

    /// The materials, one for each part of the surface.
    pub(crate) fn materials(&self) -> Result<Vec<MaterialJson>> {
        self.parts.iter().map(Part::json).collect()
    }
}

impl Image {
    /// Its description without its place.
    pub(crate) fn json(&self) -> ImageJson {
        ImageJson {
            buffer_view: None,
            mime_type: Some(MimeType(self.format.mime().to_owned())),
            name: Some(self.name.clone()),
            uri: None,
            extensions: None,
            extras: None,
        }
    }
}

impl Part {
    fn json(&self) -> Result<MaterialJson> {
        let Look {
            base_color: [red, green, blue],
            opacity,
            transparency,
            roughness,
            metallic,
            is_default,
            ..
        } = self.look;
        let (mode, cutoff) = match transparency {
            Transparency::Opaque => (AlphaMode::Opaque, None),
            Transparency::Mask(cutoff) => (AlphaMode::Mask, Some(AlphaCutoff(cutoff))),
            Transparency::Blend => (AlphaMode::Blend, None),
        };
        let texture = self.image.map(|image| Info {
            index: Index::new(image),
            tex_coord: 0,
            extensions: None,
            extras: None,
        });
        Ok(MaterialJson {
            name: Some(self.name.clone()),
            double_sided: true,
            alpha_mode: Valid(mode),
            alpha_cutoff: cutoff,
            pbr_metallic_roughness: PbrMetallicRoughness {
                base_color_factor: PbrBaseColorFactor([red, green, blue, opacity]),
                base_color_texture: texture,
                metallic_factor: StrengthFactor(metallic),
                roughness_factor: StrengthFactor(roughness),
                ..PbrMetallicRoughness::default()
            },
            // So that nobody takes it for what was scanned.
            extras: if is_default { raw(&json!({ "defaultLook": true }))? } else { None },
            ..MaterialJson::default()
        })
    }
}
