//! Meshes of a USD layer: those of its own prims, each where its transforms place it.
//!
//! References, payloads, inherited prims and variants are not followed.

mod looks;
mod mesh;
mod place;
mod shapes;
mod tree;
mod values;

use super::looks::Gathered;
use super::materials::Assigned;
use super::read::Selection;
use super::shapes::{MeshPart, Shape, Shapes, Space};
use super::uvs::{self, CornerUvs};
use mesh::PrimMesh;
use rhytid_core::{Error, InputErrorKind, Mesh, Reach, Result, UpAxis};
use rhytid_usd::layer::{Layer, Prim, Value};
use rhytid_usd::read::{Opened, field};
use std::collections::HashMap;
use std::path::Path;
use tree::{Placed, Tree};
use values::Values;

/// The meshes of a layer as one, in the order of its prims, parents first. `name` is for messages.
pub(super) fn read(bytes: Vec<u8>, name: &str, selection: &Selection) -> Result<Shapes> {
    let size = bytes.len() as u64;
    let opened = rhytid_usd::read::decode(bytes, name)?;
    let Opened { layer, samples, unread } = opened;
    let mut values = Values { samples, time: selection.time, used_time: false, name };
    let tree = Tree::new(&layer, &mut values)?;
    let chosen = chosen(&tree, selection, &layer, &unread, name)?;
    let wears = shapes::worn(&tree, &mut values)?;
    let mut joined = Joined::default();
    for placed in &chosen {
        let read = mesh::read(placed, &tree, &wears, &mut values)?;
        joined.add(read, size, name)?;
    }
    if let Some(time) = selection.time.filter(|_| !values.used_time) {
        return Err(Error::out_of_range(format!(
            "{name}: nothing in it has time samples, so it has no pose of its own at time {time}; leave the time out"
        )));
    }
    warn_left_out(&layer, &unread, name);
    if selection.prim.is_none() {
        warn_other_shapes(&other_shapes(&tree), name);
    }
    Ok(joined.finish(space(&layer), name))
}

/// The looks of the materials of the layer `bytes` in the file `path`.
pub(super) fn looks(bytes: Vec<u8>, path: &Path, reach: Reach, gathered: &mut Gathered<'_>) -> Result<()> {
    let name = gathered.name();
    let package = bytes.starts_with(b"PK").then(|| bytes.clone());
    let Opened { layer, samples, .. } = rhytid_usd::read::decode(bytes, name)?;
    let mut values = Values { samples, time: None, used_time: false, name };
    let tree = Tree::new(&layer, &mut values)?;
    looks::read(&tree, &mut values, path, package.as_deref(), reach, gathered)
}

/// The meshes that are wanted.
fn chosen<'a>(
    tree: &'a Tree<'a>,
    selection: &Selection,
    layer: &Layer,
    unread: &[String],
    name: &str,
) -> Result<Vec<&'a Placed<'a>>> {
    let meshes: Vec<&Placed<'_>> = tree.of_type("Mesh").collect();
    if let Some(wanted) = &selection.prim {
        let wanted = wanted.trim_end_matches('/');
        let below = format!("{wanted}/");
        let is_wanted = |placed: &&&Placed<'_>| placed.path == wanted || placed.path.starts_with(&below);
        let found: Vec<&Placed<'_>> = meshes.iter().filter(is_wanted).copied().collect();
        if found.is_empty() {
            return Err(Error::input(format!(
                "{name}: has no mesh at the prim {wanted} or below it, found {}",
                list(&meshes)
            ))
            .of_kind(InputErrorKind::UnknownName { name: wanted.to_owned() }));
        }
        return Ok(found);
    }
    let shown: Vec<&Placed<'_>> = meshes.iter().filter(|placed| placed.inherited.is_shown).copied().collect();
    if shown.len() < meshes.len() && !shown.is_empty() {
        let hidden: Vec<&Placed<'_>> =
            meshes.iter().filter(|placed| !placed.inherited.is_shown).copied().collect();
        log::warn!("{name}: meshes that are invisible, guides or proxies are left out: {}", list(&hidden));
    }
    if !shown.is_empty() {
        return Ok(shown);
    }
    let shapes = other_shapes(tree);
    let cure = match others(layer, unread) {
        _ if !meshes.is_empty() => format!(
            "all its meshes are invisible, guides or proxies: {}; name one as the prim that is meant",
            list(&meshes)
        ),
        true => {
            "has no mesh of its own, but refers to other files or prims; flatten it into one file, as with \
                 usdcat --flatten"
                .to_owned()
        }
        false if !shapes.is_empty() => {
            format!("has no mesh, but shapes of other kinds: {}; convert them to meshes", kinds(&shapes))
        }
        false => "has no mesh, expected a scan; export the surface as a mesh".to_owned(),
    };
    Err(Error::empty(format!("{name}: {cure}")))
}

/// What shows a surface, or copies of one, without being a mesh.
const OTHER_SHAPES: [&str; 9] =
    ["Sphere", "Cube", "Cylinder", "Cone", "Capsule", "Plane", "NurbsPatch", "TetMesh", "PointInstancer"];

/// The prims that show a surface and are no meshes.
fn other_shapes<'a>(tree: &'a Tree<'a>) -> Vec<&'a Placed<'a>> {
    let is_other = |placed: &&Placed<'_>| {
        placed.inherited.is_shown && OTHER_SHAPES.contains(&placed.prim.type_name.as_str())
    };
    tree.prims.iter().filter(is_other).collect()
}

