//! MTL, the materials of OBJ. `Kd` is linear, as Blender takes it, and does not count below a `map_Kd`.

use super::super::{obj, recognise, text};
use super::gathered::{Gathered, ImageAt};
use super::image::{AlphaOf, has_alpha};
use rhytid_core::text::quoted;
use rhytid_core::{Reach, Result, StatedLook, Transparency, input_file, named_file};
use std::collections::{BTreeSet, HashSet};
use std::path::{Path, PathBuf};

/// The looks of the materials of an OBJ, whose MTL files it names.
pub(super) fn of_obj(path: &Path, bytes: &[u8], reach: Reach, gathered: &mut Gathered<'_>) {
    let mut read = HashSet::new();
    let mut used = BTreeSet::new();
    let mut are_all_read = true;
    for Statement { keyword, rest, .. } in statements(bytes) {
        if keyword == "usemtl" {
            used.insert(rest);
            continue;
        }
        if keyword != "mtllib" {
            continue;
        }
        for file in named_libraries(path, &rest) {
            if !read.insert(file.clone()) {
                continue;
            }
            let found = named_file(path, Path::new(&file), "mtllib", reach).and_then(|mtl| {
                let bytes = input_file::read(&mtl, input_file::LARGEST_MESH_OR_TAKE)?;
                of_mtl(&mtl, &bytes, reach, gathered)
            });
            if let Err(error) = found {
                are_all_read = false;
                log::warn!(
                    "{error}; so its materials have default looks; put {} beside {} to have theirs",
                    quoted(&file),
                    path.display()
                );
            }
        }
    }
    if !read.is_empty() && are_all_read {
        warn_of_unknown(used, gathered);
    }
}

/// Warns of materials that faces have and no MTL states.
fn warn_of_unknown(mut used: BTreeSet<String>, gathered: &Gathered<'_>) {
    used.retain(|name| !gathered.knows(name));
    let Some(first) = used.first() else { return };
    let others = match used.len() - 1 {
        0 => String::new(),
        n => format!(" (and {n} more)"),
    };
    gathered.warn(&format!(
        "the material {}{others} is in none of its files of materials, so it has a default look; export the mesh \
         and its materials again",
        quoted(first)
    ));
}

/// The files that a `mtllib` names: one whose name may have blanks in it, or several.
fn named_libraries(path: &Path, rest: &str) -> Vec<String> {
    let rest = rest.replace('\\', "/");
    let is_there = |file: &str| path.parent().unwrap_or(Path::new("")).join(file).exists();
    let words: Vec<String> = rest.split_whitespace().map(str::to_owned).collect();
    let are_files = words.iter().all(|word| word.to_lowercase().ends_with(".mtl"));
    if are_files && !is_there(&rest) { words } else { vec![rest] }
}

/// The looks of the materials of an MTL.
///
/// # Errors
/// [`rhytid_core::Error::Input`] if it is no text.
pub(super) fn of_mtl(path: &Path, bytes: &[u8], reach: Reach, gathered: &mut Gathered<'_>) -> Result<()> {
    recognise::expect_text(bytes, &path.display().to_string())?;
    let mut current: Option<Stated> = None;
    for statement in statements(bytes) {
        if statement.keyword == "newmtl" {
            let finished = current.replace(Stated { name: statement.rest, ..Stated::default() });
            finished.into_iter().for_each(|material| material.give_to(path, reach, gathered));
        } else if let Some(material) = &mut current {
            material.take(&statement, path, gathered);
        }
    }
    current.into_iter().for_each(|material| material.give_to(path, reach, gathered));
    Ok(())
}

/// What an MTL states about a material. The first statement of a kind counts.
#[derive(Default)]
struct Stated {
    name: String,
    color: Option<[f32; 3]>,
    /// `d`.
    opacity: Option<f32>,
    /// `Tr`, what `d` leaves of 1.
    transparency: Option<f32>,
    /// `Ns`, 0 to 1,000.
    shininess: Option<f32>,
    roughness: Option<f32>,
    metallic: Option<f32>,
    color_map: Option<String>,
    opacity_map: Option<String>,
}

impl Stated {
    fn take(&mut self, statement: &Statement, path: &Path, gathered: &Gathered<'_>) {
        let numbers = || statement.rest.split_whitespace().filter(|word| *word != "-halo");
        let number = || numbers().next().and_then(|word| word.parse::<f32>().ok()).filter(|x| x.is_finite());
        let keyword = statement.keyword.as_str();
        let place = match keyword {
            "Kd" => {
                let parts: Option<Vec<f32>> = numbers().take(3).map(|word| word.parse().ok()).collect();
                let color = match parts.as_deref() {
                    Some(&[grey]) => Some([grey; 3]),
                    Some(&[red, green, blue]) => Some([red, green, blue]),
                    _ => None,
                };
                let Some(color) = color.filter(|color| color.iter().all(|part| part.is_finite())) else {
                    return self.odd(statement, path, "red, green and blue, each 0 to 1");
                };
                self.color.get_or_insert(color.map(|part| part.clamp(0.0, 1.0)));
                return;
            }
            "map_Kd" | "map_d" => {
                let map = if keyword == "map_d" { &mut self.opacity_map } else { &mut self.color_map };
                let found = Map::of(&statement.rest);
                if found.is_moved && map.is_none() {
                    gathered.warn(&format!(
                        "the {keyword} of the material {} is moved or scaled (-o, -s or -t), which is not read; \
                         bake it into the texture coordinates",
                        quoted(&self.name)
                    ));
                }
                map.get_or_insert(found.file);
                return;
            }
            "d" => &mut self.opacity,
            "Tr" => &mut self.transparency,
            "Ns" => &mut self.shininess,
            "Pr" => &mut self.roughness,
            "Pm" => &mut self.metallic,
            _ => return,
        };
        let Some(x) = number() else { return self.odd(statement, path, "a number") };
        let largest = if keyword == "Ns" { 1000.0 } else { 1.0 };
        place.get_or_insert(x.clamp(0.0, largest));
    }

