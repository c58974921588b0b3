//! Where the images of materials are: beside the layer, in its package, or where the input has them.

use super::layer_writer::{Attached, Encoding, Member};
use crate::layer::{Attribute, Layer, Prim, Property, Value};
use crate::read::open;
use rhytid_core::{Error, Material, Result, Texture, TextureFormat};
use rhytid_export::companion::{self, Companion};
use rhytid_export::{Options, Scene, TextureFiles};
use std::collections::HashMap;
use std::path::Path;

/// The folder of a package that has its images.
const FOLDER: &str = "textures";

/// Copies of textures. The names of glTF's copies are others, because each format removes its own when no
/// file names them any more.
static PNG: companion::Kind =
    companion::Kind { extension: "usd.png", namers: &["usd", "usda", "usdc"], names: assets_of };
static JPEG: companion::Kind =
    companion::Kind { extension: "usd.jpg", namers: &["usd", "usda", "usdc"], names: assets_of };

/// The paths by which a layer refers to images.
pub(crate) struct Assets(Option<Vec<Option<String>>>);

impl Assets {
    /// No texture is in the layer.
    pub(crate) const NONE: Self = Self(None);

    /// Each texture by its name, for a layer that is compared and not written.
    pub(crate) fn named(scene: &Scene<'_>) -> Self {
        let textures = textures_of(scene);
        Self(Some(textures.iter().map(|texture| Some(texture.name.clone())).collect()))
    }

    /// The path of the texture with this entry in [`rhytid_core::Materials::textures`]; `None` if it is not
    /// in the layer.
    pub(super) fn of(&self, texture: Option<u32>) -> Option<&str> {
        self.0.as_ref()?.get(texture? as usize)?.as_deref()
    }
}

/// The textures that a mesh with texture coordinates can have.
fn textures_of<'a>(scene: &Scene<'a>) -> &'a [Texture] {
    scene.materials.filter(|_| scene.uvs.is_some()).map_or(&[], |materials| &materials.textures)
}

/// Decides where each image is that a material of the scene needs, and begins the copies. Textures of the
/// same bytes are one image.
///
/// # Errors
/// [`Error::Input`] if this encoding has no place for the images there; as [`Companion::create`] and
/// [`Companion::write`].
pub(super) fn place(
    path: &Path,
    encoding: Encoding,
    scene: &Scene<'_>,
    options: &Options,
) -> Result<(Assets, Attached)> {
    let is_package = encoding == Encoding::Package;
    let files = options.textures.unwrap_or(if is_package { TextureFiles::Embed } else { TextureFiles::Copy });
    let mut attached = Attached::default();
    let textures = if files == TextureFiles::None || options.over { &[] } else { textures_of(scene) };
    let of_material = |material: &Material| material.look().texture;
    let is_needed = |i: usize| {
        let mut named = scene.materials.iter().flat_map(|materials| &materials.list).filter_map(of_material);
        named.any(|named| named as usize == i)
    };
    let needed: Vec<usize> = (0..textures.len()).filter(|i| is_needed(*i)).collect();
    if !needed.is_empty() && is_package != (files == TextureFiles::Embed) {
        return Err(Error::conflict(if is_package {
            format!(
                "{}: a USD package has its textures inside it; put them there, leave them out, or write .usd",
                path.display()
            )
        } else {
            format!(
                "{}: of all USD files, only a package has textures inside it; write .usdz, or copies of the \
                 textures beside the file",
                path.display()
            )
        }));
    }
    let mut assets: Vec<Option<String>> = vec![None; textures.len()];
    for (n, &i) in needed.iter().enumerate() {
        let texture = &textures[i];
        let known = needed[..n].iter().find(|&&k| textures[k].bytes == texture.bytes);
        assets[i] = match (known, &texture.path) {
            (Some(&known), _) => assets[known].clone(),
            (None, Some(original)) if files == TextureFiles::Refer => Some(relative(original)),
            (None, _) if is_package => {
                let name = format!("{FOLDER}/{}", texture.name);
                attached.members.push(Member { name: name.clone(), bytes: texture.bytes.clone() });
                Some(relative(&name))
            }
            (None, original) => {
                if files == TextureFiles::Refer && original.is_none() {
                    log::warn!(
                        "{}: the texture {} has no file of its own that can be referred to; a copy is put beside \
                         the file",
                        path.display(),
                        texture.name
                    );
                }
                Some(copy(path, texture, &mut attached)?)
            }
        };
    }
    Ok((Assets(Some(assets)), attached))
}

/// Begins a copy beside the layer, and returns how the layer refers to it.
fn copy(path: &Path, texture: &Texture, attached: &mut Attached) -> Result<String> {
    let kind = if texture.format() == Some(TextureFormat::Jpeg) { &JPEG } else { &PNG };
    let mut copy = Companion::create(path, kind)?;
    copy.write(&texture.bytes)?;
    let name = copy.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
    attached.beside.push(copy);
    attached.bytes_beside += texture.bytes.len() as u64;
    Ok(relative(&name))
}

/// A path of the input as USD has it. One that begins with a plain name would be looked up in the search
/// path.
fn relative(path: &str) -> String {
    let is_anchored = path.starts_with(['.', '/']) || path.contains(':');
    if is_anchored { path.to_owned() } else { format!("./{path}") }
}

/// Every path by which a USD file refers to an image.
fn assets_of(path: &Path) -> Option<Vec<u8>> {
    fn collect(prims: &[Prim], found: &mut Vec<u8>) {
        for prim in prims {
            for property in &prim.properties {
                if let Property::Attribute(Attribute { default: Some(Value::Asset(asset)), .. }) = property {
                    found.extend(asset.as_bytes());
                    found.push(b'\n');
                }
            }
            collect(&prim.children, found);
        }
    }
    let mut found = Vec::new();
    collect(&open(path).ok()?.layer.prims, &mut found);
    Some(found)
}

/// Gives the images of `expected`, a layer with [`Assets::named`], the paths that `found` has for them. An
/// image may be beside the layer, in its package or elsewhere. A path of a wrong image is not taken. `bytes`
/// reads the image at a path.
pub(crate) fn accept(
    expected: &mut Layer,
    found: &Layer,
    scene: &Scene<'_>,
    bytes: impl Fn(&str, usize) -> Option<Vec<u8>>,
) {
    let mut known = HashMap::new();
    let mut is_right = |asset: &str, name: &str| {
        let texture = textures_of(scene).iter().find(|texture| texture.name == name);
        let Some(texture) = texture else { return false };
        let key = (asset.to_owned(), name.to_owned());
        *known.entry(key).or_insert_with(|| {
            texture.path.as_deref().map(relative).as_deref() == Some(asset)
                || bytes(asset, texture.bytes.len()).as_deref() == Some(&*texture.bytes)
        })
    };
    accept_below(&mut expected.prims, &found.prims, &mut is_right);
}

fn accept_below(expected: &mut [Prim], found: &[Prim], is_right: &mut impl FnMut(&str, &str) -> bool) {
    for prim in expected {
        let Some(other) = found.iter().find(|other| other.name == prim.name) else { continue };
        for property in &mut prim.properties {
            let Property::Attribute(Attribute { name, default: Some(Value::Asset(wanted)), .. }) = property
            else {
                continue;
            };
            let there = crate::read::attribute(other, name).and_then(|there| there.default.as_ref());
            if let Some(Value::Asset(there)) = there
                && is_right(there, wanted)
            {
                wanted.clone_from(there);
            }
        }
        accept_below(&mut prim.children, &other.children, is_right);
    }
}
