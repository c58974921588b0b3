//! Marks over a frame: markers and strain edges, the influences of a vertex, tangent frames.

use crate::heat::Heat;
use crate::overlay::Mark;
use glam::Vec3;
use rhytid_core::{HandleId, Rig};

const MARKER: [f32; 3] = [0.02, 0.02, 0.02];
const VERTEX: [f32; 3] = [0.9, 0.05, 0.02];
const ANCHOR: [f32; 3] = [0.02, 0.25, 0.9];
/// The colours of tangent, bitangent and normal.
const AXES: [[f32; 3]; 3] = [[0.9, 0.05, 0.02], [0.05, 0.6, 0.05], [0.02, 0.1, 0.9]];
/// About this many tangent frames are drawn.
const FRAMES: usize = 500;

/// The strain edges in the colours of their strains, and the markers over them, in a frame of V × 3
/// `positions`.
pub fn marker_marks(rig: &Rig, positions: &[f32], heat: Heat) -> Vec<Mark> {
    let (markers, rest) = (markers_of(rig, positions), &rig.handles().rest);
    let length = |points: &[[f32; 3]], edge: [HandleId; 2]| {
        let [a, b] = edge.map(|handle| Vec3::from(points[handle.index()]));
        a.distance(b)
    };
    let edge = |&edge: &[HandleId; 2]| Mark {
        ends: edge.map(|handle| markers[handle.index()]),
        colour: heat.colour(length(&markers, edge) / length(rest, edge) - 1.0),
        width: 2.0,
    };
    let dots = markers.iter().map(|&at| Mark::dot(at, MARKER, 5.0));
    rig.handles().strain_edges.iter().map(edge).chain(dots).collect()
}

/// The strain edges and the anchors that influence `vertex`, in a frame of V × 3 `positions`. A larger weight
/// has a wider mark (the chapter's figure 27.3).
///
/// # Panics
/// If the rig has no such vertex.
pub fn influence_marks(rig: &Rig, positions: &[f32], vertex: usize) -> Vec<Mark> {
    let markers = markers_of(rig, positions);
    let at = positions.as_chunks::<3>().0[vertex];
    let edges = rig.influences().at(vertex);
    let width = |weight: f32, most: f32| 1.5 + 8.0 * weight / most.max(f32::MIN_POSITIVE);
    let most = edges.clone().map(|(_, weight)| weight).fold(0.0, f32::max);
    let mut marks: Vec<Mark> = edges
        .filter(|(_, weight)| *weight > 0.0)
        .map(|(edge, weight)| Mark {
            ends: rig.handles().strain_edges[edge.index()].map(|handle| markers[handle.index()]),
            colour: VERTEX,
            width: width(weight, most),
        })
        .collect();
    if let Some(learned) = rig.learned() {
        let anchors = learned.anchors_of(vertex);
        let most = anchors.clone().map(|(_, weight)| weight).fold(0.0, f32::max);
        marks.extend(anchors.filter(|(_, weight)| *weight > 0.0).map(|(handle, weight)| Mark {
            ends: [at, markers[handle.index()]],
            colour: ANCHOR,
            width: 0.5 * width(weight, most),
        }));
    }
    marks.extend(markers.iter().map(|&at| Mark::dot(at, MARKER, 4.0)));
    marks.push(Mark::dot(at, [1.0; 3], 11.0));
    marks.push(Mark::dot(at, VERTEX, 8.0));
    marks
}

/// The tangent frames of some vertices, each axis as long as `length`: the tangent red, the bitangent green,
/// the normal blue (figure 27.4).
pub fn tangent_frame_marks(rig: &Rig, positions: &[f32], normals: &[f32], length: f32) -> Vec<Mark> {
    let (points, _) = positions.as_chunks::<3>();
    let (normals, _) = normals.as_chunks::<3>();
    let step = (points.len() / FRAMES).max(1);
    let mut marks = Vec::new();
    for v in (0..points.len()).step_by(step) {
        let (at, n) = (Vec3::from(points[v]), Vec3::from(normals[v]));
        let e = Vec3::from(points[rig.surface().tangent_neighbors[v].index()]) - at;
        let t = e - e.dot(n) * n;
        let size = t.length();
        if size == 0.0 {
            continue;
        }
        let t = t / size;
        marks.extend([t, n.cross(t), n].into_iter().zip(AXES).map(|(axis, colour)| Mark {
            ends: [at, at + length * axis].map(Into::into),
            colour,
            width: 2.0,
        }));
    }
    marks
}

fn markers_of(rig: &Rig, positions: &[f32]) -> Vec<[f32; 3]> {
    let (points, _) = positions.as_chunks::<3>();
    rig.handles().points.iter().map(|point| point.at(points)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::NoProgress;

    fn rig() -> Rig {
        rhytid_solve::solve(&rhytid_demo::face(2_000), &NoProgress).unwrap().rounded().unwrap()
    }

    #[test]
    fn edges_have_the_colours_of_their_strains() {
        let rig = rig();
        let mut positions = rig.surface().rest.as_flattened().to_vec();
        positions.iter_mut().for_each(|x| *x *= 1.1);
        let heat = Heat::Signed(0.3);
        let marks = marker_marks(&rig, &positions, heat);
        assert_eq!(marks.len(), rig.handles().strain_edges.len() + rig.handles().len());
        for (mark, edge) in marks.iter().zip(&rig.handles().strain_edges) {
            let expected = heat.colour(0.1);
            assert!((0..3).all(|c| (mark.colour[c] - expected[c]).abs() < 1e-4), "{mark:?}");
            let [a, _] = edge.map(|handle| rig.handles().rest[handle.index()]);
            assert!((0..3).all(|c| (mark.ends[0][c] - 1.1 * a[c]).abs() < 1e-4));
        }
    }

    #[test]
    fn a_vertex_has_its_influences_and_frames_are_at_right_angles() {
        let rig = rig();
        let positions = rig.surface().rest.as_flattened();
        let vertex = rig.vertices() / 2;
        let weights = rig.influences().weights.row(vertex);
        let edges = weights.iter().filter(|weight| **weight > 0.0).count();
        let marks = influence_marks(&rig, positions, vertex);
        let lines = marks.iter().filter(|mark| mark.ends[0] != mark.ends[1]);
        let red = lines.filter(|mark| mark.colour == VERTEX).count();
        assert!(edges > 0 && red == edges, "{red} of {edges}");
        assert_eq!(marks.last().unwrap().ends[0], rig.surface().rest[vertex]);

        let normal = [0.0, 0.0, 1.0].repeat(rig.vertices());
        let marks = tangent_frame_marks(&rig, positions, &normal, 0.5);
        assert!(marks.len() > 3 * FRAMES / 2);
        for frame in marks.chunks(3) {
            let axis = |mark: &Mark| (Vec3::from(mark.ends[1]) - Vec3::from(mark.ends[0])) / 0.5;
            let axes: Vec<Vec3> = frame.iter().map(axis).collect();
            for i in 0..3 {
                for j in 0..3 {
                    let dot = axes[i].dot(axes[j]);
                    assert!((dot - if i == j { 1.0 } else { 0.0 }).abs() < 1e-3, "{axes:?}");
                }
            }
            // Right-handed: n = t × b.
            let [t, b, n] = [axes[0], axes[1], axes[2]];
            assert!((t[0] * b[1] - t[1] * b[0] - n[2]).abs() < 1e-3);
        }
    }
}
