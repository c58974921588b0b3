//! Findings about handles inside triangles.
use super::finding::Finding;
use super::impossible::error;
use super::words::{count, first_few};
use rhytid_core::{Face, SurfacePoint, VertexId};
use std::collections::{BTreeMap, HashSet};

/// Handles are too near each other if what sets one apart from the others is below this, as a weight of a
/// corner.
const TOO_NEAR: f64 = 0.02;

fn inside(face: &Face) -> impl Iterator<Item = (&String, &SurfacePoint)> {
    face.handles.labels.iter().zip(&face.handles.points).filter(|(_, point)| point.vertex().is_none())
}

/// Handles whose vertices do not belong to one face.
pub(super) fn not_on_a_face(face: &Face) -> Option<Finding> {
    let vertices = face.neutral.positions.len();
    // Others are reported already.
    let exists = |point: &SurfacePoint| point.triangle().iter().all(|v| v.index() < vertices);
    let points: Vec<(&String, &SurfacePoint)> = inside(face).filter(|(_, point)| exists(point)).collect();
    let corners: HashSet<VertexId> = points.iter().flat_map(|(_, point)| point.triangle()).collect();
    let mut is_on_a_face = vec![false; points.len()];
    for of_face in face.neutral.faces.iter() {
        // Most faces have no handle.
        if of_face.iter().filter(|v| corners.contains(&VertexId(**v))).count() >= 2 {
            for (is_on, (_, point)) in is_on_a_face.iter_mut().zip(&points) {
                *is_on |= point.corners().all(|(v, _)| of_face.contains(&v.0));
            }
        }
    }
    let astray = points.iter().zip(is_on_a_face).filter(|(_, is_on)| !is_on);
    let astray: Vec<&(&String, &SurfacePoint)> = astray.map(|(handle, _)| handle).collect();
    let named: Vec<String> = astray.iter().map(|(label, point)| format!("{label} ({point})")).collect();
    (!astray.is_empty()).then(|| {
        error(
            "handle-on-no-face",
            format!(
                "{} vertices that do not belong to one face: {}; a handle lies on a face, so name vertices of one",
                count(astray.len(), "handle has", "handles have"),
                first_few(&named)
            ),
        )
        .at(astray.iter().flat_map(|(_, point)| point.triangle()))
    })
}

/// Handles that cannot be met whatever the others do: more than three in a triangle, or two at nearly one
/// place.
///
/// The rows of the weights are made orthogonal one after the other (Gram and Schmidt).
pub(super) fn not_met_together(face: &Face) -> Option<Finding> {
    let vertices: HashSet<VertexId> = face.handles.points.iter().filter_map(SurfacePoint::vertex).collect();
    let mut directions: Vec<BTreeMap<VertexId, f64>> = Vec::new();
    let mut bound = Vec::new();
    for (label, point) in inside(face) {
        let free = point.corners().filter(|(v, _)| !vertices.contains(v));
        let mut row: BTreeMap<VertexId, f64> = free.collect();
        for direction in &directions {
            let along: f64 = row.iter().filter_map(|(v, x)| Some(x * direction.get(v)?)).sum();
            if along != 0.0 {
                direction.iter().for_each(|(v, x)| *row.entry(*v).or_default() -= along * x);
            }
        }
        let length = row.values().map(|x| x * x).sum::<f64>().sqrt();
        match length >= TOO_NEAR {
            true => directions.push(row.into_iter().map(|(v, x)| (v, x / length)).collect()),
            false => bound.push(format!("{label} ({point})")),
        }
    }
    (!bound.is_empty()).then(|| {
        error(
            "handles-too-near",
            format!(
                "{} where the handles around leave no choice: {}; leave out one of the handles there, or \
                 give each a vertex of its own",
                count(bound.len(), "handle is", "handles are"),
                first_few(&bound)
            ),
        )
    })
}

/// Handles that turn and are at no vertex.
pub(super) fn turning(face: &Face) -> Option<Finding> {
    let labels: Vec<&String> = inside(face).map(|(label, _)| label).collect();
    (face.settings.rotations && !labels.is_empty()).then(|| {
        error(
            "rotations",
            format!(
                "rotations = true needs handles at vertices, but {} inside a triangle: {}; give each of them a \
                 vertex in the table of handles, or leave rotations out",
                count(labels.len(), "handle is", "handles are"),
                first_few(&labels)
            ),
        )
    })
}
