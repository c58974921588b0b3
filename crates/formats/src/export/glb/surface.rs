//! The mesh as glTF wants it: triangles, and one texture coordinate per vertex.
use super::super::Scene;
use rhytid_core::Uvs;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// W ≥ V vertices: the input's V in their order, then copies of those whose corners have several texture
/// coordinates.
pub(super) struct Surface {
    /// W×3 rest positions.
    pub positions: Vec<[f32; 3]>,
    /// W×3 rest normals, all of length 1.
    pub normals: Vec<[f32; 3]>,
    /// W×2 texture coordinates, with (0, 0) at the upper left.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// T×3.
    pub indices: Vec<u32>,
    /// For each of the W − V copies, the vertex that it copies.
    originals: Vec<u32>,
}

impl Surface {
    /// `scene` has been checked.
    pub fn new(scene: &Scene<'_>) -> Self {
        let corners = scene.triangle_corners.as_flattened();
        let vertex_at = |&corner: &u32| scene.faces.indices[corner as usize];
        let mut surface = Self {
            positions: scene.rest.to_vec(),
            normals: scene.rest_normals.iter().copied().map(unit_normal).collect(),
            uvs: None,
            indices: corners.iter().map(vertex_at).collect(),
            originals: Vec::new(),
        };
        match scene.uvs {
            Some(Uvs { values, corners: None }) => surface.uvs = Some(values.iter().map(flipped).collect()),
            Some(Uvs { values, corners: Some(uv_at) }) => surface.split(scene, values, uv_at),
            None => {}
        }
        surface
    }

    /// Copies vertices until each has one texture coordinate.
    fn split(&mut self, scene: &Scene<'_>, values: &[[f32; 2]], uv_at: &[u32]) {
        let vertices = scene.rest.len();
        let mut first: Vec<Option<[f32; 2]>> = vec![None; vertices];
        // A vertex and the bits of a texture coordinate other than its first; the copy that has it.
        let mut copies: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
        let mut copied_uvs = Vec::new();
        for (index, &corner) in self.indices.iter_mut().zip(scene.triangle_corners.as_flattened()) {
            let vertex = *index;
            let uv = flipped(&values[uv_at[corner as usize] as usize]);
            if *first[vertex as usize].get_or_insert(uv) == uv {
                continue;
            }
            *index = match copies.entry((vertex, uv.map(f32::to_bits))) {
                Entry::Occupied(copy) => *copy.get(),
                Entry::Vacant(entry) => {
                    let copy = (vertices + self.originals.len()) as u32;
                    self.originals.push(vertex);
                    copied_uvs.push(uv);
                    *entry.insert(copy)
                }
            };
        }
        // A vertex of no triangle has no texture coordinate.
        let uvs = first.into_iter().map(Option::unwrap_or_default).chain(copied_uvs);
        self.uvs = Some(uvs.collect());
        self.positions.extend(self.originals.iter().map(|&v| scene.rest[v as usize]));
        self.normals.extend(self.originals.iter().map(|&v| unit_normal(scene.rest_normals[v as usize])));
    }

    /// Fills `out` with W offsets of V×3 `positions` from the rest positions.
    pub fn position_offsets(&self, positions: &[f32], out: &mut Vec<[f32; 3]>) {
        out.clear();
        out.extend(self.vectors(positions).zip(&self.positions).map(|(p, rest)| difference(p, *rest)));
    }

    /// Fills `out` with W offsets of V×3 `normals` from the rest normals. Where a frame has no normal, the
    /// rest normal stays: viewers normalise the sum, and 0 has no direction.
    pub fn normal_offsets(&self, normals: &[f32], out: &mut Vec<[f32; 3]>) {
        out.clear();
        out.extend(
            self.vectors(normals)
                .zip(&self.normals)
                .map(|(n, rest)| if n == [0.0; 3] { [0.0; 3] } else { difference(n, *rest) }),
        );
    }

    /// The V vectors in `numbers`, then those of the copies.
    fn vectors(&self, numbers: &[f32]) -> impl Iterator<Item = [f32; 3]> {
        let (vectors, _) = numbers.as_chunks::<3>();
        vectors.iter().copied().chain(self.originals.iter().map(|&v| vectors[v as usize]))
    }
}

fn difference(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

/// glTF demands a direction even where there is none.
fn unit_normal(normal: [f32; 3]) -> [f32; 3] {
    if normal == [0.0; 3] { [0.0, 0.0, 1.0] } else { normal }
}

/// v counts from the top in glTF and from the bottom in [`Uvs`].
fn flipped(&[u, v]: &[f32; 2]) -> [f32; 2] {
    [u, 1.0 - v]
}
