//! A mesh of the same surface with other vertices, in another order, and other faces.
use rhytid_core::{Face, Faces, Mesh, SurfacePoint, VertexId};
use rhytid_geometry::triangulate;
use rhytid_kernels::normals::{VertexTriangles, fan};

/// A surface with a new mesh.
pub(crate) struct Remeshed {
    /// The mesh.
    pub mesh: Mesh,
    /// The place of each of its vertices on the first mesh: three vertices and their weights.
    pub places: Vec<([u32; 3], [f64; 3])>,
    /// The first mesh's handles.
    pub handles: Vec<SurfacePoint>,
}

impl Remeshed {
    /// Values of the first mesh at the vertices of the second.
    pub(crate) fn at(&self, values: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let mean = |(corners, weights): &([u32; 3], [f64; 3])| {
            [0, 1, 2].map(|c| (0..3).map(|i| weights[i] * values[corners[i] as usize][c]).sum())
        };
        self.places.iter().map(mean).collect()
    }
}

/// A reproducible number from 0 to 1.
fn noise(i: usize) -> f64 {
    let x = (i as f64 * 12.9898).sin() * 43758.5453;
    x - x.floor()
}

/// Makes the new mesh. Vertices slide into a neighbouring triangle. A third of those that can go are removed
/// and leave a polygon. All vertices are renumbered. Handles and the border stay where they are.
pub(crate) fn remeshed(face: &Face) -> Remeshed {
    let triangles = triangulate(&face.neutral);
    let count = face.neutral.positions.len();
    let at_vertices = VertexTriangles::new(count, &triangles);
    let rings: Vec<Vec<u32>> = (0..count).map(|v| fan(v as u32, &triangles, at_vertices.at(v))).collect();
    let is_inside = |v: usize| {
        let ring = &rings[v];
        // A ring is closed if it has as many vertices as triangles.
        let distinct: std::collections::BTreeSet<u32> = ring.iter().copied().collect();
        distinct.len() == at_vertices.at(v).len()
    };
    let fixed: Vec<bool> = (0..count)
        .map(|v| !is_inside(v) || face.handles.points.contains(&VertexId::from_index(v).into()))
        .collect();
    let mut gone = vec![false; count];
    let mut stays = fixed.clone();
    for v in 0..count {
        let around = || triangles_around(v, &at_vertices, &triangles);
        if !stays[v] && noise(v) < 0.5 && around().all(|w| !gone[w as usize]) {
            gone[v] = true;
            around().for_each(|w| stays[w as usize] = true);
        }
    }
    // Renumbered from the end.
    let kept: Vec<usize> = (0..count).rev().filter(|&v| !gone[v]).collect();
    let mut number = vec![0; count];
    kept.iter().enumerate().for_each(|(i, &v)| number[v] = i as u32);
    let place = |&v: &usize| {
        if fixed[v] {
            return ([v as u32; 3], [1.0, 0.0, 0.0]);
        }
        let of_vertex = at_vertices.at(v);
        let t = triangles[of_vertex[(noise(v + 7) * of_vertex.len() as f64) as usize] as usize];
        let (slide, along) = (0.3 * noise(v + 13), noise(v + 29));
        let mut others = [along, 1.0 - along].into_iter();
        (t, t.map(|w| if w as usize == v { 1.0 - slide } else { slide * others.next().unwrap() }))
    };
    let mut faces = Faces::default();
    for v in (0..count).filter(|&v| gone[v]) {
        // A closed ring ends where it begins.
        let ring = &rings[v][..at_vertices.at(v).len()];
        faces.push(&ring.iter().map(|&w| number[w as usize]).collect::<Vec<_>>());
    }
    for t in &triangles {
        if t.iter().all(|&v| !gone[v as usize]) {
            faces.push(&t.map(|v| number[v as usize]));
        }
    }
    let places: Vec<_> = kept.iter().map(place).collect();
    let mut made = Remeshed {
        mesh: Mesh { faces, ..Mesh::default() },
        places,
        handles: face
            .handles
            .points
            .iter()
            .map(|point| point.renamed(|v| VertexId(number[v.index()])))
            .collect(),
    };
    made.mesh.positions = made.at(&face.neutral.positions);
    made
}

fn triangles_around<'a>(
    v: usize,
    at_vertices: &'a VertexTriangles,
    triangles: &'a [[u32; 3]],
) -> impl Iterator<Item = u32> + 'a {
    let of_vertex = at_vertices.at(v).iter().flat_map(|&t| triangles[t as usize]);
    of_vertex.filter(move |w| *w as usize != v)
}
