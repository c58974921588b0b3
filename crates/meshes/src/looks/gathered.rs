//! The looks of a file while it is read.

use super::Looks;
use super::image::{AlphaOf, Refused, converted, with_alpha};
use rhytid_core::text::quoted;
use rhytid_core::{Material, Result, StatedLook, Texture, TextureFormat};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Gathers materials and images. Warns about what is left out.
pub(in super::super) struct Gathered<'a> {
    /// The file, for messages.
    name: &'a str,
    looks: Looks,
    known: HashSet<String>,
    /// The textures that came of images: `None` where an image could not be read.
    images: HashMap<String, Option<u32>>,
    /// The textures that were made of a colour and an alpha.
    combined: HashMap<(Option<u32>, u32, AlphaOf), Option<u32>>,
    /// The names of textures, in lower case.
    names: HashSet<String>,
}

/// Where an image is, in the words of the file that names it.
pub(in super::super) struct ImageAt<'t> {
    /// What tells it from all other images of the file.
    pub(in super::super) key: &'t str,
    /// Its file name, perhaps with folders.
    pub(in super::super) name: &'t str,
    /// Its path, if it is a file of its own.
    pub(in super::super) path: Option<&'t str>,
}

impl<'a> Gathered<'a> {
    /// Nothing of the file `name` yet.
    pub(super) fn new(name: &'a str) -> Self {
        Self {
            name,
            looks: Looks::default(),
            known: HashSet::new(),
            images: HashMap::new(),
            combined: HashMap::new(),
            names: HashSet::new(),
        }
    }

    /// The file, for messages.
    pub(in super::super) fn name(&self) -> &'a str {
        self.name
    }

    /// Whether something is stated about a material.
    pub(super) fn knows(&self, name: &str) -> bool {
        self.known.contains(name)
    }

    /// Says that something is likely wrong. `what` ends with what to do.
    pub(in super::super) fn warn(&self, what: &str) {
        log::warn!("{}: {what}", self.name);
    }

    /// Adds what is stated about a material. Of several with one name, the first counts.
    pub(in super::super) fn add(&mut self, name: String, stated: StatedLook) {
        if !self.known.insert(name.clone()) {
            let is_other = |material: &&Material| material.name == name && material.stated != stated;
            if self.looks.materials.iter().any(|material| is_other(&material)) {
                self.warn(&format!(
                    "has two materials called {}, and the look of the first counts; give them names of their own",
                    quoted(&name)
                ));
            }
            return;
        }
        if stated.opacity == Some(0.0) {
            self.warn(&format!(
                "the material {} is invisible, because its opacity is 0; if it is to be seen, give it the opacity 1",
                quoted(&name)
            ));
        }
        self.looks.materials.push(Material { stated, ..Material::new(name) });
    }

    /// The texture of an image of `material`, which is read if it was not yet. `None` if it cannot be.
    pub(in super::super) fn image(
        &mut self,
        at: &ImageAt<'_>,
        material: &str,
        read: impl FnOnce() -> Result<Vec<u8>>,
    ) -> Option<u32> {
        if let Some(known) = self.images.get(at.key) {
            return *known;
        }
        let texture = self.read_image(at, material, read);
        self.images.insert(at.key.to_owned(), texture);
        texture
    }

    fn read_image(
        &mut self,
        at: &ImageAt<'_>,
        material: &str,
        read: impl FnOnce() -> Result<Vec<u8>>,
    ) -> Option<u32> {
        let material = quoted(material);
        if at.name.contains("<UDIM>") || at.name.contains("<UVTILE>") {
            self.warn(&format!(
                "the material {material} has its colours in tiles ({}), which cannot be read, so it is without \
                 them; bake the tiles into one image",
                at.name
            ));
            return None;
        }
        let found = match read() {
            Ok(bytes) => converted(bytes),
            Err(error) => {
                log::warn!("{error}; so the material {material} is without its image");
                return None;
            }
        };
        match found {
            Ok(image) => {
                let path = at.path.filter(|_| !image.is_converted).map(str::to_owned);
                Some(self.push(at.name, path, image.bytes, image.format))
            }
            Err(Refused { what, remedy }) => {
                self.warn(&format!(
                    "the image {} of the material {material} {what}, so it is left out; {remedy}",
                    at.name
                ));
                None
            }
        }
    }

    /// A texture of those so far.
    pub(in super::super) fn texture(&self, number: u32) -> Option<&Texture> {
        self.looks.textures.get(number as usize)
    }

    /// A texture with the colour of one texture, white if it is `None`, and the alpha of another.
    pub(in super::super) fn combined(&mut self, color: Option<u32>, alpha: u32, of: AlphaOf) -> Option<u32> {
        if let Some(known) = self.combined.get(&(color, alpha, of)) {
            return *known;
        }
        let at = |texture: u32| &self.looks.textures[texture as usize];
        let made = with_alpha(color.map(|color| &*at(color).bytes), &at(alpha).bytes, of);
        let texture = match made {
            Ok(bytes) => {
                let stem = at(color.unwrap_or(alpha)).name.rsplit_once('.').map_or("", |(stem, _)| stem);
                let name = format!("{stem}-with-alpha.png");
                Some(self.push(&name, None, bytes, TextureFormat::Png))
            }
            Err(Refused { what, remedy }) => {
                self.warn(&format!(
                    "the image {} of an opacity {what}, so the opacity is left out; {remedy}",
                    at(alpha).name
                ));
                None
            }
        };
        self.combined.insert((color, alpha, of), texture);
        texture
    }

    /// Adds a texture whose name is like `name`.
    fn push(&mut self, name: &str, path: Option<String>, bytes: Vec<u8>, format: TextureFormat) -> u32 {
        let name = self.free_name(name, format);
        self.looks.textures.push(Texture { name, path, bytes: Arc::from(bytes) });
        (self.looks.textures.len() - 1) as u32
    }

    /// A name that no texture has, and that any file system takes.
    fn free_name(&mut self, name: &str, format: TextureFormat) -> String {
        let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
        let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
        let is_odd = |c: char| c.is_control() || r#"/\:*?"<>|[]#@%"#.contains(c);
        let mut stem: String = stem.chars().take(LONGEST_NAME).collect();
        stem = stem.replace(is_odd, "_").trim().to_owned();
        if stem.is_empty() {
            stem = "texture".to_owned();
        }
        let mut number = 1;
        loop {
            let candidate = match number {
                1 => format!("{stem}{}", format.ending()),
                _ => format!("{stem}-{number}{}", format.ending()),
            };
            if self.names.insert(candidate.to_lowercase()) {
                return candidate;
            }
            number += 1;
        }
    }

    /// What was gathered, without textures that no material uses.
    pub(super) fn finish(self) -> Looks {
        let Looks { mut materials, textures } = self.looks;
        let mut new_number: Vec<Option<u32>> = vec![None; textures.len()];
        let mut kept = Vec::new();
        for material in &mut materials {
            let Some(texture) = material.stated.texture else { continue };
            let number = new_number[texture as usize].unwrap_or_else(|| {
                kept.push(textures[texture as usize].clone());
                (kept.len() - 1) as u32
            });
            new_number[texture as usize] = Some(number);
            material.stated.texture = Some(number);
        }
        Looks { materials, textures: kept }
    }
}

/// The most characters of a texture's name, without its ending.
const LONGEST_NAME: usize = 100;
