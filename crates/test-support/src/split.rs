//! Faces whose vertices are split as glTF splits them.
use rhytid_core::{Example, Face, Faces, Mesh, VertexId};
use std::collections::BTreeMap;

/// A face with more vertices than it has points.
pub struct Split {
    /// The face, whose vertices are joined for the solve.
    pub face: Face,
    /// For each of its vertices, the vertex of the face that was split.
    pub of_vertex: Vec<u32>,
}

/// The face with a vertex for each pair of a vertex and what `side` makes of a face around it. Vertices are in
/// the order of those that were split.
///
/// With the number of the face as its side, every corner is a vertex, as with flat shading.
pub fn split(face: &Face, side: impl Fn(usize, &[u32]) -> usize) -> Split {
    let mut numbers: BTreeMap<(u32, usize), u32> = BTreeMap::new();
    for (f, corners) in face.neutral.faces.iter().enumerate() {
        corners.iter().for_each(|&v| _ = numbers.insert((v, side(f, corners)), 0));
    }
    numbers.values_mut().zip(0..).for_each(|(number, v)| *number = v);
    let of_vertex: Vec<u32> = numbers.keys().map(|(v, _)| *v).collect();
    let mut faces = Faces::default();
    for (f, corners) in face.neutral.faces.iter().enumerate() {
        faces.push(&corners.iter().map(|&v| numbers[&(v, side(f, corners))]).collect::<Vec<_>>());
    }
    let chosen = |positions: &[[f64; 3]]| of_vertex.iter().map(|&v| positions[v as usize]).collect();
    // Any of the vertices may be named.
    let last = |v: VertexId| {
        VertexId::from_index(of_vertex.iter().rposition(|&of| of == v.0).expect("a vertex of a face"))
    };
    let mut copy = face.clone();
    copy.neutral = Mesh { positions: chosen(&face.neutral.positions), faces, ..Mesh::default() };
    let example = |example: &Example| Example { positions: chosen(&example.positions), ..example.clone() };
    copy.examples = face.examples.iter().map(example).collect();
    copy.handles.points.iter_mut().for_each(|point| *point = point.renamed(last));
    copy.settings.pins.vertices.iter_mut().for_each(|v| *v = last(*v));
    copy.settings.weld = true;
    Split { face: copy, of_vertex }
}

/// The left and the right half of the face, for [`split`]: a seam down the middle.
pub fn left_or_right(face: &Face) -> impl Fn(usize, &[u32]) -> usize + '_ {
    let [low, high] = face.neutral.bounds().unwrap_or_default();
    let middle = 0.5 * (low[0] + high[0]);
    move |_, corners| {
        let x: f64 = corners.iter().map(|&v| face.neutral.positions[v as usize][0] - middle).sum();
        usize::from(x > 0.0)
    }
}