/// Says that surfaces are left out that are no meshes.
fn warn_other_shapes(shapes: &[&Placed<'_>], name: &str) {
    if !shapes.is_empty() {
        log::warn!(
            "{name}: shapes that are no meshes are left out: {}; convert them to meshes if they are a part of the \
             face",
            kinds(shapes)
        );
    }
}

/// Paths and types for a message.
fn kinds(shapes: &[&Placed<'_>]) -> String {
    const SHOWN: usize = 4;
    let named =
        shapes.iter().take(SHOWN).map(|placed| format!("{} ({})", placed.path, placed.prim.type_name));
    let mut named: Vec<String> = named.collect();
    if shapes.len() > SHOWN {
        named.push(format!("{} more", shapes.len() - SHOWN));
    }
    named.join(", ")
}

/// Paths for a message.
fn list(meshes: &[&Placed<'_>]) -> String {
    const SHOWN: usize = 8;
    let mut paths: Vec<&str> = meshes.iter().take(SHOWN).map(|placed| &*placed.path).collect();
    if meshes.len() > SHOWN {
        paths.push("…");
    }
    if paths.is_empty() { "none".to_owned() } else { paths.join(", ") }
}

/// The fields by which a prim or a layer takes in what is elsewhere.
const REFERRING: [&str; 5] = ["references", "payload", "inheritPaths", "specializes", "subLayers"];

/// Whether the layer says that more is in other files, or elsewhere in this one.
fn others(layer: &Layer, unread: &[String]) -> bool {
    fn refers(prim: &Prim) -> bool {
        REFERRING.iter().any(|name| field(&prim.metadata, name).is_some()) || prim.children.iter().any(refers)
    }
    unread.iter().any(|what| REFERRING.contains(&what.as_str())) || layer.prims.iter().any(refers)
}

/// Says what of the layer is not read.
fn warn_left_out(layer: &Layer, unread: &[String], name: &str) {
    if others(layer, unread) {
        log::warn!(
            "{name}: refers to other files or prims, which are not followed; if they have meshes too, flatten all \
             into one file, as with usdcat --flatten"
        );
    }
    if let Some(what) = unread.iter().find(|what| what.starts_with("the variant set ")) {
        log::warn!("{name}: {what} is not read; export the variant that is meant alone");
    }
}

/// The space that the layer states.
fn space(layer: &Layer) -> Space {
    let metres_per_unit = match field(&layer.metadata, "metersPerUnit") {
        Some(Value::Double(metres)) if *metres > 0.0 && metres.is_finite() => Some(*metres),
        _ => None,
    };
    let up = match field(&layer.metadata, "upAxis") {
        Some(Value::Token(axis)) if axis == "Z" => Some(UpAxis::Z),
        Some(Value::Token(axis)) if axis == "Y" => Some(UpAxis::Y),
        _ => None,
    };
    Space { metres_per_unit, up }
}

/// Several meshes as one.
#[derive(Default)]
struct Joined {
    mesh: Mesh,
    uvs: CornerUvs,
    materials: Assigned,
    shapes: Vec<Shape>,
    parts: Vec<MeshPart>,
    /// The places of names in `shapes`.
    numbers: HashMap<String, usize>,
    /// Displacements of all shapes.
    moved: u64,
}

/// The most displacements for each byte of the file.
const MOST_MOVED: u64 = 8;

impl Joined {
    /// Adds a mesh of a file with so many bytes.
    fn add(&mut self, read: PrimMesh, size: u64, name: &str) -> Result<()> {
        let first = self.mesh.positions.len() as u32;
        self.parts.push(MeshPart { name: read.name, vertices: first..first + read.positions.len() as u32 });
        let total = self.mesh.positions.len() + read.positions.len();
        if u32::try_from(total).is_err() {
            return Err(Error::out_of_range(format!(
                "{name}: has {total} vertices in all; name one of its prims"
            )));
        }
        self.mesh.positions.extend(read.positions);
        let mut current = None;
        self.materials.choose(None);
        for (face, material) in read.faces.iter().zip(&read.material_of_face) {
            let corners: Vec<u32> = face.iter().map(|v| first + v).collect();
            self.mesh.faces.push(&corners);
            if *material != current {
                current = *material;
                self.materials.choose(material.map(|number| read.materials[number].clone()));
            }
            self.materials.fill(self.mesh.faces.len());
        }
        match read.uvs {
            None => self.uvs.push_none(read.faces.indices.len()),
            Some(uvs) => {
                let (first, count) = (self.uvs.values.len() as u32, uvs.values.len() as u32);
                self.uvs.values.extend(uvs.values);
                for entry in uvs.corners {
                    self.uvs.push(if entry < count { first + entry } else { uvs::MISSING });
                }
            }
        }
        for shape in read.shapes {
            let number = *self.numbers.entry(shape.name.clone()).or_insert_with(|| {
                self.shapes.push(Shape { name: shape.name.clone(), moved: Vec::new() });
                self.shapes.len() - 1
            });
            self.moved += shape.moved.len() as u64;
            // A real file stores each displacement, if not as compressed as this.
            if self.moved > MOST_MOVED * (size + (1 << 16)) {
                return Err(Error::unsupported_format(format!(
                    "{name}: its shapes repeat the same data: {} displacements from {size} bytes; export it without \
                     copies",
                    self.moved
                )));
            }
            self.shapes[number].moved.extend(shape.moved.into_iter().map(|(v, by)| (first + v, by)));
        }
        Ok(())
    }

    fn finish(mut self, space: Space, name: &str) -> Shapes {
        self.uvs.finish(&mut self.mesh, name);
        self.mesh.materials = self.materials.finish();
        Shapes { neutral: self.mesh, shapes: self.shapes, parts: self.parts, space }
    }
}
