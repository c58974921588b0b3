//! A rig's surface as a graphics card draws it: triangles, and one texture coordinate for each vertex.
use rhytid_core::{Materials, Result, Surface};
use std::collections::HashMap;

/// A surface of V vertices and C copies of them, drawn as triangles.
///
/// A graphics card has one texture coordinate for each vertex. So a vertex at a seam of the texture is drawn
/// as several: the copies, which stand behind the V vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// For each copy its vertex.
    pub copies: Vec<u32>,
    /// (V + C)×2 texture coordinates, (0, 0) at the lower left; `None` if the rig has none.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// The vertices and copies of each triangle, by material.
    pub triangles: Vec<[u32; 3]>,
    /// Triangles that have one material, one group after the other.
    pub groups: Vec<Group>,
}

/// Consecutive triangles of one material.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Group {
    /// The first triangle.
    pub first: usize,
    /// How many triangles follow.
    pub count: usize,
    /// The entry in [`Materials::list`]; `None` for faces without a material.
    pub material: Option<usize>,
}

impl Drawing {
    /// How a surface is drawn.
    ///
    /// # Errors
    /// As [`Surface::triangle_corners`].
    pub fn new(surface: &Surface) -> Result<Self> {
        let corners = surface.triangle_corners()?;
        let mut copies = Vec::new();
        let mut triangles = surface.triangles.clone();
        let uvs = surface.uvs.as_ref().map(|uvs| match &uvs.corners {
            None => uvs.values.clone(),
            Some(of_corners) => {
                let mut seams = Seams::new(surface.rest.len());
                for (triangle, corners) in triangles.iter_mut().zip(&corners) {
                    for (vertex, &corner) in triangle.iter_mut().zip(corners) {
                        *vertex = seams.drawn(*vertex, of_corners[corner as usize], &mut copies);
                    }
                }
                seams.coordinates(&uvs.values)
            }
        });
        let (triangles, groups) = by_material(surface, &corners, &triangles);
        Ok(Self { copies, uvs, triangles, groups })
    }

    /// Adds the numbers of the copies behind those of the V vertices, three for each.
    pub fn add_copies(&self, numbers: &mut Vec<f32>) {
        for &vertex in &self.copies {
            let first = 3 * vertex as usize;
            numbers.extend_from_within(first..first + 3);
        }
    }
}

/// The texture coordinates of vertices and copies, while triangles are gone through.
struct Seams {
    /// For each vertex and copy its texture coordinate. `None` for a vertex that no triangle has named.
    coordinates: Vec<Option<u32>>,
    /// The copy of a vertex with a further texture coordinate.
    copy_of: HashMap<(u32, u32), u32>,
}

impl Seams {
    fn new(vertices: usize) -> Self {
        Self { coordinates: vec![None; vertices], copy_of: HashMap::new() }
    }

    /// What is drawn for a vertex with this texture coordinate: the vertex or a copy of it.
    fn drawn(&mut self, vertex: u32, coordinate: u32, copies: &mut Vec<u32>) -> u32 {
        let own = self.coordinates[vertex as usize].get_or_insert(coordinate);
        if *own == coordinate {
            return vertex;
        }
        *self.copy_of.entry((vertex, coordinate)).or_insert_with(|| {
            copies.push(vertex);
            self.coordinates.push(Some(coordinate));
            self.coordinates.len() as u32 - 1
        })
    }

    fn coordinates(&self, values: &[[f32; 2]]) -> Vec<[f32; 2]> {
        let value = |coordinate: &Option<u32>| coordinate.map_or([0.0; 2], |i| values[i as usize]);
        self.coordinates.iter().map(value).collect()
    }
}

