//! The meshes of a glTF scene, each where its node has it.

use super::super::materials::Assigned;
use super::super::shapes::{MeshPart, Shapes, Space};
use super::super::uvs::CornerUvs;
use super::accessor::Accessors;
use super::buffers::Buffers;
use super::looks::material_name;
use super::material_uvs::{MaterialUvs, UvTransform};
use super::nodes::{Nodes, Placed};
use super::skin::{Placement, Set, Skin, sets};
use super::targets::{self, Shown, Targets};
use ::gltf::json::Root;
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use glam::DVec3;
use rhytid_core::{Error, Mesh, Result, UpAxis};
use std::collections::HashMap;
use std::rc::Rc;

/// The triangles of every mesh in the default scene, in the order of its nodes, parents first. With their
/// morph targets if `with_shapes`.
pub(super) fn read(root: &Root, buffers: &Buffers, name: &str, with_shapes: bool) -> Result<Shapes> {
    let nodes = Nodes::read(root, name)?;
    let mut reader = Reader {
        accessors: Accessors { root, buffers, name },
        nodes: &nodes,
        skins: HashMap::new(),
        names: HashMap::new(),
        shown: Shown::default(),
        parts: Vec::new(),
        mesh: Mesh::default(),
        uvs: CornerUvs::default(),
        corners_read: 0,
        materials: Assigned::default(),
        skipped: 0,
        has_integer_uvs: false,
        targets: with_shapes.then(Targets::default),
    };
    for placed in &nodes.placed {
        reader.node(placed)?;
    }
    reader.finish()
}

struct Reader<'a> {
    accessors: Accessors<'a>,
    nodes: &'a Nodes<'a>,
    skins: HashMap<usize, Rc<Skin>>,
    /// The names of the targets of meshes.
    names: HashMap<usize, Rc<Vec<String>>>,
    shown: Shown,
    parts: Vec<MeshPart>,
    mesh: Mesh,
    uvs: CornerUvs,
    /// Corners of all primitives so far.
    corners_read: usize,
    materials: Assigned,
    /// Primitives of points or lines.
    skipped: usize,
    /// Whether texture coordinates are integers, and no material says what they stand for.
    has_integer_uvs: bool,
    /// `None` if they are not wanted.
    targets: Option<Targets>,
}

/// The vertices of a node that were read: several primitives (one per material) often share their vertices.
#[derive(Default)]
struct Begin {
    vertices: HashMap<VertexKey, Rc<Vertices>>,
    uvs: HashMap<UvKey, u32>,
}

/// Primitives share vertices that are in the same place and move in the same way.
#[derive(PartialEq, Eq, Hash)]
struct VertexKey {
    position: usize,
    sets: Vec<Set>,
    targets: Vec<Option<usize>>,
}

/// Vertices in the mesh.
struct Vertices {
    /// The index of the first.
    first: u32,
    count: u64,
    placement: Placement,
}

#[derive(PartialEq, Eq, Hash)]
struct UvKey {
    position: usize,
    uv: usize,
    transform: Option<[u64; 5]>,
}

/// Where a primitive is, and what places it.
struct Place<'a> {
    /// For messages.
    name: String,
    node: &'a Placed<'a>,
    skin: Option<Rc<Skin>>,
    /// The names of its mesh's targets.
    targets: Rc<Vec<String>>,
}

