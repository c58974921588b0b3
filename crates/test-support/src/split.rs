//! Meshes and faces whose vertices are split as glTF splits them.
use rhytid_core::{Example, Face, Faces, Mesh, VertexId};
use std::collections::BTreeMap;

/// A mesh with more vertices than it has points.
pub struct SplitMesh {
    /// The mesh, without texture coordinates and materials.
    pub mesh: Mesh,
    /// For each of its vertices, the vertex of the mesh that was split.
    pub of_vertex: Vec<u32>,
}

/// A face with more vertices than it has points.
pub struct SplitFace {
    /// The face, whose vertices are joined for the solve.
    pub face: Face,
    /// For each of its vertices, the vertex of the face that was split.
    pub of_vertex: Vec<u32>,
}

/// The mesh with a vertex for each pair of a vertex and the side of one of its corners. Vertices are in the
/// order of those that were split.
///
/// `side` takes the number of a face and that of a corner. With the face as its side, every corner is a
/// vertex, as with flat shading.
pub fn split_mesh(mesh: &Mesh, side: impl Fn(usize, usize) -> usize) -> SplitMesh {
    let of_faces = (0..).zip(&mesh.faces.counts).flat_map(|(f, &n)| std::iter::repeat_n(f, n as usize));
    let corners: Vec<(u32, usize)> = of_faces
        .zip(&mesh.faces.indices)
        .enumerate()
        .map(|(corner, (face, &v))| (v, side(face, corner)))
        .collect();
    let mut numbers: BTreeMap<(u32, usize), u32> = corners.iter().map(|corner| (*corner, 0)).collect();
    numbers.values_mut().zip(0..).for_each(|(number, v)| *number = v);
    let of_vertex: Vec<u32> = numbers.keys().map(|(v, _)| *v).collect();
    let positions = of_vertex.iter().map(|&v| mesh.positions[v as usize]).collect();
    let indices = corners.iter().map(|corner| numbers[corner]).collect();
    let faces = Faces { counts: mesh.faces.counts.clone(), indices };
    SplitMesh { mesh: Mesh { positions, faces, ..Mesh::default() }, of_vertex }
}

/// As [`split_mesh`], with all that belongs to a face. Any of the vertices of a point may be a handle.
pub fn split(face: &Face, side: impl Fn(usize, usize) -> usize) -> SplitFace {
    let SplitMesh { mesh, of_vertex } = split_mesh(&face.neutral, side);
    let last = |v: VertexId| {
        VertexId::from_index(of_vertex.iter().rposition(|&of| of == v.0).expect("a vertex of a face"))
    };
    let mut copy = face.clone();
    copy.neutral = mesh;
    let example = |example: &Example| {
        let positions = of_vertex.iter().map(|&v| example.positions[v as usize]).collect();
        Example { positions, ..example.clone() }
    };
    copy.examples = face.examples.iter().map(example).collect();
    copy.handles.points.iter_mut().for_each(|point| *point = point.renamed(last));
    copy.settings.pins.vertices.iter_mut().for_each(|v| *v = last(*v));
    copy.settings.weld = true;
    SplitFace { face: copy, of_vertex }
}

/// The left and the right half of a mesh as sides: a seam down the middle.
pub fn left_or_right(mesh: &Mesh) -> impl Fn(usize, usize) -> usize + use<> {
    let [low, high] = mesh.bounds().unwrap_or_default();
    let middle = 0.5 * (low[0] + high[0]);
    let is_right = |face: &[u32]| {
        let x: f64 = face.iter().map(|&v| mesh.positions[v as usize][0] - middle).sum();
        x > 0.0
    };
    let sides: Vec<usize> = mesh.faces.iter().map(|face| usize::from(is_right(face))).collect();
    move |face, _| sides[face]
}
