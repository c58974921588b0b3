//! The meshes of a glTF scene, each where its node has it.

use super::super::materials::Assigned;
use super::super::shapes::{Shapes, Space};
use super::super::uvs::CornerUvs;
use super::accessor::Accessors;
use super::buffers::Buffers;
use super::targets::{self, Targets};
use ::gltf::json::Root;
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::scene::Node;
use ::gltf::json::validation::Checked;
use glam::{DMat4, DVec3};
use rhytid_core::{Error, Mesh, Result, UpAxis};
use rhytid_gltf::local_transform;
use std::collections::HashMap;

/// The triangles of every mesh in the default scene, in the order of its nodes, parents first. With their
/// morph targets if `with_shapes`.
pub(super) fn read(root: &Root, buffers: &Buffers, name: &str, with_shapes: bool) -> Result<Shapes> {
    let mut reader = Reader {
        accessors: Accessors { root, buffers, name },
        mesh: Mesh::default(),
        uvs: CornerUvs::default(),
        corners_read: 0,
        materials: Assigned::default(),
        skipped: 0,
        targets: with_shapes.then(Targets::default),
    };
    for (node, transform) in placed_nodes(root, name)? {
        reader.node(node, transform)?;
    }
    reader.finish()
}

/// The nodes of the default scene (else of the first) with their transforms to scene space.
fn placed_nodes<'a>(root: &'a Root, name: &str) -> Result<Vec<(&'a Node, DMat4)>> {
    let fail = |what: String| Err(Error::malformed(format!("{name}: {what}")));
    let scene = root.scene.map_or(0, |scene| scene.value());
    let Some(scene) = root.scenes.get(scene) else {
        return fail(format!(
            "has {} scenes, expected a default one with number {scene}; export the mesh again",
            root.scenes.len()
        ));
    };
    let mut placed = Vec::new();
    let mut visited = vec![false; root.nodes.len()];
    // A stack, not recursion: a chain of nodes can be longer than the call stack.
    let mut next: Vec<_> = scene.nodes.iter().rev().map(|&node| (node, DMat4::IDENTITY)).collect();
    while let Some((index, parent)) = next.pop() {
        let index = index.value();
        let (Some(node), Some(visited)) = (root.nodes.get(index), visited.get_mut(index)) else {
            return fail(format!("node {index} does not exist, expected one of the {}", root.nodes.len()));
        };
        if std::mem::replace(visited, true) {
            return fail(format!("node {index} is placed twice, expected a tree of nodes"));
        }
        let transform = parent * local_transform(node);
        next.extend(node.children.iter().flatten().rev().map(|&child| (child, transform)));
        placed.push((node, transform));
    }
    Ok(placed)
}

struct Reader<'a> {
    accessors: Accessors<'a>,
    mesh: Mesh,
    uvs: CornerUvs,
    /// Corners of all primitives so far.
    corners_read: usize,
    materials: Assigned,
    /// Primitives of points or lines.
    skipped: usize,
    /// `None` if they are not wanted.
    targets: Option<Targets>,
}

/// Where the data of a node's accessors begins in the mesh: several primitives (one per material) often share
/// their vertices.
#[derive(Default)]
struct Begin {
    vertices: HashMap<usize, u32>,
    uvs: HashMap<(usize, usize), u32>,
}

