//! A mesh with shapes, as every format is given it.

use super::recipe::StatedRecipe;
use super::scene::Scene;
use rhytid_core::channel;
use rhytid_core::numbers::first_not_finite;
use rhytid_core::{Error, Faces, Materials, Result, UpAxis, Uvs};

/// A mesh with named shapes, each with a slider in the program that opens the file. The mesh does not move by
/// itself.
#[derive(Debug, Clone)]
pub struct Shapes<'a> {
    /// Names the mesh in the file; any text.
    pub name: &'a str,
    /// V×3 rest positions in mesh units: where all sliders are 0.
    pub rest: &'a [[f32; 3]],
    /// V×3 normals of the rest mesh, of length 1, or 0 at a vertex without area; `None` where the file is to
    /// have no normals.
    pub rest_normals: Option<&'a [[f32; 3]]>,
    /// The polygons of the input mesh.
    pub faces: &'a Faces,
    /// The polygons cut into triangles, as [`super::Scene::triangle_corners`].
    pub triangle_corners: &'a [[u32; 3]],
    /// Texture coordinates of the input mesh.
    pub uvs: Option<&'a Uvs>,
    /// The materials that the input mesh names.
    pub materials: Option<&'a Materials>,
    /// Metres in one mesh unit.
    pub metres_per_unit: f64,
    /// The mesh's up axis.
    pub up_axis: UpAxis,
    /// How the shapes were made.
    pub recipe: &'a StatedRecipe,
    /// The shapes, at least one.
    pub shapes: &'a [Shape],
}

/// The offsets that a slider at 1 adds to the rest pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Any text, different from the other shapes' names.
    pub name: String,
    /// V×3, in mesh units.
    pub offsets: Vec<[f32; 3]>,
    /// V×3, to be added to the rest normals; given for all shapes or for none.
    pub normal_offsets: Option<Vec<[f32; 3]>>,
}

/// A set of shapes without its mesh: what a take is fitted to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ShapeSet {
    /// V×3 positions in mesh units where all weights are 0.
    pub base: Vec<[f32; 3]>,
    /// V×3 normals of the base, of length 1, or 0 at a vertex without area; given if the shapes have normal
    /// offsets.
    pub base_normals: Option<Vec<[f32; 3]>>,
    /// The shapes, at least one.
    pub shapes: Vec<Shape>,
}

impl Shapes<'_> {
    /// Checks every length, index, number and name, so that the writers can rely on them.
    pub fn check(&self) -> Result<()> {
        match self.rest_scene().fault().or_else(|| self.fault_of_shapes()) {
            None => Ok(()),
            Some(fault) => Err(Error::bad_topology(format!("the shapes of “{}”: {fault}", self.name))),
        }
    }

    /// The rest pose as an animation of one frame, for the code that scenes and shapes share.
    pub fn rest_scene(&self) -> Scene<'_> {
        Scene {
            name: self.name,
            rest: self.rest,
            rest_normals: self.rest_normals,
            channels: if self.rest_normals.is_some() { std::slice::from_ref(&channel::NORMALS) } else { &[] },
            faces: self.faces,
            triangle_corners: self.triangle_corners,
            uvs: self.uvs,
            materials: self.materials,
            head: None,
            metres_per_unit: self.metres_per_unit,
            up_axis: self.up_axis,
            frames: 1,
            rate: 1.0,
            first_time_code: 0.0,
            recipe: self.recipe,
            further: &[],
        }
    }

    fn fault_of_shapes(&self) -> Option<String> {
        let first = self.shapes.first().map_or(Some("has no shapes, expected at least 1".into()), |_| None);
        let mut seen = std::collections::HashSet::new();
        first.or_else(|| {
            self.shapes.iter().find_map(|shape| {
                let fault = if seen.insert(shape.name.as_str()) {
                    self.fault_of_shape(shape)?
                } else {
                    "has the name of another shape".into()
                };
                Some(format!("the shape “{}” {fault}", shape.name))
            })
        })
    }

    fn fault_of_shape(&self, shape: &Shape) -> Option<String> {
        let vertices = self.rest.len();
        let with_normals = self.shapes[0].normal_offsets.is_some();
        if shape.normal_offsets.is_some() != with_normals {
            return Some("differs from the first shape in whether it has normal offsets".into());
        }
        if with_normals && self.rest_normals.is_none() {
            return Some("has normal offsets, expected none where there are no rest normals".into());
        }
        [("offsets", Some(&shape.offsets)), ("normal offsets", shape.normal_offsets.as_ref())]
            .into_iter()
            .find_map(|(what, offsets)| {
                let offsets = offsets?;
                if offsets.len() != vertices {
                    return Some(format!("has {} {what} for {vertices} vertices", offsets.len()));
                }
                let vertex = first_not_finite(offsets.as_flattened())? / 3;
                Some(format!("has {what} that are not finite, first at vertex {vertex}"))
            })
    }
}
