//! The morph targets of a scene's meshes, as shapes of all of them together.

use super::super::shapes::Shape;
use super::accessor::Accessors;
use super::skin::Placement;
use ::gltf::json::deserialize;
use ::gltf::json::extras::Extras as Raw;
use ::gltf::json::mesh::{Mesh, Primitive};
use ::gltf::json::scene::Node;
use glam::DVec3;
use rhytid_core::{Error, Result};
use std::collections::{HashMap, HashSet};

/// What `extras` say of targets: those of a mesh, as Blender, Maya and the glTF specification have them, else
/// those of its primitives, as UniVRM has them.
#[derive(serde::Deserialize, Default)]
struct Extras {
    #[serde(rename = "targetNames", default)]
    target_names: Vec<String>,
}

/// The names of a mesh's targets. No two are the same.
pub(super) fn names(mesh: &Mesh) -> Vec<String> {
    let said = |extras: &Raw| {
        let extras = deserialize::from_str::<Extras>(extras.as_ref()?.get()).ok()?;
        Some(extras.target_names).filter(|names| !names.is_empty())
    };
    let mut places = std::iter::once(&mesh.extras).chain(mesh.primitives.iter().map(|p| &p.extras));
    let named = places.find_map(said).unwrap_or_default();
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
    /// Adds the targets of a primitive. Its `count` vertices were read to `first` and after, and placed.
    pub(super) fn add(
        &mut self,
        accessors: &Accessors<'_>,
        primitive: &Primitive,
        names: &[String],
        first: u32,
        count: u64,
        placement: &Placement,
    ) -> Result<()> {
        for (target, name) in primitive.targets.iter().flatten().zip(names) {
            let number = *self.numbers.entry(name.clone()).or_insert_with(|| {
                self.shapes.push(Shape { name: name.clone(), moved: Vec::new() });
                self.shapes.len() - 1
            });
            let Some(positions) = target.positions.map(|index| index.value()) else {
                self.read += 1;
                continue;
            };
            let file = accessors.name;
            if accessors.count(positions)? != count {
                return Err(Error::malformed(format!(
                    "{file}: the shape {name:?} moves {} vertices, expected the {count} of its mesh; export the \
                     mesh again",
                    accessors.count(positions)?
                )));
            }
            self.read += count;
            let bytes = accessors.buffers.total().saturating_add(1 << 16);
            if self.read > MOST_READ.saturating_mul(bytes) {
                return self.repeats(accessors);
            }
            let displacements = accessors.vectors::<3>(positions)?;
            let before = self.shapes[number].moved.len();
            for (v, by) in displacements.into_iter().enumerate().filter(|(_, by)| *by != [0.0; 3]) {
                let by = placement.of(v).transform_vector3(DVec3::from_array(by));
                self.shapes[number].moved.push((first + v as u32, by.to_array()));
            }
            // Each displacement is stored, so a real file has more bytes than displacements.
            self.moved += (self.shapes[number].moved.len() - before) as u64;
            if self.moved > bytes {
                return self.repeats(accessors);
            }
        }
        Ok(())
    }

    fn repeats(&self, accessors: &Accessors<'_>) -> Result<()> {
        let (file, bytes) = (accessors.name, accessors.buffers.total());
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

/// The shapes that a file shows at rest. A mesh is read without them.
#[derive(Default)]
pub(super) struct Shown {
    /// The first few, with their weights.
    named: Vec<String>,
    others: usize,
}

/// So many shapes are named in a warning.
const NAMED: usize = 4;

impl Shown {
    /// Adds the shapes of a mesh at a node. `names` gives the names of its targets.
    pub(super) fn add(&mut self, node: &Node, mesh: &Mesh, names: &[String]) {
        let weights = node.weights.as_ref().or(mesh.weights.as_ref());
        for (name, weight) in names.iter().zip(weights.into_iter().flatten()).filter(|(_, w)| **w != 0.0) {
            let said = format!("{name:?} (weight {weight})");
            if self.named.contains(&said) {
                continue;
            }
            match self.named.len() < NAMED {
                true => self.named.push(said),
                false => self.others += 1,
            }
        }
    }

    pub(super) fn warn(&self, file: &str) {
        if self.named.is_empty() {
            return;
        }
        let others = match self.others {
            0 => String::new(),
            others => format!(" and {others} more"),
        };
        log::warn!(
            "{file}: shows its mesh with the shapes {}{others}, and the mesh is read without them; export it with \
             all weights at 0, or apply the shapes to the mesh before the export if it is to have them",
            self.named.join(", ")
        );
    }
}
