//! Whole shapes of a rig's mesh from a file: what a take is fitted to.

use crate::shape_space::{ShapeSpace, difference, rest};
use crate::{Playback, named_shapes};
use rayon::prelude::*;
use rhytid_core::{DeviceInfo, Error, Faces, Mesh, Progress, Reach, Result, Rig, rig_file};
use rhytid_formats::export::{Shape, ShapeSet};
use rhytid_formats::mesh::{self, Selection, Space};
use rhytid_formats::{FileKind, project};
use rhytid_kernels::normals::vertex_normal;
use std::collections::HashSet;
use std::path::Path;

/// Reads shapes of the mesh of `rig`, in its unit, its axes and its order of vertices. These are the blend
/// shapes of a glTF or USD file, or the examples of a project file or of a rig. They can also be all meshes
/// of a folder, or those whose names fit a pattern. With `with_normals`, the shapes have normals, computed
/// from their triangles. A rig's examples are evaluated on the first of `devices` that has room for it.
///
/// # Errors
/// [`Error::Input`] if there are no shapes, or if they are of a mesh with other vertices. [`Error::Io`];
/// [`Error::Device`]; [`Error::Cancelled`].
pub fn read_shape_set(
    path: &Path,
    rig: &Rig,
    with_normals: bool,
    devices: &[DeviceInfo],
    progress: &dyn Progress,
) -> Result<ShapeSet> {
    let name = path.display().to_string();
    let mut set = match FileKind::detect(path) {
        Some(FileKind::Rig) => of_rig(path, rig, devices, progress)?,
        Some(FileKind::Project) => of_project(path, rig)?,
        _ if mesh::has_shapes(path) && (path.is_file() || !name.contains(['*', '#'])) => of_file(path, rig)?,
        _ => of_meshes(path, rig)?,
    };
    if set.shapes.is_empty() {
        return Err(Error::empty(format!(
            "{name}: has no shapes, expected a file with blend shapes, a folder of meshes, or a project file or rig \
             with examples"
        )));
    }
    if with_normals {
        add_normals(&mut set, rig);
    }
    Ok(set)
}

fn of_rig(path: &Path, rig: &Rig, devices: &[DeviceInfo], progress: &dyn Progress) -> Result<ShapeSet> {
    let other = rig_file::read(path)?;
    if other.surface().faces != rig.surface().faces || other.vertices() != rig.vertices() {
        return Err(other_vertices(path, other.vertices(), rig));
    }
    let mut playback = Playback::new(&other, devices, other.examples().len())?;
    let shapes = playback.example_shapes(None, progress)?;
    Ok(ShapeSet { base: other.surface().rest.clone(), base_normals: None, shapes })
}

fn of_project(path: &Path, rig: &Rig) -> Result<ShapeSet> {
    let project = project::read_project(path)?;
    // The user names this file, as a mesh is named.
    let face = project::load_without_handles(&project, path, Reach::Anywhere)?;
    let space = Space { metres_per_unit: Some(face.metres_per_unit), up: Some(face.up_axis) };
    let place = Place::find(&face.neutral, space, rig, path)?;
    let examples = face.examples.into_iter();
    Ok(place.set(&face.neutral.positions, examples.map(|example| (example.name, example.positions))))
}

fn of_file(path: &Path, rig: &Rig) -> Result<ShapeSet> {
    let mesh::Shapes { neutral, shapes, space, .. } = mesh::read_file(path, &Selection::default(), true)?;
    let place = Place::find(&neutral, space, rig, path)?;
    let shapes = shapes.into_iter().map(|shape| {
        let positions = shape.on(&neutral.positions);
        (shape.name, positions)
    });
    Ok(place.set(&neutral.positions, shapes))
}

/// A mesh for each shape, each with the rig's vertices. The base is the rig's rest pose.
fn of_meshes(path: &Path, rig: &Rig) -> Result<ShapeSet> {
    let base = rest(rig);
    let mut set = ShapeSet { base: rig.surface().rest.clone(), ..ShapeSet::default() };
    for file in named_shapes::meshes(path) {
        let read = mesh::read_file(&file, &Selection::default(), false)?;
        let Place { space, order } = Place::find(&read.neutral, read.space, rig, &file)?;
        let positions = order.into_iter().map(|v| space.to_rig(read.neutral.positions[v]));
        let offsets = positions.zip(&base).map(|(x, base)| difference(x, *base).map(|x| x as f32)).collect();
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        set.shapes.push(Shape { name, offsets, normal_offsets: None });
    }
    Ok(set)
}

/// Where a mesh has the rig's vertices.
struct Place {
    space: ShapeSpace,
    /// For each of the rig's vertices, that of the mesh.
    order: Vec<usize>,
}

impl Place {
    /// # Errors
    /// [`Error::Input`] if the mesh has other vertices or another size.
    fn find(mesh: &Mesh, space: Space, rig: &Rig, path: &Path) -> Result<Self> {
        Ok(Self {
            space: ShapeSpace::by_size(&mesh.positions, space, rig, path)?,
            order: order(mesh, rig).ok_or_else(|| other_vertices(path, mesh.positions.len(), rig))?,
        })
    }

