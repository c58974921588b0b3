//! The looks of materials with USD's preview surface.

use super::mesh::material_name;
use super::tree::{Placed, Tree};
use super::values::Values;
use crate::looks::{AlphaOf, Gathered, ImageAt};
use rhytid_core::text::quoted;
use rhytid_core::{Error, Reach, Result, StatedLook, Transparency, input_file, named_file};
use rhytid_usd::layer::Value;
use rhytid_usd::read::{attribute, package_member};
use std::path::Path;

/// The most connections from an input to what it has in the end.
const MOST_CONNECTIONS: usize = 16;

/// What reads materials.
struct Reader<'a, 'l, 'v, 'g> {
    tree: &'a Tree<'l>,
    values: &'a mut Values<'v>,
    gathered: &'a mut Gathered<'g>,
    path: &'a Path,
    /// The bytes of a package, whose images are in it.
    package: Option<&'a [u8]>,
    reach: Reach,
}

/// What an input of a shader has.
enum Input {
    Nothing,
    Value(Value),
    Texture(Connected),
    /// The output of a shader of another kind.
    Other(String),
}

/// An output of a texture shader.
struct Connected {
    /// The path of the shader.
    shader: String,
    /// Such as `rgb` or `a`.
    output: String,
}

/// The looks of all materials of a layer, whose prims are `tree`. `package` has its bytes if it is one.
pub(super) fn read(
    tree: &Tree<'_>,
    values: &mut Values<'_>,
    path: &Path,
    package: Option<&[u8]>,
    reach: Reach,
    gathered: &mut Gathered<'_>,
) -> Result<()> {
    let mut reader = Reader { tree, values, gathered, path, package, reach };
    for material in tree.of_type("Material") {
        reader.material(material)?;
    }
    Ok(())
}