impl Reader<'_> {
    fn node(&mut self, node: &Node, transform: DMat4) -> Result<()> {
        let Some(index) = node.mesh.map(|mesh| mesh.value()) else { return Ok(()) };
        let Some(mesh) = self.accessors.root.meshes.get(index) else {
            return self.fail(format!("mesh {index} does not exist; the file is damaged"));
        };
        // A skin places its mesh by joints alone. The stored mesh is the one that was bound to them.
        let transform = if node.skin.is_some() { DMat4::IDENTITY } else { transform };
        let mut begin = Begin::default();
        let names = if self.targets.is_some() { targets::names(mesh) } else { Vec::new() };
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            self.primitive(
                primitive,
                &names,
                transform,
                &mut begin,
                &format!("mesh {index}, primitive {p}"),
            )?;
        }
        Ok(())
    }

    fn primitive(
        &mut self,
        primitive: &Primitive,
        names: &[String],
        transform: DMat4,
        begin: &mut Begin,
        place: &str,
    ) -> Result<()> {
        let Checked::Valid(mode) = primitive.mode else {
            return self.unsupported(format!(
                "{place} has an unknown mode, expected triangles; export the mesh again"
            ));
        };
        if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
            self.skipped += 1;
            return Ok(());
        }
        let attribute =
            |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(::gltf::json::Index::value);
        let Some(position) = attribute(Semantic::Positions) else {
            return self.fail(format!("{place} has no POSITION, expected vertices; export the mesh again"));
        };
        if !self.accessors.is_stored(position)? {
            let used = &self.accessors.root.extensions_used;
            let by = used.iter().find(|e| e.contains("compression")).map_or("an extension", String::as_str);
            return self.unsupported(format!(
                "{place} is compressed with {by}, which is not supported; export it without compression"
            ));
        }
        let is_new = !begin.vertices.contains_key(&position);
        let first_vertex = self.vertices(position, transform, begin)?;
        let count = self.accessors.count(position)?;
        if let Some(targets) = self.targets.as_mut().filter(|_| is_new) {
            targets.add(&self.accessors, primitive, names, first_vertex, count, transform)?;
        }

        let indices = match primitive.indices {
            Some(indices) => self.accessors.indices(indices.value())?,
            // `count` vertices were read, so that it fits.
            None => (0..count as u32).collect(),
        };
        if let Some(index) = indices.iter().find(|&&i| u64::from(i) >= count) {
            return self.fail(format!(
                "{place} has the vertex index {index}, expected 0 to {}; the file may be damaged",
                count.saturating_sub(1)
            ));
        }
        if mode == Mode::Triangles && indices.len() % 3 != 0 {
            return self.fail(format!(
                "{place} has {} corners of triangles, expected a multiple of 3; the file may be damaged",
                indices.len()
            ));
        }
        // Also where nothing comes of them: many primitives may name the same.
        self.corners_read += indices.len();
        let mut corners = triangle_corners(mode, &indices);
        if transform.determinant() < 0.0 {
            // A mirror turns triangles inside out, which glTF takes back.
            corners.chunks_exact_mut(3).for_each(|corner| corner.swap(1, 2));
        }
        self.within_reason(
            self.mesh.positions.len(),
            self.corners_read.max(self.mesh.faces.indices.len() + corners.len()),
        )?;

        match attribute(Semantic::TexCoords(0)) {
            None => self.uvs.push_none(corners.len()),
            Some(uv) => {
                let first_uv = self.uvs(position, uv, count, begin, place)?;
                corners.iter().for_each(|&c| self.uvs.push(first_uv + c));
            }
        }
        for corner in corners.chunks_exact(3) {
            self.mesh.faces.push(&[
                first_vertex + corner[0],
                first_vertex + corner[1],
                first_vertex + corner[2],
            ]);
        }
        let named = |material: ::gltf::json::Index<_>| self.accessors.root.materials.get(material.value());
        self.materials.choose(primitive.material.and_then(named).and_then(|material| material.name.clone()));
        self.materials.fill(self.mesh.faces.len());
        Ok(())
    }

    /// The index of the accessor's first vertex in the mesh; reads them if this node did not yet.
    fn vertices(&mut self, position: usize, transform: DMat4, begin: &mut Begin) -> Result<u32> {
        if let Some(&first) = begin.vertices.get(&position) {
            return Ok(first);
        }
        let positions = self.accessors.vectors::<3>(position)?;
        let total = self.mesh.positions.len() + positions.len();
        self.within_reason(total, self.mesh.faces.indices.len())?;
        let first = self.mesh.positions.len() as u32;
        self.mesh.positions.extend(
            positions.into_iter().map(|p| transform.transform_point3(DVec3::from_array(p)).to_array()),
        );
        begin.vertices.insert(position, first);
        Ok(first)
    }

    /// The same for texture coordinates. glTF's origin is the upper left, Rhytid's the lower left.
    fn uvs(&mut self, position: usize, uv: usize, count: u64, begin: &mut Begin, place: &str) -> Result<u32> {
        if let Some(&first) = begin.uvs.get(&(position, uv)) {
            return Ok(first);
        }
        if self.accessors.count(uv)? != count {
            return self.fail(format!(
                "{place} has {} texture coordinates for {count} vertices, expected one for each; export the mesh \
                 again",
                self.accessors.count(uv)?
            ));
        }
        let uvs = self.accessors.vectors::<2>(uv)?;
        self.within_reason(self.uvs.values.len() + uvs.len(), 0)?;
        let first = self.uvs.values.len() as u32;
        self.uvs.values.extend(uvs.into_iter().map(|[u, v]| [u as f32, (1.0 - v) as f32]));
        begin.uvs.insert((position, uv), first);
        Ok(first)
    }

    /// A few bytes can place a mesh a million times, or let a million accessors share the same bytes. A real
    /// face has fewer vertices than its file has bytes, and about six corners for each vertex.
    fn within_reason(&self, vertices: usize, corners: usize) -> Result<()> {
        let bytes = self.accessors.buffers.total;
        let limit = bytes.saturating_add(1 << 16).min(u64::from(u32::MAX));
        if vertices as u64 > limit || corners as u64 / 6 > limit {
            return self.unsupported(format!(
                "its nodes repeat the same data: {vertices} vertices and {corners} corners from {bytes} \
                 bytes of data, expected one face; export it without copies"
            ));
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Shapes> {
        let name = self.accessors.name;
        if self.skipped > 0 {
            log::warn!("{name}: {} primitives of points or lines were skipped", self.skipped);
        }
        self.uvs.finish(&mut self.mesh, name);
        self.mesh.materials = self.materials.finish();
        let shapes = self.targets.map(Targets::finish).unwrap_or_default();
        let space = Space { metres_per_unit: Some(1.0), up: Some(UpAxis::Y) };
        Ok(Shapes { neutral: self.mesh, shapes, space })
    }

    fn unsupported<T>(&self, what: String) -> Result<T> {
        Err(Error::unsupported_format(format!("{}: {what}", self.accessors.name)))
    }

    fn fail<T>(&self, what: String) -> Result<T> {
        Err(Error::malformed(format!("{}: {what}", self.accessors.name)))
    }
}

/// Three corners for each triangle.
fn triangle_corners(mode: Mode, indices: &[u32]) -> Vec<u32> {
    let triples = indices.windows(3).enumerate();
    match mode {
        // Every other triangle of a strip is stored the wrong way round. Those without area turn the strip's
        // corners and are no part of the surface.
        Mode::TriangleStrip => triples
            .map(|(i, t)| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] })
            .filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
            .flatten()
            .collect(),
        Mode::TriangleFan => indices
            .first()
            .into_iter()
            .flat_map(|&hub| indices[1..].windows(2).flat_map(move |rim| [hub, rim[0], rim[1]]))
            .collect(),
        _ => indices.to_vec(),
    }
}
