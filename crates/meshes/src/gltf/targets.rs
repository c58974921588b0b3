//! The morph targets of a scene's meshes, as shapes of all of them together.

use super::super::shapes::Shape;
use super::accessor::Accessors;
use ::gltf::json::deserialize;
use ::gltf::json::mesh::{Mesh, Primitive};
use glam::{DMat4, DVec3};
use rhytid_core::{Error, Result};
use std::collections::{HashMap, HashSet};

/// What `extras` of a mesh say of its targets, as Blender, Maya and the glTF specification name them.
#[derive(serde::Deserialize, Default)]
struct Extras {
    #[serde(rename = "targetNames", default)]
    target_names: Vec<String>,
}

/// The names of a mesh's targets. No two are the same.
pub(super) fn names(mesh: &Mesh) -> Vec<String> {
    let extras = mesh.extras.as_ref().and_then(|extras| deserialize::from_str::<Extras>(extras.get()).ok());
    let named = extras.unwrap_or_default().target_names;
    let count = mesh.primitives.iter().filter_map(|primitive| primitive.targets.as_ref()).map(Vec::len).max();
    let mut taken = HashSet::new();
    // How often each name was there: a file may have the same one a million times.
    let mut times: HashMap<String, usize> = HashMap::new();
    let mut names = Vec::new();
    for number in 1..=count.unwrap_or(0) {
        let name = named.get(number - 1).cloned().unwrap_or_else(|| format!("shape {number}"));
        let times = times.entry(name.clone()).or_default();
        let free = loop {
            *times += 1;
            let free = if *times > 1 { format!("{name} {times}") } else { name.clone() };
            if taken.insert(free.clone()) {
                break free;
            }
        };
        names.push(free);
    }
    names
}

/// The shapes so far.
#[derive(Default)]
pub(super) struct Targets {
    shapes: Vec<Shape>,
    /// The places of names in `shapes`.
    numbers: HashMap<String, usize>,
    /// Displacements that are not 0.
    moved: u64,
    /// All displacements, most of which a sparse accessor leaves out.
    read: u64,
}

/// The most displacements for each byte of the file's data. Sparse shapes of a real head have up to ten.
const MOST_READ: u64 = 64;

impl Targets {
    /// Adds the targets of a primitive. Its `count` vertices were read to `first` and after, with the
    /// transform of their node.
    pub(super) fn add(
        &mut self,
        accessors: &Accessors<'_>,
        primitive: &Primitive,
        names: &[String],
        first: u32,
        count: u64,
        transform: DMat4,
    ) -> Result<()> {
        for (target, name) in primitive.targets.iter().flatten().zip(names) {
            let number = *self.numbers.entry(name.clone()).or_insert_with(|| {
                self.shapes.push(Shape { name: name.clone(), moved: Vec::new() });
                self.shapes.len() - 1
            });
            let Some(positions) = target.positions.map(|index| index.value()) else { continue };
            let file = accessors.name;
            if accessors.count(positions)? != count {
                return Err(Error::malformed(format!(
                    "{file}: the shape {name:?} moves {} vertices, expected the {count} of its mesh; export the \
                     mesh again",
                    accessors.count(positions)?
                )));
            }
            self.read += count;
            let bytes = accessors.buffers.total.saturating_add(1 << 16);
            if self.read > MOST_READ.saturating_mul(bytes) {
                return self.repeats(accessors);
            }
            let displacements = accessors.vectors::<3>(positions)?;
            let moved = (first..).zip(displacements).filter(|(_, by)| *by != [0.0; 3]);
            let before = self.shapes[number].moved.len();
            self.shapes[number].moved.extend(
                moved.map(|(v, by)| (v, transform.transform_vector3(DVec3::from_array(by)).to_array())),
            );
            // Each displacement is stored, so a real file has more bytes than displacements.
            self.moved += (self.shapes[number].moved.len() - before) as u64;
            if self.moved > bytes {
                return self.repeats(accessors);
            }
        }
        Ok(())
    }

    fn repeats(&self, accessors: &Accessors<'_>) -> Result<()> {
        let (file, bytes) = (accessors.name, accessors.buffers.total);
        Err(Error::unsupported_format(format!(
            "{file}: its shapes repeat the same data: {} displacements from {bytes} bytes; export it without \
             copies",
            self.read
        )))
    }

    /// All shapes, in the order in which they were found.
    pub(super) fn finish(self) -> Vec<Shape> {
        self.shapes
    }
}
