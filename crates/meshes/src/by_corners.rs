//! Meshes whose files split their vertices in other ways, matched corner by corner.
//!
//! A glTF file has a vertex for each normal and texture coordinate at a point. So one shape that is exported
//! flat and smooth has other vertices, but the same corners of faces in the same order.

use rhytid_core::Mesh;
use rhytid_geometry::Points;

/// Corners of one vertex are within this part of the mesh's size.
const TOGETHER: f64 = 1e-6;

/// This part of the points that the neutral has by itself must be points of both meshes. Others are lips that
/// touch in one of them.
const POINTS_OF_BOTH: f64 = 0.9;

/// For each vertex of the neutral, a vertex of `mesh` in its place. `None` for a vertex in no face.
///
/// Both need faces of as many corners in the same order. All corners of a vertex of the neutral must be in
/// one place in `mesh`. The vertices of both are joined where both meshes have them in one place, and must
/// then be as many points. `None` where any of it does not hold.
pub(super) fn vertices(mesh: &Mesh, neutral: &Mesh) -> Option<Vec<Option<u32>>> {
    if mesh.faces.counts != neutral.faces.counts {
        return None;
    }
    let of_neutral = in_one_place(neutral, mesh)?;
    let of_mesh = in_one_place(mesh, neutral)?;
    let unused = |vertices: &[Option<u32>]| vertices.iter().filter(|vertex| vertex.is_none()).count();
    let (alone, of_both) =
        (count(neutral, &[]), count(neutral, &[&moved(&neutral.positions, &of_neutral, &mesh.positions)]));
    let of_mesh = count(mesh, &[&moved(&mesh.positions, &of_mesh, &neutral.positions)]) - unused(&of_mesh);
    let joins = |points: usize| (neutral.positions.len() - points) as f64;
    let is_enough = joins(of_both) >= POINTS_OF_BOTH * joins(alone);
    (is_enough && of_both - unused(&of_neutral) == of_mesh).then_some(of_neutral)
}

/// For each vertex of `mesh`, the vertex of `other` at its first corner. `None` if a vertex has corners in
/// several places of `other`.
fn in_one_place(mesh: &Mesh, other: &Mesh) -> Option<Vec<Option<u32>>> {
    let [low, high] = other.bounds()?;
    let size = (0..3).map(|c| (high[c] - low[c]).powi(2)).sum::<f64>().sqrt();
    let mut vertices = vec![None; mesh.positions.len()];
    for (&v, corner) in mesh.faces.indices.iter().zip(corners(mesh, other)) {
        let w = other.faces.indices[corner];
        let first = *vertices[v as usize].get_or_insert(w);
        let [a, b] = [first, w].map(|w| other.positions[w as usize]);
        if (0..3).any(|c| (a[c] - b[c]).abs() > TOGETHER * size) {
            return None;
        }
    }
    Some(vertices)
}

/// How a quad a, b, c, d is cut into two triangles that follow each other in a file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Cut {
    /// a, b, c and a, c, d.
    Ac,
    /// a, b, d and b, c, d.
    Bd,
}

/// For each corner of `mesh`, the corner of `other`, which has faces of as many corners.
///
/// It has the same number, except in quads that are cut in another way. Exporters cut a quad by its shape, so
/// a few are cut in another way in a pose.
fn corners(mesh: &Mesh, other: &Mesh) -> Vec<usize> {
    let mut corners: Vec<usize> = (0..mesh.faces.indices.len()).collect();
    let mut first = 0;
    for counts in mesh.faces.counts.windows(2) {
        if counts == [3, 3] {
            let of_quad = match (cut(mesh, first), cut(other, first)) {
                (Some(Cut::Ac), Some(Cut::Bd)) => Some([0, 1, 4, 0, 4, 5]),
                (Some(Cut::Bd), Some(Cut::Ac)) => Some([0, 1, 5, 1, 2, 5]),
                _ => None,
            };
            for (i, corner) in of_quad.into_iter().flatten().enumerate() {
                corners[first + i] = first + corner;
            }
        }
        first += counts[0] as usize;
    }
    corners
}

/// How the two triangles with the six corners from `first` on cut a quad, by the places of the corners.
fn cut(mesh: &Mesh, first: usize) -> Option<Cut> {
    let at = |corner: usize| mesh.positions[mesh.faces.indices[first + corner] as usize];
    if at(0) == at(3) && at(2) == at(4) {
        Some(Cut::Ac)
    } else if at(1) == at(3) && at(2) == at(5) {
        Some(Cut::Bd)
    } else {
        None
    }
}

/// Positions where `other` has the vertices of a mesh. Those in no face are where they are in `own`.
pub(super) fn moved(own: &[[f64; 3]], vertices: &[Option<u32>], other: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let at = |(own, vertex): (&[f64; 3], &Option<u32>)| match vertex {
        Some(vertex) => other[*vertex as usize],
        None => *own,
    };
    own.iter().zip(vertices).map(at).collect()
}

/// The number of points of a mesh that are points in the examples too.
fn count(mesh: &Mesh, examples: &[&[[f64; 3]]]) -> usize {
    Points::new(mesh, examples).map_or(mesh.positions.len(), |points| points.len())
}
