//! The mesh as glTF wants it: triangles, and one texture coordinate per vertex.

use rhytid_core::{Faces, Uvs};
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
    /// T×3 corners.
    pub indices: Vec<u32>,
}

impl Surface {
    /// `vertices` is V. `triangle_corners` index the corners of `faces`, and everything has been checked.
    pub(crate) fn new(
        vertices: usize,
        faces: &Faces,
        triangle_corners: &[[u32; 3]],
        uvs: Option<&Uvs>,
    ) -> Self {
        let corners = triangle_corners.as_flattened();
        let vertex_at = |&corner: &u32| faces.indices[corner as usize];
        let mut surface = Self {
            originals: vertices,
            copied: Vec::new(),
            uvs: None,
            indices: corners.iter().map(vertex_at).collect(),
        };
        match uvs {
            Some(Uvs { values, corners: None }) => surface.uvs = Some(values.iter().map(flipped).collect()),
            Some(Uvs { values, corners: Some(uv_at) }) => surface.split(corners, values, uv_at),
            None => {}
        }
        surface
    }

    /// Copies vertices until each has one texture coordinate.
    fn split(&mut self, corners: &[u32], values: &[[f32; 2]], uv_at: &[u32]) {
        let mut first: Vec<Option<[f32; 2]>> = vec![None; self.originals];
        // The copy of a vertex for the bits of a texture coordinate other than its first.
        let mut copies: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
        let mut copied_uvs = Vec::new();
        for (index, &corner) in self.indices.iter_mut().zip(corners) {
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

/// v counts from the top in glTF and from the bottom in [`Uvs`].
fn flipped(&[u, v]: &[f32; 2]) -> [f32; 2] {
    [u, 1.0 - v]
}