impl<'l> Reader<'_, 'l, '_, '_> {
    fn material(&mut self, material: &Placed<'l>) -> Result<()> {
        let name = material_name(self.tree, &material.path);
        let surface = match self.input(material, "outputs:surface")? {
            Input::Other(path) => self.tree.at(&path),
            _ => None,
        };
        let is_preview = |surface: &&Placed<'_>| id(surface) == Some("UsdPreviewSurface");
        let Some(surface) = surface.filter(is_preview) else {
            let has_shader = material.prim.children.iter().any(|child| child.type_name == "Shader");
            if has_shader {
                self.gathered.warn(&format!(
                    "the material {} has no UsdPreviewSurface, so its look is not read; export it with one",
                    quoted(&name)
                ));
            }
            return Ok(());
        };
        let mut stated = StatedLook::default();
        let mut color_shader = None;
        let mut scale = None;
        match self.input(surface, "inputs:diffuseColor")? {
            Input::Nothing => {}
            Input::Value(value) => stated.base_color = color(&value),
            Input::Texture(connected) => {
                stated.texture = self.texture(&connected, &name, true)?;
                scale = self.scale(&connected.shader)?.filter(|_| stated.texture.is_some());
                stated.base_color = scale.map(|[red, green, blue, _]| [red, green, blue]);
                color_shader = Some(connected.shader);
            }
            Input::Other(path) => self.not_read(&name, "diffuseColor", &path),
        }
        stated.opacity = self.number(surface, "opacity", &name)?;
        stated.roughness = self.number(surface, "roughness", &name)?;
        stated.metallic = self.number(surface, "metallic", &name)?;
        let mut has_alpha = false;
        if let Input::Texture(connected) = self.input(surface, "inputs:opacity")? {
            if color_shader.as_ref() == Some(&connected.shader) && connected.output == "a" {
                has_alpha = stated.texture.is_some();
                stated.opacity = scale.map(|[.., alpha]| alpha);
            } else if let Some(alpha) = self.texture(&connected, &name, false)? {
                let of = if connected.output == "a" { AlphaOf::Alpha } else { AlphaOf::Brightness };
                if let Some(combined) = self.gathered.combined(stated.texture, alpha, of) {
                    (stated.texture, has_alpha) = (Some(combined), true);
                }
            }
        }
        let cutoff = self.number(surface, "opacityThreshold", &name)?.filter(|cutoff| *cutoff > 0.0);
        let is_clear = has_alpha || stated.opacity.is_some_and(|opacity| opacity < 1.0);
        stated.transparency = match cutoff {
            Some(cutoff) => Some(Transparency::Mask(cutoff)),
            None if is_clear => Some(Transparency::Blend),
            None if stated.opacity.is_some() || stated.texture.is_some() => Some(Transparency::Opaque),
            None => None,
        };
        self.gathered.add(name, stated);
        Ok(())
    }

    /// A number from 0 to 1.
    fn number(&mut self, surface: &Placed<'l>, name: &str, material: &str) -> Result<Option<f32>> {
        let number = match self.input(surface, &format!("inputs:{name}"))? {
            Input::Nothing => return Ok(None),
            Input::Value(Value::Float(x)) => f64::from(x),
            Input::Value(Value::Double(x)) => x,
            Input::Value(_) => f64::NAN,
            // The image of an opacity is read elsewhere. Those of roughness and metal are not read.
            Input::Texture(_) => return Ok(None),
            Input::Other(shader) => {
                self.not_read(material, name, &shader);
                return Ok(None);
            }
        };
        if number.is_nan() {
            self.gathered.warn(&format!(
                "the {name} of the material {} is no number, so it is left out; export it again",
                quoted(material)
            ));
            return Ok(None);
        }
        Ok(Some(number.clamp(0.0, 1.0) as f32))
    }

    fn not_read(&self, material: &str, input: &str, path: &str) {
        self.gathered.warn(&format!(
            "the {input} of the material {} comes from {path}, which is not read; bake it into a number, or into \
             an image of the base colour",
            quoted(material)
        ));
    }

    /// What an input has in the end: connections through materials and groups are followed.
    fn input(&mut self, placed: &Placed<'l>, name: &str) -> Result<Input> {
        let (mut path, mut name) = (placed.path.clone(), name.to_owned());
        for _ in 0..MOST_CONNECTIONS {
            let Some(found) = self.tree.at(&path) else { return Ok(Input::Nothing) };
            let connection = attribute(found.prim, &name).and_then(|found| found.connections.first());
            let Some((next, output)) = connection.and_then(|connection| connection.rsplit_once('.')) else {
                return Ok(self.values.get(found.prim, &name)?.map_or(Input::Nothing, Input::Value));
            };
            let Some(source) = self.tree.at(next) else { return Ok(Input::Other(next.to_owned())) };
            if source.prim.type_name == "Shader" {
                let shader = next.to_owned();
                return Ok(match id(source) {
                    Some("UsdUVTexture") => {
                        let output = output.trim_start_matches("outputs:").to_owned();
                        Input::Texture(Connected { shader, output })
                    }
                    _ => Input::Other(shader),
                });
            }
            (path, name) = (next.to_owned(), output.to_owned());
        }
        Ok(Input::Nothing)
    }

    /// The texture that a texture shader reads.
    fn texture(&mut self, connected: &Connected, material: &str, is_color: bool) -> Result<Option<u32>> {
        let Some(shader) = self.tree.at(&connected.shader) else { return Ok(None) };
        let file = match self.input(shader, "inputs:file")? {
            Input::Value(Value::Asset(file)) if !file.is_empty() => file,
            _ => {
                self.gathered.warn(&format!(
                    "{} names no file, so the material {} is without its image; export it again",
                    connected.shader,
                    quoted(material)
                ));
                return Ok(None);
            }
        };
        let is_raw = self.input(shader, "inputs:sourceColorSpace")?;
        if is_color && matches!(is_raw, Input::Value(Value::Token(space)) if space == "raw") {
            self.gathered.warn(&format!(
                "{} says that the colours of {file} are raw, but they are read as sRGB; save the image as sRGB",
                connected.shader
            ));
        }
        if matches!(self.input(shader, "inputs:st")?, Input::Other(path) if self.is_moved(&path)) {
            self.gathered.warn(&format!(
                "the texture coordinates of {} are moved or scaled (UsdTransform2d), which is not read; bake it \
                 into the texture coordinates",
                connected.shader
            ));
        }
        let (path, package, reach) = (self.path, self.package, self.reach);
        let at = ImageAt { key: &file, name: &file, path: Some(file.as_str()).filter(|_| package.is_none()) };
        Ok(self.gathered.image(&at, material, || {
            let name = path.display();
            if let Some(bytes) = package {
                return package_member(bytes, &name.to_string(), &file)?.ok_or_else(|| {
                    Error::bad_path(format!("{name}: has no member {file}; export it again with its images"))
                });
            }
            let found = named_file(path, Path::new(&file), "inputs:file", reach)?;
            input_file::read(&found, input_file::LARGEST_MESH_OR_TAKE)
        }))
    }

    /// What a texture is multiplied by, each from 0 to 1.
    fn scale(&mut self, shader: &str) -> Result<Option<[f32; 4]>> {
        let Some(shader) = self.tree.at(shader) else { return Ok(None) };
        Ok(match self.input(shader, "inputs:scale")? {
            Input::Value(Value::Float4(scale)) if scale.iter().all(|part| part.is_finite()) => {
                Some(scale.map(|part| part.clamp(0.0, 1.0)))
            }
            _ => None,
        })
    }

    fn is_moved(&self, path: &str) -> bool {
        self.tree.at(path).is_some_and(|shader| id(shader) == Some("UsdTransform2d"))
    }
}

/// Which shader it is.
fn id<'a>(shader: &Placed<'a>) -> Option<&'a str> {
    match &attribute(shader.prim, "info:id")?.default {
        Some(Value::Token(id)) => Some(id),
        _ => None,
    }
}

fn color(value: &Value) -> Option<[f32; 3]> {
    let color = match value {
        Value::Float3(color) => *color,
        Value::Double3(color) => color.map(|part| part as f32),
        _ => return None,
    };
    color.iter().all(|part| part.is_finite()).then(|| color.map(|part| part.clamp(0.0, 1.0)))
}
