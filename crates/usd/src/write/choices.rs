//! What an export chooses about its layer, beside the scene.

use super::names::identifier;
use super::textures::Assets;
use crate::layer::{Layer, Specifier, Value};
use crate::read::{SCALE, attribute, face_of};
use rhytid_export::{Options, Scene, Subdivision};

/// What an export chooses about its layer.
pub(crate) struct Choices {
    /// Where images are.
    pub(super) assets: Assets,
    /// The names of the prims from the root to the face's; `None` for the mesh's name alone.
    pub(super) prim_path: Option<Vec<String>>,
    mesh_name: Option<String>,
    pub(super) over: bool,
    pub(super) metres: bool,
    pub(super) subdivision: Subdivision,
}

impl Choices {
    /// Those of `options`, with images at these paths.
    pub(super) fn new(options: &Options, assets: Assets) -> Self {
        Self {
            assets,
            prim_path: options.prim_path.as_ref().map(|path| path.names().to_vec()),
            mesh_name: options.mesh_name.clone(),
            over: options.over,
            metres: options.metres,
            subdivision: options.subdivision,
        }
    }

    /// Those with which an export would have written `found`, as far as they can be told.
    pub(crate) fn of_layer(found: &Layer, assets: Assets) -> Self {
        let plain = Self::new(&Options::default(), assets);
        let Some(face) = face_of(found) else { return plain };
        let scheme_of = |mesh| match &attribute(mesh, "subdivisionScheme")?.default {
            Some(Value::Token(token)) => Some(token),
            _ => None,
        };
        let is_smooth =
            face.mesh.and_then(scheme_of).is_some_and(|token| token == scheme(Subdivision::CatmullClark));
        Self {
            prim_path: Some(face.path.iter().map(|name| (*name).to_owned()).collect()),
            mesh_name: face.mesh.map(|mesh| mesh.name.clone()),
            over: face.prim.specifier == Specifier::Over,
            metres: attribute(face.prim, SCALE).is_some(),
            subdivision: if is_smooth { Subdivision::CatmullClark } else { Subdivision::None },
            ..plain
        }
    }

    /// The names of the prims above the face's, and its own.
    pub(super) fn path(&self, scene: &Scene<'_>) -> (Vec<String>, String) {
        let mut names = self.prim_path.clone().unwrap_or_default();
        let name = names.pop().unwrap_or_else(|| identifier(scene.name));
        (names, name)
    }

    /// The name of the mesh's prim below the face's.
    pub(super) fn mesh(&self, face: &str) -> String {
        self.mesh_name.clone().unwrap_or_else(|| format!("{face}_mesh"))
    }
}

/// USD's word for it.
pub(super) fn scheme(subdivision: Subdivision) -> &'static str {
    match subdivision {
        Subdivision::None => "none",
        Subdivision::CatmullClark => "catmullClark",
    }
}
