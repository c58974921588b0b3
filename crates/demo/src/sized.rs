//! A rig of any size, made without solving: for measuring, not for looking at.
use crate::sized_learned;
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{Faces, Method, Rig, UpAxis};
use rhytid_geometry::Topology;
use rhytid_geometry::geodesic;
use rhytid_kernels::strain;
use rhytid_solve::{influences, tangent_frames};

/// How large a rig is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// V, at least 4; as many as make a whole grid are taken, at most 2 % fewer from 10,000 on.
    pub vertices: usize,
    /// H, at least 3 and at most V / 4.
    pub handles: usize,
    /// P.
    pub examples: usize,
}

impl Size {
    /// The face of GPU Computing Gems (Emerald), chapter 27.
    pub const CHAPTER: Self = Self { vertices: 530_000, handles: 89, examples: 6 };
}

/// K, as in a solve with the usual settings.
const INFLUENCES: usize = 16;

/// A rig of this size, in centimetres. Its surface is a bulged sheet; strain edges, influences and tangent neighbours are those of a solve, so that
/// what lies near in the face lies near in memory; basis and weights are smooth functions of about the right magnitude, which devices take
/// as long for as for solved ones. By the learned method every vertex has the strain edges, anchors and linear band of a solve's, by straight distances;
/// its settings are not looked at.
pub fn sized_rig(size: Size, method: Method) -> Rig {
    let columns = ((size.vertices as f64).sqrt() as usize).max(2);
    let lines = (size.vertices / columns).max(2);
    let rest: Vec<[f64; 3]> = (0..columns * lines)
        .map(|v| {
            let [x, y] =
                [(v % columns, columns), (v / columns, lines)].map(|(i, n)| i as f64 / (n - 1) as f64 - 0.5);
            [20.0 * x, 25.0 * y, 8.0 * (1.0 - 2.0 * (x * x + y * y))]
        })
        .collect();
    let corners = |v: usize| [v, v + 1, v + columns + 1, v + columns].map(|v| v as u32);
    let quads: Vec<[u32; 4]> =
        (0..columns * (lines - 1)).filter(|v| v % columns + 1 < columns).map(corners).collect();
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let topology = Topology::new(rest.len(), &triangles);
    let handles = spread(size.handles, columns, lines);

    let cells = geodesic::voronoi_cells(&rest, &topology, &handles);
    let strain_edges = geodesic::touching_cells(&topology, &cells);
    let rest_lengths = strain::rest_lengths(&rest, &handles, &strain_edges);
    let handle_rest: Vec<[f64; 3]> = handles.iter().map(|&v| rest[v as usize]).collect();
    let influences = influences::influences(&rest, &handle_rest, &strain_edges, &rest_lengths, INFLUENCES);
    let spacing = (500.0 / handles.len() as f64).sqrt();
    let mut basis = vec![0.0; rest.len() * handles.len()];
    basis.par_chunks_mut(handles.len()).zip(&rest).for_each(|(row, v)| {
        for (b, h) in row.iter_mut().zip(&handle_rest) {
            let square = DVec3::from(*v).distance_squared(DVec3::from(*h));
            *b = (-square / (spacing * spacing)).exp();
        }
        let sum: f64 = row.iter().sum();
        row.iter_mut().for_each(|b| *b /= sum);
    });
    for (h, &v) in handles.iter().enumerate() {
        let row = &mut basis[v as usize * handles.len()..][..handles.len()];
        row.fill(0.0);
        row[h] = 1.0;
    }
    let centers = size.examples + 1;
    let wave = |i: usize| (i as f64 * 0.618).sin();
    let rig = Rig {
        name: "sheet".into(),
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        labels: (0..handles.len()).map(|h| format!("m{h}")).collect(),
        example_names: (1..centers).map(|j| format!("example {j}")).collect(),
        faces: Faces { counts: vec![4; quads.len()], indices: quads.into_flattened() },
        uvs: None,
        materials: None,
        bending_length: spacing,
        beta: influences.beta,
        tangent_neighbors: tangent_frames::tangent_neighbors(&rest, &triangles, &topology),
        pose_features: (0..centers * strain_edges.len())
            .map(|i| if i < strain_edges.len() { 0.0 } else { 0.2 * wave(i) })
            .collect(),
        rbf_weights: (0..rest.len() * centers).map(|i| [0.1, 0.2, 0.3].map(|c| c * wave(i))).collect(),
        example_handles: (0..size.examples * handles.len())
            .map(|i| handle_rest[i % handles.len()].map(|x| x + 0.3 * wave(i)))
            .collect(),
        rotations: false,
        learned: None,
        influence_edges: influences.edges,
        influence_weights: influences.weights,
        triangles,
        basis,
        strain_edges,
        handles,
        rest,
    };
    match method {
        Method::Chapter => rig.cast(),
        Method::Learned(_) => sized_learned::learned(rig, &handle_rest, &rest_lengths).cast(),
    }
}

/// Distinct vertices of a grid, spread evenly.
fn spread(count: usize, columns: usize, lines: usize) -> Vec<u32> {
    let across = (1..).find(|n| n * n >= count).unwrap_or(1);
    let down = count.div_ceil(across);
    let place = |h: usize| {
        let (i, j) = (h % across, h / across);
        let [x, y] = [(i, across, columns), (j, down, lines)].map(|(i, n, of)| (2 * i + 1) * of / (2 * n));
        (y * columns + x) as u32
    };
    (0..count).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rigs_of_all_sizes_are_sound() {
        for (vertices, handles, examples) in [(400, 89, 0), (2_500, 3, 1), (10_000, 300, 40), (20_011, 89, 6)]
        {
            for method in [Method::Chapter, Method::default()] {
                let rig = sized_rig(Size { vertices, handles, examples }, method);
                rig.check().unwrap();
                assert!(
                    rig.vertices() <= vertices && rig.vertices() * 50 >= vertices * 49,
                    "{}",
                    rig.vertices()
                );
                assert_eq!((rig.handles.len(), rig.centers()), (handles, examples + 1));
                assert_eq!(rig.influences(), rig.strain_edges.len().min(INFLUENCES));
            }
        }
    }

    #[test]
    fn the_chapters_face_has_about_its_strain_edges() {
        let rig = sized_rig(Size { vertices: 20_000, ..Size::CHAPTER }, Method::Chapter);
        assert!((220..270).contains(&rig.strain_edges.len()), "{}", rig.strain_edges.len());
    }
}