    /// The set of a base and its shapes, all as positions of the mesh's vertices.
    fn set(&self, base: &[[f64; 3]], shapes: impl Iterator<Item = (String, Vec<[f64; 3]>)>) -> ShapeSet {
        let narrow = |x: [f64; 3]| self.space.to_rig(x).map(|x| x as f32);
        let moved = |(name, positions): (String, Vec<[f64; 3]>)| {
            let offset = |v: &usize| narrow(difference(positions[*v], base[*v]));
            Shape { name, offsets: self.order.iter().map(offset).collect(), normal_offsets: None }
        };
        ShapeSet {
            base: self.order.iter().map(|&v| narrow(base[v])).collect(),
            base_normals: None,
            shapes: shapes.map(moved).collect(),
        }
    }
}

/// For each of the rig's vertices, that of the mesh; `None` if it is another mesh.
///
/// The vertices are in the rig's order. Behind them may be copies, as glTF has them where texture coordinates
/// differ. A file of another program may have split and cut the mesh in its own way, if its faces have the
/// rig's corners in their order.
fn order(mesh: &Mesh, rig: &Rig) -> Option<Vec<usize>> {
    let (vertices, surface) = (rig.vertices(), rig.surface());
    if mesh.positions.len() >= vertices && joins_as(mesh, rig) {
        return Some((0..vertices).collect());
    }
    let of_rig = |faces: Faces| Mesh { positions: rest(rig), faces, uvs: None, materials: None };
    let triangles = Faces {
        counts: vec![3; surface.triangles.len()],
        indices: surface.triangles.as_flattened().to_vec(),
    };
    let numbered: Vec<[f64; 3]> = (0..mesh.positions.len()).map(|v| [v as f64, 0.0, 0.0]).collect();
    let nowhere = vec![[-1.0, 0.0, 0.0]; vertices];
    [surface.faces.clone(), triangles].into_iter().find_map(|faces| {
        let order =
            mesh::order(mesh, &of_rig(faces), Path::new("the rig.glb"), Path::new("the shapes.glb")).ok()?;
        let order = order.of_neutral(numbered.clone(), &nowhere);
        order.into_iter().map(|[v, ..]| (v >= 0.0).then_some(v as usize)).collect()
    })
}

/// Whether the first V vertices of the mesh are joined to triangles as the rig's are. A copy of a vertex, in
/// the same place, counts as the vertex.
fn joins_as(mesh: &Mesh, rig: &Rig) -> bool {
    if mesh.positions.len() == rig.vertices() {
        return joins_polygons(mesh, rig);
    }
    let places = |corners: [u32; 3]| {
        let mut places = corners.map(|v| mesh.positions[v as usize].map(f64::to_bits));
        places.sort_unstable();
        places
    };
    let triangles = mesh.faces.iter().filter_map(|face| <[u32; 3]>::try_from(face).ok());
    let found: HashSet<[[u64; 3]; 3]> = triangles.map(places).collect();
    rig.surface().triangles.iter().all(|corners| found.contains(&places(*corners)))
}

/// The same where the mesh has as many vertices as the rig, and may have polygons.
fn joins_polygons(mesh: &Mesh, rig: &Rig) -> bool {
    let faces = rig.surface().faces.clone();
    let of_rig = Mesh { positions: mesh.positions.clone(), faces, uvs: None, materials: None };
    // Files that split no vertices: the vertices have to be the rig's.
    mesh::order(mesh, &of_rig, Path::new("the rig.obj"), Path::new("the shapes.obj")).is_ok()
}

fn other_vertices(path: &Path, found: usize, rig: &Rig) -> Error {
    let expected = rig.vertices();
    let what = if found == expected {
        format!("its {found} vertices are joined to other faces than the rig's")
    } else {
        format!("has {found} vertices, expected the {expected} of the rig's mesh in their order")
    };
    Error::mismatch(format!(
        "{}: {what}; give shapes of the mesh that the rig was solved from",
        path.display()
    ))
}

/// Adds the normals of the base and of each shape at 1, as devices compute them.
fn add_normals(set: &mut ShapeSet, rig: &Rig) {
    let at = rig.surface().vertex_triangles();
    let triangles = &rig.surface().triangles;
    let of = |positions: &[[f32; 3]]| -> Vec<[f32; 3]> {
        (0..positions.len()).into_par_iter().map(|v| vertex_normal(positions, triangles, at.at(v))).collect()
    };
    let of_base = of(&set.base);
    for shape in &mut set.shapes {
        let moved = |(base, offset): (&[f32; 3], &[f32; 3])| std::array::from_fn(|c| base[c] + offset[c]);
        let moved: Vec<[f32; 3]> = set.base.iter().zip(&shape.offsets).map(moved).collect();
        let between = |(to, from): (&[f32; 3], &[f32; 3])| std::array::from_fn(|c| to[c] - from[c]);
        shape.normal_offsets = Some(of(&moved).iter().zip(&of_base).map(between).collect());
    }
    set.base_normals = Some(of_base);
}