/// The triangles in the order of their materials, and the groups.
fn by_material(
    surface: &Surface,
    corners: &[[u32; 3]],
    triangles: &[[u32; 3]],
) -> (Vec<[u32; 3]>, Vec<Group>) {
    let Some(materials) = &surface.materials else {
        let all = Group { first: 0, count: triangles.len(), material: None };
        return (triangles.to_vec(), vec![all]);
    };
    let counts = surface.faces.counts.iter().zip(&materials.of_face);
    let of_corner: Vec<u32> =
        counts.flat_map(|(&count, &of_face)| std::iter::repeat_n(of_face, count as usize)).collect();
    let mut of_material: Vec<Vec<[u32; 3]>> = vec![Vec::new(); materials.list.len() + 1];
    for (triangle, corners) in triangles.iter().zip(corners) {
        let material = of_corner[corners[0] as usize];
        let place = if material == Materials::NONE { materials.list.len() } else { material as usize };
        of_material[place].push(*triangle);
    }
    let mut groups = Vec::new();
    let mut first = 0;
    for (material, triangles) in of_material.iter().enumerate().filter(|(_, all)| !all.is_empty()) {
        let material = (material < materials.list.len()).then_some(material);
        groups.push(Group { first, count: triangles.len(), material });
        first += triangles.len();
    }
    (of_material.concat(), groups)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::{Faces, Material, Uvs};

    /// Two quads side by side. Their common edge is a seam of the texture.
    fn surface() -> Surface {
        let triangle = rhytid_test_support::triangle();
        let mut faces = Faces::default();
        faces.push(&[0, 1, 4, 3]);
        faces.push(&[1, 2, 5, 4]);
        Surface {
            faces,
            triangles: vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]],
            rest: (0..7).map(|v| [v as f32, 0.0, 0.0]).collect(),
            uvs: Some(Uvs {
                values: (0..8).map(|i| [i as f32, 0.5]).collect(),
                corners: Some(vec![0, 1, 2, 3, 4, 5, 6, 7]),
            }),
            materials: None,
            ..triangle.surface().clone()
        }
    }

    #[test]
    fn every_corner_is_drawn_with_its_place_and_its_texture_coordinate() {
        let surface = surface();
        let drawing = Drawing::new(&surface).unwrap();
        assert_eq!(drawing.copies, [1, 4]);
        let mut positions = surface.rest.as_flattened().to_vec();
        drawing.add_copies(&mut positions);
        let (drawn, _) = positions.as_chunks::<3>();
        let uvs = drawing.uvs.unwrap();
        assert_eq!((drawn.len(), uvs.len()), (9, 9));
        let corners = surface.triangle_corners().unwrap();
        for ((drawing, triangle), corners) in drawing.triangles.iter().zip(&surface.triangles).zip(corners) {
            for i in 0..3 {
                assert_eq!(drawn[drawing[i] as usize], surface.rest[triangle[i] as usize]);
                // The corners have one entry each.
                assert_eq!(uvs[drawing[i] as usize], [corners[i] as f32, 0.5]);
            }
        }
    }

    #[test]
    fn triangles_are_grouped_by_material() {
        let mut surface = surface();
        let materials = Materials {
            list: vec![Material::new("teeth")],
            textures: Vec::new(),
            of_face: vec![Materials::NONE, 0],
        };
        surface.materials = Some(materials);
        let drawing = Drawing::new(&surface).unwrap();
        let group = |first, material| Group { first, count: 2, material };
        assert_eq!(drawing.groups, [group(0, Some(0)), group(2, None)]);
        assert_eq!(drawing.triangles[2..], [[0, 1, 4], [0, 4, 3]]);
    }

    #[test]
    fn a_coordinate_for_each_vertex_makes_no_copies() {
        let mut surface = surface();
        surface.uvs = Some(Uvs { values: vec![[0.25, 0.75]; 7], corners: None });
        let drawing = Drawing::new(&surface).unwrap();
        assert_eq!((drawing.copies.len(), drawing.uvs.unwrap().len()), (0, 7));
        surface.uvs = None;
        assert_eq!(Drawing::new(&surface).unwrap().uvs, None);
    }
}