    fn odd(&self, statement: &Statement, path: &Path, expected: &str) {
        log::warn!(
            "{}, line {}: {} of the material {} is {}, expected {expected}; it is left out; export the file again",
            path.display(),
            statement.line,
            statement.keyword,
            quoted(&self.name),
            quoted(&statement.rest)
        );
    }

    fn give_to(self, path: &Path, reach: Reach, gathered: &mut Gathered<'_>) {
        let color_map =
            self.color_map.as_ref().and_then(|file| self.image(file, "map_Kd", path, reach, gathered));
        let opacity_map =
            self.opacity_map.as_ref().and_then(|file| self.image(file, "map_d", path, reach, gathered));
        let mut texture = color_map;
        let mut has_alpha_map = false;
        if let Some(alpha) = opacity_map {
            if color_map == opacity_map {
                has_alpha_map = gathered.texture(alpha).is_some_and(|found| has_alpha(&found.bytes));
            } else if let Some(combined) = gathered.combined(color_map, alpha, AlphaOf::Either) {
                (texture, has_alpha_map) = (Some(combined), true);
            }
        }
        let opacity = self.opacity.or(self.transparency.map(|transparency| 1.0 - transparency));
        let transparency = match opacity {
            _ if has_alpha_map => Some(Transparency::Blend),
            Some(opacity) if opacity < 1.0 => Some(Transparency::Blend),
            Some(_) => Some(Transparency::Opaque),
            // The alpha of a colour counts only if the MTL says so.
            None => texture.map(|_| Transparency::Opaque),
        };
        let stated = StatedLook {
            base_color: if color_map.is_some() { None } else { self.color },
            texture,
            opacity,
            transparency,
            // As Blender does.
            roughness: self.roughness.or(self.shininess.map(|shininess| 1.0 - (shininess / 1000.0).sqrt())),
            metallic: self.metallic,
        };
        gathered.add(self.name, stated);
    }

    /// The texture of the image that the MTL at `path` names.
    fn image(
        &self,
        file: &str,
        what: &str,
        path: &Path,
        reach: Reach,
        gathered: &mut Gathered<'_>,
    ) -> Option<u32> {
        let key = path.with_file_name(file).display().to_string();
        let at = ImageAt { key: &key, name: file, path: Some(file) };
        gathered.image(&at, &self.name, || {
            let found = found_image(path, file, what, reach)?;
            input_file::read(&found, input_file::LARGEST_MESH_OR_TAKE)
        })
    }
}

/// The image that the MTL at `path` names. If it is not there, or has the path of another machine, the file
/// of its name beside the MTL stands for it, as in Blender.
fn found_image(path: &Path, file: &str, what: &str, reach: Reach) -> Result<PathBuf> {
    let named = named_file(path, Path::new(file), what, reach);
    if named.as_ref().is_ok_and(|found| found.exists()) {
        return named;
    }
    let last = file.rsplit('/').next().unwrap_or(file);
    let beside = named_file(path, Path::new(last), what, reach);
    if beside.as_ref().is_ok_and(|found| found.exists()) { beside } else { named }
}

/// A map: a file behind options such as `-s 1 1 1` and `-clamp on`.
struct Map {
    /// With slashes.
    file: String,
    /// Whether options move or scale it.
    is_moved: bool,
}

impl Map {
    fn of(text: &str) -> Self {
        let mut rest = text.trim_start();
        let mut is_moved = false;
        while rest.starts_with('-') {
            let (option, mut after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
            let is_vector = matches!(option, "-o" | "-s" | "-t");
            let count = match option {
                _ if is_vector => 3,
                "-mm" => 2,
                _ => 1,
            };
            let neutral = if option == "-s" { 1.0 } else { 0.0 };
            for i in 0..count {
                after = after.trim_start();
                let (word, behind) = after.split_once(char::is_whitespace).unwrap_or((after, ""));
                let number = word.parse::<f64>();
                // Vectors may be shorter than three numbers.
                if is_vector && i > 0 && number.is_err() {
                    break;
                }
                is_moved |= is_vector && number != Ok(neutral);
                after = behind;
            }
            rest = after.trim_start();
        }
        Self { file: rest.replace('\\', "/"), is_moved }
    }
}

/// A statement of an OBJ or MTL.
struct Statement {
    keyword: String,
    /// What is behind the keyword: names may have blanks in them. Never empty.
    rest: String,
    /// From 1.
    line: usize,
}

fn statements(bytes: &[u8]) -> impl Iterator<Item = Statement> {
    obj::statements(bytes).filter_map(|statement| {
        let keyword = text::name(obj::words(&statement.text).next()?);
        let rest = text::name(obj::rest_of_line(&statement.text));
        let line = statement.line;
        (!rest.is_empty()).then_some(Statement { keyword, rest, line })
    })
}