impl Reader<'_> {
    fn node(&mut self, placed: &Placed<'_>) -> Result<()> {
        let node = placed.node;
        let Some(index) = node.mesh.map(|mesh| mesh.value()) else { return Ok(()) };
        let Some(mesh) = self.accessors.root.meshes.get(index) else {
            return self.fail(format!("mesh {index} does not exist; the file is damaged"));
        };
        if node.extensions.as_ref().is_some_and(|e| e.others.contains_key("EXT_mesh_gpu_instancing")) {
            return self.unsupported(format!(
                "node {} places copies of a mesh (EXT_mesh_gpu_instancing), which is not supported; export it \
                 without instancing",
                placed.index
            ));
        }
        let skin = match node.skin {
            Some(skin) => Some(self.skin(skin.value())?),
            None => None,
        };
        let names = self.names.entry(index).or_insert_with(|| Rc::new(targets::names(mesh)));
        self.shown.add(node, mesh, names);
        let mut place = Place { name: String::new(), node: placed, skin, targets: Rc::clone(names) };
        let mut begin = Begin::default();
        let first = self.mesh.positions.len() as u32;
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            place.name = format!("mesh {index}, primitive {p}");
            self.primitive(primitive, &place, &mut begin)?;
        }
        if let Some(name) = node.name.as_ref().or(mesh.name.as_ref()) {
            let vertices = first..self.mesh.positions.len() as u32;
            self.parts.push(MeshPart { name: name.clone(), vertices });
        }
        Ok(())
    }

    fn skin(&mut self, index: usize) -> Result<Rc<Skin>> {
        if let Some(skin) = self.skins.get(&index) {
            return Ok(Rc::clone(skin));
        }
        let skin = Rc::new(Skin::read(&self.accessors, self.nodes, index)?);
        self.skins.insert(index, Rc::clone(&skin));
        Ok(skin)
    }

    fn primitive(&mut self, primitive: &Primitive, placed: &Place<'_>, begin: &mut Begin) -> Result<()> {
        let place = &placed.name;
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
        let vertices = self.vertices(primitive, position, placed, begin)?;
        let (first_vertex, count) = (vertices.first, vertices.count);

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
        for corner in corners.chunks_exact_mut(3) {
            // A mirror turns triangles inside out, which glTF takes back.
            if vertices.placement.is_mirror(corner[0] as usize) {
                corner.swap(1, 2);
            }
        }
        self.within_reason(
            self.mesh.positions.len(),
            self.corners_read.max(self.mesh.faces.indices.len() + corners.len()),
        )?;

        let material = primitive.material.map(|material| material.value());
        let used = MaterialUvs::of(self.accessors.root, material, self.accessors.name)?;
        match attribute(Semantic::TexCoords(used.set)) {
            None => self.uvs.push_none(corners.len()),
            Some(uv) => {
                let first_uv = self.uvs(position, uv, count, used.transform, begin, place)?;
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
        self.materials.choose(material.and_then(|material| material_name(self.accessors.root, material)));
        self.materials.fill(self.mesh.faces.len());
        Ok(())
    }

    /// The vertices of a primitive, with their targets; reads them if this node did not yet.
    fn vertices(
        &mut self,
        primitive: &Primitive,
        position: usize,
        placed: &Place<'_>,
        begin: &mut Begin,
    ) -> Result<Rc<Vertices>> {
        let sets = match placed.skin {
            Some(_) => sets(primitive, &placed.name, self.accessors.name)?,
            None => Vec::new(),
        };
        let targets = primitive.targets.iter().flatten();
        let targets = targets.map(|target| target.positions.map(|index| index.value())).collect();
        let key = VertexKey { position, sets, targets };
        if let Some(found) = begin.vertices.get(&key) {
            return Ok(Rc::clone(found));
        }
        let positions = self.accessors.vectors::<3>(position)?;
        let count = positions.len();
        self.within_reason(self.mesh.positions.len() + count, self.mesh.faces.indices.len())?;
        // A skin alone places a mesh: the transform of the mesh's node does nothing.
        let placement = match &placed.skin {
            Some(skin) => skin.place(&self.accessors, &key.sets, count, &placed.name)?,
            None => Placement::Node(placed.node.transform),
        };
        let first = self.mesh.positions.len() as u32;
        for (v, p) in positions.into_iter().enumerate() {
            self.mesh.positions.push(placement.of(v).transform_point3(DVec3::from_array(p)).to_array());
        }
        let count = count as u64;
        if let Some(targets) = &mut self.targets {
            targets.add(&self.accessors, primitive, &placed.targets, first, count, &placement)?;
        }
        let vertices = Rc::new(Vertices { first, count, placement });
        begin.vertices.insert(key, Rc::clone(&vertices));
        Ok(vertices)
    }

    /// The index of the accessor's first texture coordinate; reads them if this node did not yet. glTF's
    /// origin is the upper left, Rhytid's the lower left.
    fn uvs(
        &mut self,
        position: usize,
        uv: usize,
        count: u64,
        transform: Option<UvTransform>,
        begin: &mut Begin,
        place: &str,
    ) -> Result<u32> {
        let key = UvKey { position, uv, transform: transform.map(|transform| transform.key()) };
        if let Some(&first) = begin.uvs.get(&key) {
            return Ok(first);
        }
        if self.accessors.count(uv)? != count {
            return self.fail(format!(
                "{place} has {} texture coordinates for {count} vertices, expected one for each; export the mesh \
                 again",
                self.accessors.count(uv)?
            ));
        }
        let mut uvs = self.accessors.vectors::<2>(uv)?;
        self.within_reason(self.uvs.values.len() + uvs.len(), 0)?;
        match transform {
            Some(transform) => uvs.iter_mut().for_each(|uv| *uv = transform.apply(*uv)),
            None => self.has_integer_uvs |= self.accessors.is_integers(uv)?,
        }
        let first = self.uvs.values.len() as u32;
        self.uvs.values.extend(uvs.into_iter().map(|[u, v]| [u as f32, (1.0 - v) as f32]));
        begin.uvs.insert(key, first);
        Ok(first)
    }

    /// A few bytes can place a mesh a million times, or let a million accessors share the same bytes. A real
    /// face has fewer vertices than its file has bytes, and about six corners for each vertex.
    fn within_reason(&self, vertices: usize, corners: usize) -> Result<()> {
        let bytes = self.accessors.buffers.total();
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
        if self.has_integer_uvs {
            log::warn!(
                "{name}: has texture coordinates that are integers, and no texture that says what they stand for \
                 (KHR_texture_transform); export it with its textures, or with texture coordinates as floats"
            );
        }
        self.shown.warn(name);
        self.uvs.finish(&mut self.mesh, name);
        self.mesh.materials = self.materials.finish();
        let shapes = self.targets.map(Targets::finish).unwrap_or_default();
        let space = Space { metres_per_unit: Some(1.0), up: Some(UpAxis::Y) };
        Ok(Shapes { neutral: self.mesh, shapes, parts: self.parts, space })
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
