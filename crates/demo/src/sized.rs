//! A rig of any size, made without a solve: for measurements, not for viewing.
use crate::sized_learned;
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{
    Examples, Faces, FineScale, HandleSet, Method, Rig, RigParts, Surface, SurfacePoint, Table, UpAxis,
    VertexId,
};
use rhytid_geometry::{Topology, geodesic};
use rhytid_solve::{influences, tangent_frames};

/// How large a rig is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// V, at least 4. The rig has the vertices of a whole grid: from 10,000 on, at most 2 % fewer.
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

/// A rig of this size, in centimetres. Its surface is a bulged sheet. Strain edges, influences and tangent
/// neighbours are as from a solve, so vertices near each other in the face are near each other in memory.
/// Basis and weights are smooth functions of about the right magnitude. Devices need as much time for them as
/// for solved ones. With the learned method, every vertex has strain edges, anchors and a linear band as from
/// a solve, by straight distances. The method's settings are ignored.
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
    let points: Vec<SurfacePoint> =
        spread(size.handles, columns, lines).into_iter().map(SurfacePoint::from).collect();

    let cells = geodesic::voronoi_cells(&rest, &topology, &points);
    let handles = HandleSet {
        labels: (0..points.len()).map(|h| format!("m{h}")).collect(),
        rest: points.iter().map(|point| point.at(&rest)).collect(),
        strain_edges: geodesic::touching_cells(&topology, &cells),
        points,
        rotations: false,
    };
    let edges = handles.strain_edges.len();
    let influences = influences::influences(
        &rest,
        &handles.rest,
        &handles.strain_edges,
        &handles.rest_lengths(),
        INFLUENCES,
    );
    let spacing = (500.0 / handles.len() as f64).sqrt();
    let centers = size.examples + 1;
    let wave = |i: usize| (i as f64 * 0.618).sin();
    let pose_features = (0..centers * edges).map(|i| if i < edges { 0.0 } else { 0.2 * wave(i) }).collect();
    let rbf_weights = (0..rest.len() * centers).map(|i| [0.1, 0.2, 0.3].map(|c| c * wave(i))).collect();
    let example_handles = (0..size.examples * handles.len())
        .map(|i| handles.rest[i % handles.len()].map(|x| x + 0.3 * wave(i)))
        .collect();
    let mut parts = RigParts {
        examples: Examples {
            names: (1..centers).map(|j| format!("example {j}")).collect(),
            handles: Table::new(size.examples, handles.len(), example_handles),
        },
        bending_length: spacing,
        basis: basis(&rest, &handles, spacing),
        influences,
        fine_scale: FineScale {
            pose_features: Table::new(centers, edges, pose_features),
            rbf_weights: Table::new(rest.len(), centers, rbf_weights),
        },
        learned: None,
        handles,
        surface: Surface {
            name: "sheet".into(),
            metres_per_unit: 0.01,
            up_axis: UpAxis::Y,
            faces: Faces { counts: vec![4; quads.len()], indices: quads.into_flattened() },
            uvs: None,
            materials: None,
            tangent_neighbors: tangent_frames::tangent_neighbors(&rest, &triangles, &topology),
            joined: None,
            triangles,
            rest,
        },
    };
    if let Method::Learned(_) = method {
        sized_learned::learn(&mut parts);
    }
    Rig::new(parts).and_then(|rig| rig.rounded()).expect("numbers of the right shapes and ranges")
}

/// A smooth basis that sums to 1 at every vertex, V×H. It has bells of width `spacing`. A handle's vertex
/// follows only this handle.
fn basis(rest: &[[f64; 3]], handles: &HandleSet<f64>, spacing: f64) -> Table<f64> {
    let mut basis = Table::filled(rest.len(), handles.len(), 0.0);
    basis.par_rows_mut().zip(rest).for_each(|(row, v)| {
        for (b, h) in row.iter_mut().zip(&handles.rest) {
            let square = DVec3::from(*v).distance_squared(DVec3::from(*h));
            *b = (-square / (spacing * spacing)).exp();
        }
        let sum: f64 = row.iter().sum();
        row.iter_mut().for_each(|b| *b /= sum);
    });
    for (h, point) in handles.points.iter().enumerate() {
        let row = basis.row_mut(point.nearest_vertex().index());
        row.fill(0.0);
        row[h] = 1.0;
    }
    basis
}

/// Distinct vertices of a grid, spread evenly.
fn spread(count: usize, columns: usize, lines: usize) -> Vec<VertexId> {
    let across = (1..).find(|n| n * n >= count).unwrap_or(1);
    let down = count.div_ceil(across);
    let place = |h: usize| {
        let (i, j) = (h % across, h / across);
        let [x, y] = [(i, across, columns), (j, down, lines)].map(|(i, n, of)| (2 * i + 1) * of / (2 * n));
        VertexId::from_index(y * columns + x)
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
                assert!(
                    rig.vertices() <= vertices && rig.vertices() * 50 >= vertices * 49,
                    "{}",
                    rig.vertices()
                );
                assert_eq!((rig.handles().len(), rig.centers()), (handles, examples + 1));
                assert_eq!(rig.influences().per_vertex(), rig.handles().strain_edges.len().min(INFLUENCES));
            }
        }
    }

    #[test]
    fn the_chapters_face_has_about_its_strain_edges() {
        let rig = sized_rig(Size { vertices: 20_000, ..Size::CHAPTER }, Method::Chapter);
        assert!(
            (220..270).contains(&rig.handles().strain_edges.len()),
            "{}",
            rig.handles().strain_edges.len()
        );
    }
}
