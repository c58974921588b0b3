//! Which texture coordinates the textures of a material use, and how (KHR_texture_transform).

use ::gltf::json::material::Material;
use ::gltf::json::{Root, Value};
use rhytid_core::{Error, Result};
use serde::Deserialize;

/// The texture coordinates that a material uses.
#[derive(Clone, Copy, Default)]
pub(super) struct MaterialUvs {
    /// TEXCOORD_0, TEXCOORD_1 and so on.
    pub set: u32,
    /// From the stored coordinates to those that a texture is read at.
    pub transform: Option<UvTransform>,
}

/// Scale, then rotation, then offset of texture coordinates.
#[derive(Clone, Copy, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct UvTransform {
    offset: [f64; 2],
    /// In radians, from the second axis towards the first.
    rotation: f64,
    scale: [f64; 2],
    /// Another set than the texture names.
    tex_coord: Option<u32>,
}

impl Default for UvTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

impl UvTransform {
    pub(super) fn apply(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.rotation.sin_cos();
        let (u, v) = (u * self.scale[0], v * self.scale[1]);
        [cos * u + sin * v + self.offset[0], cos * v - sin * u + self.offset[1]]
    }

    /// Numbers that only the same transform has.
    pub(super) fn key(&self) -> [u64; 5] {
        [self.offset[0], self.offset[1], self.rotation, self.scale[0], self.scale[1]].map(f64::to_bits)
    }
}

impl MaterialUvs {
    /// What the base colour of material `index` uses or, where it has no texture, the first other texture.
    pub(super) fn of(root: &Root, index: Option<usize>, name: &str) -> Result<Self> {
        let Some(material) = index.and_then(|index| root.materials.get(index)) else {
            return Ok(Self::default());
        };
        let Some(used) = first_texture(material) else { return Ok(Self::default()) };
        let transform = match used.transform.map(UvTransform::deserialize) {
            None => None,
            Some(Ok(transform)) => Some(transform),
            Some(Err(e)) => {
                return Err(Error::malformed(format!(
                    "{name}: material {} has a KHR_texture_transform that cannot be read ({e}); export the mesh \
                     again",
                    index.unwrap_or_default()
                )));
            }
        };
        Ok(Self { set: transform.and_then(|t| t.tex_coord).unwrap_or(used.set), transform })
    }
}

/// A texture of a material.
struct Used<'a> {
    set: u32,
    transform: Option<&'a Value>,
}

fn first_texture(material: &Material) -> Option<Used<'_>> {
    // The three kinds of textures have the same members but no trait in common.
    macro_rules! used {
        ($texture:expr) => {
            $texture.as_ref().map(|texture| Used {
                set: texture.tex_coord,
                transform: texture.extensions.as_ref().and_then(|e| e.others.get("KHR_texture_transform")),
            })
        };
    }
    let surface = &material.pbr_metallic_roughness;
    used!(surface.base_color_texture)
        .or_else(|| used!(material.normal_texture))
        .or_else(|| used!(material.emissive_texture))
        .or_else(|| used!(material.occlusion_texture))
        .or_else(|| used!(surface.metallic_roughness_texture))
}
