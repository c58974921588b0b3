//! The materials of a mesh: how its surface looks, as the input states it or by default.

use crate::Faces;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::sync::Arc;

/// The material of each face, where the input names materials.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Materials {
    /// The materials. Their names are distinct, and each is of at least one face.
    pub list: Vec<Material>,
    /// The images that materials name. Their names are distinct.
    pub textures: Vec<Texture>,
    /// For each face its entry in `list`, or [`Materials::NONE`].
    pub of_face: Vec<u32>,
}

/// A material: its name, and how it looks.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The name in the input.
    pub name: String,
    /// What the surface is. It decides how the material looks if `stated` says nothing.
    pub tissue: Tissue,
    /// What the input states about the look.
    pub stated: StatedLook,
}

/// What an input states about a material's look. `None` is what it does not state.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StatedLook {
    /// Linear red, green and blue with Rec. 709's primaries, each 0 to 1. A texture is multiplied by it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base_color: Option<[f32; 3]>,
    /// The entry of [`Materials::textures`] with the base colour.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub texture: Option<u32>,
    /// 0, invisible, to 1, opaque. A texture's alpha is multiplied by it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<f32>,
    /// What opacity does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transparency: Option<Transparency>,
    /// 0, a mirror, to 1, matt. It is the roughness of glTF, USD and Blender: the square root of GGX's α.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub roughness: Option<f32>,
    /// 0, no metal, to 1, metal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub metallic: Option<f32>,
}

/// What opacity does. Opacity is [`Look::opacity`] multiplied by the texture's alpha.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Transparency {
    /// Nothing: the surface is opaque, whatever the alpha of its texture.
    Opaque,
    /// The surface is there where opacity is at least the cutoff, 0 to 1. Elsewhere it is not.
    Mask(f32),
    /// The surface is mixed with what is behind it.
    Blend,
}

/// How a material looks: what its input states, and defaults for the rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Linear red, green and blue with Rec. 709's primaries, each 0 to 1. A texture is multiplied by it.
    pub base_color: [f32; 3],
    /// The entry of [`Materials::textures`] with the base colour. Its red, green and blue are sRGB, and its
    /// alpha is linear.
    pub texture: Option<u32>,
    /// 0, invisible, to 1, opaque. A texture's alpha is multiplied by it.
    pub opacity: f32,
    /// What opacity does.
    pub transparency: Transparency,
    /// 0, a mirror, to 1, matt. It is the roughness of glTF, USD and Blender: the square root of GGX's α.
    pub roughness: f32,
    /// 0, no metal, to 1, metal.
    pub metallic: f32,
    /// Whether all of it is the default of a [`Tissue`], because the input states nothing.
    pub is_default: bool,
}

/// What a surface is, for the look of materials about which the input states nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Tissue {
    /// Skin, and all that nothing is known of.
    #[default]
    Skin,
    /// An eyeball.
    Eye,
    /// An iris with its pupil.
    Iris,
    /// What is clear: tear film, cornea, the shadow around an eye.
    Clear,
    /// Teeth.
    Teeth,
    /// Gums, tongue and the inside of a mouth.
    Mouth,
    /// Lashes, brows and other hair.
    Hair,
}

/// An image that a material names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Texture {
    /// A file name without folders that ends in `.png` or `.jpg`.
    pub name: String,
    /// The path in the input: relative to the mesh's file, with slashes. `None` if the image is in that file,
    /// or was made from what is there.
    pub path: Option<String>,
    /// The image file, PNG or JPEG.
    pub bytes: Arc<[u8]>,
}

/// The formats of textures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextureFormat {
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
}

impl Materials {
    /// A face without a material.
    pub const NONE: u32 = u32::MAX;

    /// Materials of which only the names are known.
    pub fn named(names: impl IntoIterator<Item = impl Into<String>>, of_face: Vec<u32>) -> Self {
        Self { list: names.into_iter().map(Material::new).collect(), textures: Vec::new(), of_face }
    }

