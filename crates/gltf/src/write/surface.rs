//! The mesh as glTF wants it: triangles, and one texture coordinate per vertex.

use rhytid_core::{Materials, Uvs};
use rhytid_export::Scene;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// W ≥ V vertices: the input's V in their order, then copies. A vertex is copied if its corners have several
/// texture coordinates.
pub(crate) struct Surface {
    /// V.
    originals: usize,
    /// For each of the W − V copies, the vertex that it copies.
    copied: Vec<u32>,
    /// W×2 texture coordinates, with (0, 0) at the upper left.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// The triangles by their material: at least one part, each with at least one triangle.
    pub parts: Vec<Part>,
}

/// The triangles of one primitive.
pub(crate) struct Part {
    /// Their material in the scene's list; `None` for faces without one, and if the parts are not kept apart.
    pub material: Option<usize>,
    /// T×3 corners, in the order of the input's triangles.
    pub indices: Vec<u32>,
}

impl Surface {
    /// The mesh of a scene that has been checked. Its materials are parts, or all triangles are one part
    /// (`one_material`).
    pub(crate) fn new(scene: &Scene<'_>, one_material: bool) -> Self {
        let corners = scene.triangle_corners.as_flattened();
        let mut indices: Vec<u32> =
            corners.iter().map(|&corner| scene.faces.indices[corner as usize]).collect();
        let mut surface =
            Self { originals: scene.rest.len(), copied: Vec::new(), uvs: None, parts: Vec::new() };
        match scene.uvs {
            Some(Uvs { values, corners: None }) => surface.uvs = Some(values.iter().map(flipped).collect()),
            Some(Uvs { values, corners: Some(uv_at) }) => {
                surface.split(&mut indices, corners, values, uv_at);
            }
            None => {}
        }
        surface.parts = match scene.materials.filter(|_| !one_material) {
            Some(materials) => parts(scene, materials, &indices),
            // A single material of the input stays, although its triangles are not told from others.
            None => {
                let is_only = scene.materials.is_some_and(|materials| materials.list.len() == 1);
                vec![Part { material: is_only.then_some(0), indices }]
            }
        };
        surface
    }

    /// W, with the copies.
    pub(crate) fn vertices(&self) -> usize {
        self.originals + self.copied.len()
    }

    /// V, without the copies.
    pub(crate) fn originals(&self) -> usize {
        self.originals
    }

    /// For each copy the vertex that it copies.
    pub(crate) fn copied(&self) -> &[u32] {
        &self.copied
    }

    /// Copies vertices until each has one texture coordinate, and lets `indices` name the copies.
    fn split(&mut self, indices: &mut [u32], corners: &[u32], values: &[[f32; 2]], uv_at: &[u32]) {
        let mut first: Vec<Option<[f32; 2]>> = vec![None; self.originals];
        // The copy of a vertex for the bits of a texture coordinate other than its first.
        let mut copies: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
        let mut copied_uvs = Vec::new();
        for (index, &corner) in indices.iter_mut().zip(corners) {
            let vertex = *index;
            let uv = flipped(&values[uv_at[corner as usize] as usize]);
            if *first[vertex as usize].get_or_insert(uv) == uv {
                continue;
            }
            *index = match copies.entry((vertex, uv.map(f32::to_bits))) {
                Entry::Occupied(copy) => *copy.get(),
                Entry::Vacant(entry) => {
                    let copy = (self.originals + self.copied.len()) as u32;
                    self.copied.push(vertex);
                    copied_uvs.push(uv);
                    *entry.insert(copy)
                }
            };
        }
        // A vertex of no triangle has no texture coordinate.
        let uvs = first.into_iter().map(Option::unwrap_or_default).chain(copied_uvs);
        self.uvs = Some(uvs.collect());
    }

    /// The values of the W vertices from the values `of_originals` of the V originals.
    pub(super) fn spread<T: Copy>(&self, of_originals: &[T]) -> impl Iterator<Item = T> {
        of_originals.iter().copied().chain(self.copied.iter().map(|&v| of_originals[v as usize]))
    }

    /// For each of the W vertices the original that it is or copies.
    pub(crate) fn ids(&self) -> impl Iterator<Item = u32> {
        (0..self.originals as u32).chain(self.copied.iter().copied())
    }
}

/// The triangles of each material, in the order of the materials, then those without one. `indices` are the
/// vertices of the scene's triangles.
fn parts(scene: &Scene<'_>, materials: &Materials, indices: &[u32]) -> Vec<Part> {
    let mut material_of_corner = Vec::with_capacity(scene.faces.indices.len());
    for (&corners, &material) in scene.faces.counts.iter().zip(&materials.of_face) {
        material_of_corner.resize(material_of_corner.len() + corners as usize, material);
    }
    let mut parts: Vec<Part> = (0..materials.list.len())
        .map(|material| Part { material: Some(material), indices: Vec::new() })
        .collect();
    let mut without = Part { material: None, indices: Vec::new() };
    for (corners, vertices) in scene.triangle_corners.iter().zip(indices.as_chunks::<3>().0) {
        let material = material_of_corner[corners[0] as usize];
        let part = if material == Materials::NONE { &mut without } else { &mut parts[material as usize] };
        part.indices.extend_from_slice(vertices);
    }
    parts.push(without);
    parts.retain(|part| !part.indices.is_empty());
    parts
}

/// v counts from the top in glTF and from the bottom in [`Uvs`].
fn flipped(&[u, v]: &[f32; 2]) -> [f32; 2] {
    [u, 1.0 - v]
}
