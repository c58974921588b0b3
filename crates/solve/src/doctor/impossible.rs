//! Findings that make a solve impossible.
use super::finding::{Report, Severity};
use super::words::{count, first_few, length};
use glam::DVec3;
use rhytid_core::HandleId;
use rhytid_core::{Face, LearnedSettings, Method, StrainEdges};
use rhytid_geometry::laplacian::is_degenerate;
use rhytid_geometry::triangulate;
use std::collections::HashMap;

/// What float32 rounds away, at most, of a number's size.
pub(super) const FLOAT32: f64 = f32::EPSILON as f64 / 2.0;
/// The part of a mesh's size by which its vertices may not be moved.
const BLURRED: f64 = 0.01;
/// Bending lengths, in sizes of the mesh, that the system can be solved for: neither a membrane nor a plate of nothing else.
const BENDING_LENGTHS: std::ops::RangeInclusive<f64> = 1e-6..=1e4;

pub(super) fn examine(face: &Face, report: &mut Report) {
    let mut error = |code: &'static str, message: String| report.add(Severity::Error, code, message);
    let mesh = &face.neutral;
    let vertices = mesh.positions.len();
    if mesh.faces.is_empty() || vertices == 0 {
        return error(
            "no-faces",
            "the neutral mesh has no faces; export it as a surface, not as points".into(),
        );
    }
    if let Some(v) = not_finite(&mesh.positions) {
        return error(
            "not-finite",
            format!("vertex {v} of the neutral mesh is at {:?}, expected finite numbers", mesh.positions[v]),
        );
    }
    if let Some(fault) = mesh.faces.fault(vertices) {
        return error("faces", format!("the neutral mesh: {fault}"));
    }
    // The rig carries the texture coordinates along.
    if let Some(fault) = mesh.uvs.as_ref().and_then(|uvs| uvs.fault(vertices, &mesh.faces)) {
        error("uvs", format!("the neutral mesh: {fault}"));
    }
    let position = |v: u32| DVec3::from_array(mesh.positions[v as usize]);
    if triangulate(mesh).iter().all(|t| is_degenerate(t.map(position))) {
        error("no-area", "no triangle of the neutral mesh has an area; check its coordinates".into());
    }

    let handles = &face.handles;
    if handles.vertices.is_empty() {
        error("no-handles", "the face has no handles; list at least one label and vertex".into());
    }
    if handles.labels.len() != handles.vertices.len() {
        return error(
            "handles",
            format!(
                "the handles have {} labels and {} vertices; each needs one of both",
                handles.labels.len(),
                handles.vertices.len()
            ),
        );
    }
    let mut by_label = HashMap::new();
    let mut by_vertex = HashMap::new();
    for (label, &v) in handles.labels.iter().zip(&handles.vertices) {
        if v.index() >= vertices {
            error(
                "handle-out-of-range",
                format!(
                    "handle {label} is vertex {v}, expected 0 to {}; vertices count from 0",
                    vertices - 1
                ),
            );
        }
        if by_label.insert(label, v).is_some() {
            error("duplicate-handle", format!("handle {label} is listed twice; each label is one marker"));
        }
        // A label that is listed twice with its vertex was named just now.
        if let Some(other) = by_vertex.insert(v, label)
            && other != label
        {
            error(
                "duplicate-handle",
                format!("handles {other} and {label} are both vertex {v}; each needs a vertex of its own"),
            );
        }
    }
    for example in &face.examples {
        if example.positions.len() != vertices {
            error(
                "example",
                format!(
                    "example {} has {} vertices where the neutral mesh has {vertices}; every mesh needs the same \
                     vertices in the same order",
                    example.name,
                    example.positions.len()
                ),
            );
        } else if let Some(v) = not_finite(&example.positions) {
            error(
                "not-finite",
                format!(
                    "vertex {v} of example {} is at {:?}, expected finite numbers",
                    example.name, example.positions[v]
                ),
            );
        }
    }

    let settings = &face.settings;
    if let Some(v) = settings.pins.vertices.iter().find(|v| v.index() >= vertices) {
        error("pins", format!("vertex {v} is pinned, expected 0 to {}; vertices count from 0", vertices - 1));
    }
    let positive = |x: f64| x.is_finite() && x > 0.0;
    let [low, high] = mesh.bounds().unwrap_or_default().map(DVec3::from_array);
    let size = high.distance(low);
    let bends = |length: f64| positive(length) && BENDING_LENGTHS.contains(&(length / size));
    if let Some(found) = settings.bending_length.filter(|l| !bends(*l)) {
        let [least, most] =
            [BENDING_LENGTHS.start(), BENDING_LENGTHS.end()].map(|ratio| length(ratio * size));
        error(
            "settings",
            format!("bending_length is {found:?}, expected a length from {least} to {most} in mesh units"),
        );
    }
    // As the rig and its animations have them.
    let farthest = low.abs().max(high.abs()).max_element();
    if farthest * FLOAT32 > BLURRED * size {
        error(
            "far-from-origin",
            format!(
                "the neutral mesh is {} mesh units from the origin and {} across: in float32 its vertices are lost; \
                 move all meshes, by the same, to the origin",
                length(farthest),
                length(size)
            ),
        );
    }
    if settings.max_influences == 0 {
        error("settings", "max_influences is 0, expected at least 1".into());
    }
    if let Method::Learned(learned) = settings.method {
        let LearnedSettings { share, ridge, fold_ridge, marker_noise, reach, fold_strains: _ } = learned;
        for (name, number, is_right, expected) in [
            ("share", share, share.is_none_or(|s| (0.0..=1.0).contains(&s)), "0 to 1"),
            ("ridge", ridge, ridge.is_none_or(positive), "a number above 0"),
            ("fold_ridge", Some(fold_ridge), positive(fold_ridge), "a number above 0"),
            (
                "marker_noise",
                Some(marker_noise),
                marker_noise == 0.0 || positive(marker_noise),
                "millimetres from 0",
            ),
            ("reach", Some(reach), reach >= 1.0, "a number from 1, inf for no bound"),
        ] {
            if let Some(number) = number.filter(|_| !is_right) {
                error("settings", format!("{name} is {number}, expected {expected}"));
            }
        }
    }
    if let Method::Learned(LearnedSettings { share, reach, .. }) = settings.method
        && settings.rotations
        && (share.is_some_and(|share| share < 1.0) || (share.is_none() && reach.is_infinite()))
    {
        error(
            "settings",
            "rotations go with share = 1 alone: of what is learned, the rest would be in the basis, whose rows say how far a vertex turns \
             with each handle; set share to 1, leave it out with a finite reach, or do without rotations"
                .into(),
        );
    }
    if !positive(face.metres_per_unit) {
        error("settings", format!("a unit is {} metres, expected a number above 0", face.metres_per_unit));
    }
    if let StrainEdges::Given(edges) = &settings.strain_edges {
        let h = handles.vertices.len();
        if let Some(i) = edges.iter().position(|e| e.iter().any(|&end| end.index() >= h)) {
            let [a, b] = edges[i];
            return error(
                "strain-edges",
                format!(
                    "strain edge {i} joins the handles {a} and {b}, expected two of the {h}, counted from 0"
                ),
            );
        }
        let at = |h: HandleId| mesh.positions.get(handles.vertices[h.index()].index());
        let flat: Vec<String> = edges
            .iter()
            .filter(|&&[a, b]| at(a).is_some() && at(a) == at(b))
            .map(|&[a, b]| format!("{}–{}", handles.labels[a.index()], handles.labels[b.index()]))
            .collect();
        if !flat.is_empty() {
            error(
                "strain-edges",
                format!(
                    "{} no length at rest: {}; leave out what joins a place to itself",
                    count(flat.len(), "strain edge has", "strain edges have"),
                    first_few(&flat)
                ),
            );
        }
    }
}

fn not_finite(positions: &[[f64; 3]]) -> Option<usize> {
    positions.iter().position(|p| p.iter().any(|c| !c.is_finite()))
}