    /// The names of the materials, in their order.
    pub fn names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.list.iter().map(|material| material.name.as_str())
    }

    /// The look of a face that has no material: the default of skin.
    pub const fn look_without() -> Look {
        Tissue::Skin.look()
    }

    /// What is wrong with these as materials of `faces`, as a phrase without its subject; `None` if nothing
    /// is. Faces are numbered from 1.
    pub fn fault(&self, faces: &Faces) -> Option<String> {
        if self.of_face.len() != faces.len() {
            return Some(format!("has materials for {} faces, expected {}", self.of_face.len(), faces.len()));
        }
        let count = self.list.len();
        if let Some(f) = self.of_face.iter().position(|&m| m != Self::NONE && m as usize >= count) {
            return Some(format!(
                "face {} refers to material {}, expected one of its {count} (counted from 0)",
                f + 1,
                self.of_face[f]
            ));
        }
        let mut seen = HashSet::new();
        if let Some(twice) = self.names().find(|name| !seen.insert(*name)) {
            return Some(format!("has two materials called “{twice}”"));
        }
        let mut seen = HashSet::new();
        for texture in &self.textures {
            if let Some(fault) = texture.fault() {
                return Some(fault);
            }
            // Some file systems take names for the same that differ in their case.
            if !seen.insert(texture.name.to_lowercase()) {
                return Some(format!("has two textures called “{}”", texture.name));
            }
        }
        for Material { name, stated, .. } in &self.list {
            if let Some(fault) = stated.fault(self.textures.len()) {
                return Some(format!("has a material “{name}” with {fault}"));
            }
        }
        None
    }
}

impl Material {
    /// A material of which only the name is known. Words in it tell what it is: see [`Tissue::of_name`].
    pub fn new(name: impl Into<String>) -> Self {
        let name = name.into();
        let tissue = Tissue::of_name(&name).unwrap_or_default();
        Self { name, tissue, stated: StatedLook::default() }
    }

    /// How the material looks: what the input states, and the default of the [`Tissue`] for the rest.
    ///
    /// Colour and opacity belong together. If a colour or a texture is stated, then the opacity is 1 unless
    /// it is stated, too, and a texture without a colour is shown as it is. An opacity below 1 blends unless
    /// the input states something else.
    pub fn look(&self) -> Look {
        self.look_of(self.stated)
    }

    /// How the material looks where its texture cannot be shown: see [`StatedLook::without_texture`].
    pub fn look_without_texture(&self) -> Look {
        self.look_of(self.stated.without_texture())
    }

    fn look_of(&self, stated: StatedLook) -> Look {
        let default = self.tissue.look();
        let StatedLook { base_color, texture, opacity, transparency, roughness, metallic } = stated;
        let has_color = base_color.is_some() || texture.is_some();
        let opacity = opacity.unwrap_or(if has_color { 1.0 } else { default.opacity });
        let by_opacity = if opacity < 1.0 { Transparency::Blend } else { Transparency::Opaque };
        Look {
            base_color: base_color.unwrap_or(if texture.is_some() { [1.0; 3] } else { default.base_color }),
            texture,
            opacity,
            transparency: transparency.unwrap_or(by_opacity),
            roughness: roughness.unwrap_or(default.roughness),
            metallic: metallic.unwrap_or(default.metallic),
            is_default: stated == StatedLook::default(),
        }
    }
}

impl StatedLook {
    /// The same without its texture. The colour and the opacity that the texture gave are not stated any
    /// more.
    #[must_use]
    pub fn without_texture(mut self) -> Self {
        if self.texture.take().is_some() {
            self.base_color = None;
            let is_opacity_stated = self.opacity.is_some_and(|opacity| opacity < 1.0);
            if !is_opacity_stated || matches!(self.transparency, Some(Transparency::Mask(_))) {
                (self.opacity, self.transparency) = (None, None);
            }
        }
        self
    }

    /// What is wrong with it beside so many textures; `None` if nothing is.
    fn fault(&self, textures: usize) -> Option<String> {
        let cutoff = match self.transparency {
            Some(Transparency::Mask(cutoff)) => Some(cutoff),
            _ => None,
        };
        let [red, green, blue] = self.base_color.map_or([None; 3], |color| color.map(Some));
        let shares = [
            ("red", red),
            ("green", green),
            ("blue", blue),
            ("opacity", self.opacity),
            ("cutoff", cutoff),
            ("roughness", self.roughness),
            ("metallic", self.metallic),
        ];
        for (what, share) in shares {
            if let Some(share) = share
                && !(0.0..=1.0).contains(&share)
            {
                return Some(format!("{what} {share}, expected 0 to 1"));
            }
        }
        match self.texture {
            Some(texture) if texture as usize >= textures => {
                Some(format!("texture {texture}, expected one of its {textures} (counted from 0)"))
            }
            _ => None,
        }
    }
}

impl Tissue {
    /// How it looks where no input states how.
    pub const fn look(self) -> Look {
        let (base_color, roughness) = match self {
            Self::Skin => ([0.85, 0.56, 0.44], 0.5),
            Self::Eye => ([0.86, 0.83, 0.80], 0.1),
            Self::Iris => ([0.10, 0.06, 0.03], 0.1),
            Self::Clear => ([1.0, 1.0, 1.0], 0.05),
            Self::Teeth => ([0.80, 0.74, 0.62], 0.25),
            Self::Mouth => ([0.50, 0.14, 0.13], 0.3),
            Self::Hair => ([0.03, 0.02, 0.015], 0.6),
        };
        let is_clear = matches!(self, Self::Clear);
        Look {
            base_color,
            texture: None,
            opacity: if is_clear { 0.1 } else { 1.0 },
            transparency: if is_clear { Transparency::Blend } else { Transparency::Opaque },
            roughness,
            metallic: 0.0,
            is_default: true,
        }
    }

    /// What a material or a part with this name is, by words in it: `M_EyeLashes` is hair, and
    /// `cornea_left` is clear. `None` if no word says it.
    pub fn of_name(name: &str) -> Option<Self> {
        // A brown eye is no brow.
        let name = name.to_lowercase().replace("brown", "");
        for (tissue, words) in WORDS {
            if words.iter().any(|word| name.contains(word)) {
                return Some(tissue);
            }
        }
        None
    }
}

/// Parts of names, with what they say. The first that fits counts: lashes are no eyes, and gums of teeth are
/// no teeth.
const WORDS: [(Tissue, &[&str]); 8] = [
    (Tissue::Hair, &["lash", "brow", "hair", "beard", "wimper", "braue", "haar"]),
    (
        Tissue::Clear,
        &[
            "cornea",
            "lacrimal",
            "tear",
            "saliva",
            "occlusion",
            "eyewet",
            "eyemoisture",
            "eyereflection",
            "eyeblend",
            "eyeshell",
            "eyeedge",
        ],
    ),
    (Tissue::Iris, &["iris", "pupil"]),
    (Tissue::Mouth, &["gum", "gingiva", "tongue", "mouth", "zunge", "zahnfleisch"]),
    (Tissue::Teeth, &["teeth", "tooth", "dental", "denture", "zahn", "zähne"]),
    (Tissue::Skin, &["eyelid", "socket"]),
    (Tissue::Eye, &["eye", "sclera", "auge"]),
    (Tissue::Skin, &["skin", "face", "head", "body", "haut", "gesicht", "kopf"]),
];

impl Texture {
    /// The format, by the first bytes; `None` if it is neither.
    pub fn format(&self) -> Option<TextureFormat> {
        match &*self.bytes {
            [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n', ..] => Some(TextureFormat::Png),
            [0xff, 0xd8, 0xff, ..] => Some(TextureFormat::Jpeg),
            _ => None,
        }
    }

    /// Width and height in pixels, as the head of the file has them; `None` if the head is damaged.
    pub fn size(&self) -> Option<[u32; 2]> {
        match self.format()? {
            // The first chunk begins with them.
            TextureFormat::Png => {
                let at = |start: usize| Some(u32::from_be_bytes(*self.bytes.get(start..)?.first_chunk()?));
                Some([at(16)?, at(20)?])
            }
            TextureFormat::Jpeg => jpeg_size(&self.bytes),
        }
    }

    /// What is wrong with it, as a phrase without its subject; `None` if nothing is.
    fn fault(&self) -> Option<String> {
        let Some(format) = self.format() else {
            return Some(format!("has a texture “{}” that is neither PNG nor JPEG", self.name));
        };
        let stem = self.name.strip_suffix(format.ending());
        let is_plain = |stem: &str| {
            !stem.is_empty() && !stem.contains(|c: char| c.is_control() || r#"/\:*?"<>|"#.contains(c))
        };
        (!stem.is_some_and(is_plain)).then(|| {
            format!(
                "has a texture called “{}”, expected a file name without folders that ends in {}",
                self.name,
                format.ending()
            )
        })
    }
}

/// The size of a JPEG: its segments are passed over until the one that begins a frame.
fn jpeg_size(bytes: &[u8]) -> Option<[u32; 2]> {
    let at = |place: usize| Some(u32::from(u16::from_be_bytes(*bytes.get(place..)?.first_chunk()?)));
    let mut place = 2;
    loop {
        let [0xff, marker] = *bytes.get(place..)?.first_chunk::<2>()? else { return None };
        match marker {
            // Bytes that fill, and markers without a length.
            0xff => place += 1,
            0x01 | 0xd0..=0xd8 => place += 2,
            // Tables and comments have other markers than these.
            0xc0..=0xcf if ![0xc4, 0xc8, 0xcc].contains(&marker) => {
                return Some([at(place + 7)?, at(place + 5)?]);
            }
            _ => place += 2 + at(place + 2)? as usize,
        }
    }
}

impl TextureFormat {
    /// How file names of this format end.
    pub const fn ending(self) -> &'static str {
        match self {
            Self::Png => ".png",
            Self::Jpeg => ".jpg",
        }
    }

    /// The media type.
    pub const fn mime(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Jpeg => "image/jpeg",
        }
    }
}
